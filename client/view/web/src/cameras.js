// Keyframes and the current pose as frusta, and the ellipsoid of the current position.
import {BufferAttribute, BufferGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh,
  MeshBasicMaterial, Quaternion, SphereGeometry, Vector3} from "three";

const LENS = {half_width: 0.65, half_height: 0.49};  // until the calibration has come

// Ends of the lines of a frustum of this depth, in the camera's frame: x right, y down, z forward.
function frustumLines(lens, depth) {
  const x = depth * lens.half_width, y = depth * lens.half_height, tip = [0, 0, 0];
  const corners = [[-x, -y, depth], [x, -y, depth], [x, y, depth], [-x, y, depth]];
  const roof = [0, -1.35 * y, depth];  // says which way is up
  const pairs = corners.flatMap((corner, i) => [[tip, corner], [corner, corners[(i + 1) % 4]]]);
  return [...pairs, [corners[0], roof], [roof, corners[1]]].flat();
}

function lines(colour, opacity) {
  const object = new LineSegments(new BufferGeometry(),
    new LineBasicMaterial({color: colour, transparent: opacity < 1, opacity}));
  object.frustumCulled = false;
  return object;
}

function setPoints(object, points) {
  object.geometry.dispose();
  object.geometry.setAttribute("position", new BufferAttribute(new Float32Array(points.flat()), 3));
  object.visible = object.wanted !== false && points.length > 0;
}

export class KeyframeFrusta {
  constructor() {
    this.object = lines(0xa9c3e8, 0.55);
    this.depth = 0.2;  // map units
  }

  update({keyframes, sections}) {
    const shape = frustumLines(sections.lens ?? LENS, this.depth);
    const at = new Vector3(), turn = new Quaternion(), points = [];
    for (const {position, quaternion} of keyframes.values()) {
      turn.fromArray(quaternion);
      for (const end of shape) {
        at.fromArray(end).applyQuaternion(turn);
        points.push([at.x + position[0], at.y + position[1], at.z + position[2]]);
      }
    }
    setPoints(this.object, points);
  }
}

export class CurrentPose {
  constructor() {
    this.frustum = lines(0xffffff, 1);
    this.ellipsoid = new Mesh(new SphereGeometry(1, 24, 16), new MeshBasicMaterial({
      color: 0xe58cff, wireframe: true, transparent: true, opacity: 0.45, side: DoubleSide}));
    this.ellipsoid.matrixAutoUpdate = false;
    this.ellipsoid.frustumCulled = false;
    this.object = new Group().add(this.frustum, this.ellipsoid);
    this.object.visible = false;
    this.depth = 0.5;      // map units
    this.magnified = 1;    // the ellipsoid
    this.position = null;  // [x, y, z] in the map
  }

  update({sections}) {
    const pose = sections.pose;
    this.object.visible = Boolean(pose);
    this.position = pose ? pose.position : null;
    if (!pose) return;
    const [w, x, y, z] = pose.quaternion;
    setPoints(this.frustum, frustumLines(sections.lens ?? LENS, this.depth));
    this.frustum.position.fromArray(pose.position);
    this.frustum.quaternion.set(x, y, z, w);
    this.frustum.material.color.set(pose.current ? 0xffffff : 0x8a6a6a);
    this.updateEllipsoid(pose);
  }

  updateEllipsoid({ellipsoid, position}) {
    this.ellipsoid.visible = Boolean(ellipsoid);
    if (!ellipsoid) return;
    const axes = [0, 3, 6].map((i) =>
      new Vector3().fromArray(ellipsoid, i).multiplyScalar(this.magnified));
    this.ellipsoid.matrix = new Matrix4().makeBasis(...axes).setPosition(...position);
    this.ellipsoid.matrixWorldNeedsUpdate = true;
  }
}
