// The published positions, joined where tracking was not lost between them.
import {InstancedInterleavedBuffer, InterleavedBufferAttribute} from "three";
import {LineMaterial} from "three/examples/jsm/lines/LineMaterial.js";
import {LineSegments2} from "three/examples/jsm/lines/LineSegments2.js";
import {LineSegmentsGeometry} from "three/examples/jsm/lines/LineSegmentsGeometry.js";

export class PathLine {
  constructor() {
    this.object = new LineSegments2(new LineSegmentsGeometry(),
      new LineMaterial({color: 0xff6f5e, linewidth: 3}));
    this.object.frustumCulled = false;
    this.room = 0;
    this.reserve(4096);
  }

  reserve(segments) {
    if (segments <= this.room) return;
    this.room = 2 * segments;
    this.buffer = new InstancedInterleavedBuffer(new Float32Array(6 * this.room), 6, 1);
    const geometry = this.object.geometry;
    geometry.dispose();
    geometry.setAttribute("instanceStart", new InterleavedBufferAttribute(this.buffer, 3, 0));
    geometry.setAttribute("instanceEnd", new InterleavedBufferAttribute(this.buffer, 3, 3));
  }

  update({path}) {
    this.reserve(path.length);
    let segments = 0;
    for (let i = 1; i < path.length; ++i) {
      if (!path[i][3]) continue;
      this.buffer.array.set(path[i - 1].slice(0, 3), 6 * segments);
      this.buffer.array.set(path[i].slice(0, 3), 6 * segments + 3);
      ++segments;
    }
    this.object.geometry.instanceCount = segments;
    this.object.visible = this.object.wanted !== false && segments > 0;
    this.buffer.needsUpdate = true;
  }
}
