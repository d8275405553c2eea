// The current image, and the features where they are sent.

const WIDTH = 600;  // px, twice what the style shows
const COLOURS = {"-1": "#ffb04d", "1": "#58b0ff"};  // bright blobs, dark blobs

const figure = document.getElementById("picture");
const canvas = figure.querySelector("canvas");
const context = canvas.getContext("2d");

const STALE_MS = 2000;

// Either comes alone, or both: what no longer comes does not stay with the other.
let image = null;     // ImageBitmap
let features = null;  // {width, height, points}
let imageTime = 0, featuresTime = 0;  // ms, when it came
let hidden = false;

function draw() {
  const size = features ?? image;
  figure.hidden = hidden || !size;
  if (figure.hidden) return;
  canvas.width = WIDTH;
  canvas.height = Math.round(WIDTH * size.height / size.width);
  context.fillStyle = "#05070b";
  context.fillRect(0, 0, canvas.width, canvas.height);
  if (image) context.drawImage(image, 0, 0, canvas.width, canvas.height);
  const scale = WIDTH / size.width;
  const points = features?.points ?? [];
  for (let i = 0; i < points.length; i += 3) {
    context.fillStyle = COLOURS[points[i + 2]];
    context.beginPath();
    context.arc((points[i] + 0.5) * scale, (points[i + 1] + 0.5) * scale, 2.5, 0, 2 * Math.PI);
    context.fill();
  }
}

export async function showImage(blob) {
  try {
    const decoded = await createImageBitmap(new Blob([blob], {type: "image/jpeg"}));
    image?.close();
    image = decoded;
    imageTime = performance.now();
    if (imageTime - featuresTime > STALE_MS) features = null;
    draw();
  } catch {
    // No image after all: the one before stays.
  }
}

export function showFeatures(said) {
  features = said ?? null;
  featuresTime = performance.now();
  if (featuresTime - imageTime > STALE_MS) image = null;
  draw();
}

export function togglePicture() {
  hidden = !hidden;
  draw();
  return !hidden;
}
