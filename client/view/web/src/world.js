// The map in three dimensions, and from where one looks at it.
import {Group, PerspectiveCamera, Scene, Vector3, WebGLRenderer} from "three";
import {OrbitControls} from "three/examples/jsm/controls/OrbitControls.js";
import {CurrentPose, KeyframeFrusta} from "./cameras.js";
import {PathLine} from "./path.js";
import {LandmarkPoints, quantiles} from "./points.js";

const FIRST_VIEW = new Vector3(-0.35, 0.75, 0.9).normalize();  // from where: above and behind
const MEASURE_MS = 400;

export class World {
  // Throws where the browser has no WebGL.
  constructor(canvas) {
    this.renderer = new WebGLRenderer({canvas, antialias: true, alpha: true});
    this.renderer.setPixelRatio(devicePixelRatio);
    this.camera = new PerspectiveCamera(50, 1, 0.01, 1000);
    this.camera.position.copy(FIRST_VIEW).multiplyScalar(10);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.addEventListener("start", () => { this.fitting = false; });
    this.points = new LandmarkPoints();
    this.path = new PathLine();
    this.keyframes = new KeyframeFrusta();
    this.pose = new CurrentPose();
    // The map's y points down and its z forward: turned so that up is up.
    this.map = new Group().add(this.points.object, this.path.object, this.keyframes.object, this.pose.object);
    this.map.rotation.x = Math.PI;
    this.scene = new Scene().add(this.map);
    this.fitting = true;     // until somebody takes hold of the view
    this.following = false;  // the current pose
    this.unmeasured = null;  // the copy, where it has changed
    this.nextMeasure = 0;
    addEventListener("resize", () => this.resize());
    this.resize();
    this.renderer.setAnimationLoop(() => this.draw());
  }

  update(copy, changed) {
    const moved = changed.has("keyframes");
    if (moved || changed.has("landmarks")) this.points.update(copy);
    if (moved || changed.has("lens")) this.keyframes.update(copy);
    if (changed.has("path")) this.path.update(copy);
    if (changed.has("pose") || changed.has("lens")) this.pose.update(copy);
    if (moved || changed.has("path")) this.unmeasured = copy;
  }

  // Where most of it is, in the map, so that sizes and the view can be chosen.
  measure() {
    const copy = this.unmeasured;
    if (!copy || performance.now() < this.nextMeasure) return;
    this.unmeasured = null;
    this.nextMeasure = performance.now() + MEASURE_MS;
    const track = copy.path.length > 0 ? copy.path : [...copy.keyframes.values()].map((k) => k.position);
    if (track.length === 0) return;
    const centre = [], half = [];
    for (const axis of [0, 1, 2]) {
      const along = track.map((p) => p[axis]);
      let [low, high] = quantiles(along, [0, 1]);
      if (this.points.count > 20) {
        const [a, b] = quantiles(this.points.along(axis), [0.04, 0.96]);
        low = Math.min(low, a);
        high = Math.max(high, b);
      }
      centre.push((low + high) / 2);
      half.push((high - low) / 2);
    }
    this.centre = new Vector3(...centre);
    this.radius = Math.max(0.5, Math.hypot(...half));
    const depth = this.radius / 45;
    if (Math.abs(depth / this.keyframes.depth - 1) < 0.2) return;
    this.keyframes.depth = depth;
    this.pose.depth = 2.2 * depth;
    this.keyframes.update(copy);
    this.pose.update(copy);
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.renderer.domElement;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
  }

  // Glides to where everything is seen, from the side that it is seen from now.
  glideToFit() {
    const target = this.map.localToWorld(this.centre.clone());
    const half = Math.min(1, this.camera.aspect) * Math.tan(this.camera.fov * Math.PI / 360);
    const distance = 0.85 * this.radius / half;
    const from = this.camera.position.clone().sub(this.controls.target).setLength(distance);
    this.controls.target.lerp(target, 0.08);
    this.camera.position.lerp(target.add(from), 0.08);
  }

  // The view moves along with the pose, and turns as one likes.
  glideAlong() {
    const now = this.map.localToWorld(new Vector3(...this.pose.position));
    const step = now.sub(this.controls.target).multiplyScalar(0.15);
    this.controls.target.add(step);
    this.camera.position.add(step);
  }

  draw() {
    this.measure();
    if (this.following && this.pose.position) this.glideAlong();
    else if (this.fitting && this.radius) this.glideToFit();
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = distance / 500;
    this.camera.far = distance * 100 + 10 * (this.radius ?? 1);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.renderer.render(this.scene, this.camera);
  }
}
