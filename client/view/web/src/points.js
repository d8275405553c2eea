// Landmarks as points.
import {BufferAttribute, BufferGeometry, CanvasTexture, Points, PointsMaterial, Quaternion, Vector3} from "three";

// As the demo's picture, a little brighter: blue for low, over teal and green, to pale yellow for high.
const HEIGHTS = [[92, 104, 214], [52, 140, 205], [46, 178, 152], [140, 212, 96], [250, 226, 110]];
const SIGNS = {"-1": [255, 176, 77], "1": [88, 176, 255]};  // bright blobs, dark blobs
const SIZE = 3.5;  // px
const UNCERTAIN = 0.2;  // sigma by distance from the first camera that saw it

function disc() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 32;
  const context = canvas.getContext("2d");
  context.fillStyle = "white";
  context.arc(16, 16, 15, 0, 2 * Math.PI);
  context.fill();
  return new CanvasTexture(canvas);
}

// The values at the given shares of the sorted list.
export function quantiles(values, shares) {
  const sorted = Float32Array.from(values).sort();
  return shares.map((share) => sorted[Math.round(share * (sorted.length - 1))]);
}

function heightColour(level) {
  const at = Math.min(Math.max(level, 0), 1) * (HEIGHTS.length - 1);
  const k = Math.min(Math.floor(at), HEIGHTS.length - 2);
  return HEIGHTS[k].map((low, i) => low + (at - k) * (HEIGHTS[k + 1][i] - low));
}

// sRGB bytes -> the linear values that three.js computes with.
const linear = (byte) => ((byte / 255 + 0.055) / 1.055) ** 2.4;

export class LandmarkPoints {
  constructor() {
    this.object = new Points(new BufferGeometry(), new PointsMaterial({
      size: SIZE * devicePixelRatio, sizeAttenuation: false, vertexColors: true, map: disc(), alphaTest: 0.5}));
    this.object.frustumCulled = false;
    this.bySign = false;
    this.withUncertain = false;
    this.count = 0;  // of what is drawn
    this.room = 0;
    this.reserve(1024);
  }

  reserve(count) {
    if (count <= this.room) return;
    this.room = 2 * count;
    this.positions = new Float32Array(3 * this.room);  // in the map
    this.colours = new Float32Array(3 * this.room);
    this.signs = new Int8Array(this.room);
    this.object.geometry.dispose();
    this.object.geometry.setAttribute("position", new BufferAttribute(this.positions, 3));
    this.object.geometry.setAttribute("color", new BufferAttribute(this.colours, 3));
  }

  // Of what is drawn, one coordinate.
  along(axis) {
    return Float32Array.from({length: this.count}, (_, i) => this.positions[3 * i + axis]);
  }

  // Landmarks are kept in the frame of their first keyframe: those whose keyframe has not come wait.
  update({keyframes, landmarks}) {
    this.reserve(landmarks.size);
    const at = new Vector3(), origin = new Vector3(), turn = new Quaternion();
    let count = 0;
    for (const {anchor, position, sign, sigma} of landmarks.values()) {
      const keyframe = keyframes.get(anchor);
      if (!keyframe) continue;
      at.fromArray(position);
      if (!this.withUncertain && (sigma < 0 || sigma > UNCERTAIN * at.length())) continue;
      at.applyQuaternion(turn.fromArray(keyframe.quaternion)).add(origin.fromArray(keyframe.position));
      at.toArray(this.positions, 3 * count);
      this.signs[count++] = sign;
    }
    this.count = count;
    this.paint();
    const {geometry} = this.object;
    geometry.setDrawRange(0, count);
    geometry.getAttribute("position").needsUpdate = geometry.getAttribute("color").needsUpdate = true;
  }

  // The map's y points down; a stray point does not take all the colours.
  paint() {
    if (this.count === 0) return;
    const heights = this.along(1).map((y) => -y);
    const [low, high] = quantiles(heights, [0.02, 0.98]);
    heights.forEach((height, i) => {
      const rgb = this.bySign ? SIGNS[this.signs[i]] : heightColour((height - low) / (high - low || 1));
      this.colours.set(rgb.map(linear), 3 * i);
    });
  }
}
