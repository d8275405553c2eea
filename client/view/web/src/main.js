// The page of `eifmap view`.
import {listen} from "./feed.js";
import {bindKeys} from "./keys.js";
import {MapCopy} from "./map_copy.js";
import {showConnected, showPanel} from "./panel.js";
import {showFeatures, showImage, togglePicture} from "./picture.js";
import {World} from "./world.js";

const MAGNIFICATIONS = [1, 10, 100];

function openWorld() {
  try {
    return new World(document.getElementById("world"));
  } catch (error) {
    const banner = document.getElementById("event");
    banner.textContent = `The map cannot be drawn, this browser has no WebGL (${error.message}): ` +
      "try another one, or allow it in its settings.";
    banner.hidden = false;
    return null;
  }
}

const copy = new MapCopy();
window.eifmap = {copy};  // for whoever wants to look closer
const world = openWorld();

// Shows or hides an object; the next update keeps to it.
function toggle(part) {
  const object = part.object;
  object.wanted = object.wanted === false;
  object.visible = object.wanted;
  return object.visible;
}

function magnify() {
  const next = MAGNIFICATIONS.indexOf(world.pose.magnified) + 1;
  world.pose.magnified = MAGNIFICATIONS[next % MAGNIFICATIONS.length];
  world.pose.update(copy);
  return `ellipsoid, 3 sigma × ${world.pose.magnified}`;
}

function flip(part, field) {
  part[field] = !part[field];
  world.points.update(copy);
  return part[field];
}

const worldActions = world && [
  {key: "F", name: "fit to view", run: () => { world.following = false; world.fitting = true; }},
  {key: "C", name: "follow the camera", on: false, run: () => (world.following = !world.following)},
  {key: "T", name: "trajectory", on: true, run: () => toggle(world.path)},
  {key: "K", name: "keyframes", on: true, run: () => toggle(world.keyframes)},
  {key: "P", name: "points", on: true, run: () => toggle(world.points)},
  {key: "U", name: "uncertain points too", on: false, run: () => flip(world.points, "withUncertain")},
  {key: "B", name: "bright and dark blobs", on: false, run: () => flip(world.points, "bySign")},
  {key: "E", name: "ellipsoid, 3 sigma × 1", run: magnify},
];

bindKeys([...(worldActions ?? []), {key: "I", name: "image", on: true, run: togglePicture}]);

listen({
  onConnected: (is) => showConnected(is, copy),
  onPicture: showImage,
  onMessage: (message) => {
    const changed = copy.apply(message);
    showPanel(copy);
    if (changed.has("features")) showFeatures(copy.sections.features);
    world?.update(copy, changed);
  },
});
