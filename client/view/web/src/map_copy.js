// The page's copy of what is shown: a snapshot and increments in (view_model.h says what they are).

export class MapCopy {
  constructor() {
    this.sections = {};  // state, pose, server, ...: as last said
    this.clear();
  }

  clear() {
    this.path = [];  // [x, y, z, joined], map units
    this.keyframes = new Map();  // id -> {position, quaternion}
    this.landmarks = new Map();  // id -> {anchor, position, observations, sign, sigma}
  }

  // Returns what changed: a set of section names, and of path, keyframes, landmarks.
  apply(message) {
    const {snapshot, clear, path, keyframes, landmarks, removed_keyframes, removed_landmarks,
      ...sections} = message;
    const changed = new Set(Object.keys(sections));
    if (snapshot) {
      for (const what of Object.keys(this.sections)) changed.add(what);
      this.sections = {};
    }
    if (snapshot || clear) {
      this.clear();
      for (const what of ["path", "keyframes", "landmarks"]) changed.add(what);
    }
    Object.assign(this.sections, sections);
    if (path) this.takePath(path);
    if (keyframes) this.takeKeyframes(keyframes);
    if (landmarks) this.takeLandmarks(landmarks);
    for (const id of removed_keyframes ?? []) this.keyframes.delete(id);
    for (const id of removed_landmarks ?? []) this.landmarks.delete(id);
    if (path) changed.add("path");
    if (keyframes || removed_keyframes) changed.add("keyframes");
    if (landmarks || removed_landmarks) changed.add("landmarks");
    return changed;
  }

  takePath({from, steps}) {
    this.path.length = Math.min(this.path.length, from);
    for (let i = 0; i < steps.length; i += 4) this.path.push(steps.slice(i, i + 4));
  }

  takeKeyframes(list) {
    for (let i = 0; i < list.length; i += 8) {
      const [w, x, y, z] = list.slice(i + 4, i + 8);
      this.keyframes.set(list[i], {position: list.slice(i + 1, i + 4), quaternion: [x, y, z, w]});
    }
  }

  takeLandmarks(list) {
    for (let i = 0; i < list.length; i += 7)
      this.landmarks.set(list[i], {
        anchor: list[i + 1],
        position: list.slice(i + 2, i + 5),
        observations: Math.abs(list[i + 5]),
        sign: Math.sign(list[i + 5]),
        sigma: list[i + 6],
      });
  }
}
