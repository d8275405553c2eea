// A page that is there from the start, one that comes late, a server that starts after them, maps
// a simulated courtyard, stops, and comes back: page_test.sh says how it is run.
import {setTimeout as sleep} from "node:timers/promises";
import {chromium} from "playwright-core";
import {Child, killAll, until} from "./processes.mjs";

const [executablePath, work, server, client, keepAs, images] = process.argv.slice(2);
const FRAMES = Number(images ?? 160), RATE = 10;  // images, images a second

function expect(is, what) {
  if (!is) throw new Error(what);
  console.log(`ok: ${what}`);
}

const start = (name, command, ...options) => new Child(work, name, command, ...options);
const publish = (name, frames, as) => start(name, client, "publish", "--simulate", "courtyard",
  "--rate", RATE, "--max-frames", frames, "--as", as);

async function openPage(browser, url, problems) {
  const page = await browser.newPage({viewport: {width: 1280, height: 800}});
  page.on("pageerror", (error) => problems.push(String(error)));
  page.on("console", (message) => {
    // That the program is gone is part of the test.
    if (message.type() === "error" && !message.text().includes("WebSocket")) problems.push(message.text());
  });
  await page.goto(url);
  return page;
}

const text = (page, id) => page.locator(`#${id}`).textContent();

async function counts(page) {
  const of = async (id) => Number((await text(page, id)).replaceAll(",", ""));
  return {poses: await of("poses"), keyframes: await of("keyframes"), landmarks: await of("landmarks")};
}

// All that the page holds of the map and the path, and says of state and pose.
const wholeCopy = (page) => page.evaluate(() => {
  const {sections: {state, pose, lens, camera}, path, keyframes, landmarks} = window.eifmap.copy;
  return JSON.stringify([state, pose, lens, camera, path, [...keyframes].sort((a, b) => a[0] - b[0]), [...landmarks].sort((a, b) => a[0] - b[0])]);
});

// How many of a picture's pixels differ clearly from the one above them, and how many colours and grays it has.
async function liveliness(page, locator) {
  const png = (await locator.screenshot()).toString("base64");
  const script = async (data) => {
    const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], {type: "image/png"}));
    const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const pixels = context.getImageData(0, 0, image.width, image.height).data;
    const colours = new Set(), grays = new Set(), row = 4 * image.width;
    let edges = 0;
    for (let i = row; i < pixels.length; i += 4) {
      colours.add(pixels[i] << 16 | pixels[i + 1] << 8 | pixels[i + 2]);
      if (pixels[i] === pixels[i + 1] && pixels[i] === pixels[i + 2]) grays.add(pixels[i]);
      if (Math.abs(pixels[i + 1] - pixels[i + 1 - row]) > 24) ++edges;
    }
    return {edges, colours: colours.size, grays: grays.size};
  };
  return page.evaluate(script, png);
}

async function hideAllButTheWorld(page, hide) {
  await page.evaluate((hide) => {
    for (const one of document.querySelectorAll("#panel, #keys, #picture, #banners"))
      one.style.visibility = hide ? "hidden" : "";
  }, hide);
}

async function worldLiveliness(page) {
  await hideAllButTheWorld(page, true);
  const result = await liveliness(page, page.locator("#world"));
  await hideAllButTheWorld(page, false);
  return result;
}

async function run(browser) {
  const problems = [];
  const view = start("view", client, "view", "--port", "0");
  const [, url] = await view.says(/open (http:\S+) in a browser/);
  const early = await openPage(browser, url, problems);
  await until(async () => /no server heard for \d+ s/.test(await text(early, "silence")), "the silence to be said");
  expect(await early.locator("#silence").isVisible(), "without a server the page says for how long");
  const empty = await worldLiveliness(early);

  const first = start("server1", server);
  await until(async () => await text(early, "state") === "WAITING", "the server to be heard");
  expect(!await early.locator("#silence").isVisible(), "the silence is over when a server is heard");

  const publisher = publish("publisher1", FRAMES, "features");
  await until(async () => (await counts(early)).landmarks > 0, "landmarks");
  const before = await counts(early);
  await until(async () => (await counts(early)).poses > before.poses + 30, "the path to grow");
  const after = await counts(early);
  expect(after.landmarks > before.landmarks && after.keyframes > before.keyframes,
    `the map grows: ${JSON.stringify(before)}, then ${JSON.stringify(after)}`);
  expect(await text(early, "state") === "TRACKING", "the state is TRACKING");
  expect(/^[1-9].* poses\/s/.test(await text(early, "rate")), `there is a rate: ${await text(early, "rate")}`);

  const late = await openPage(browser, url, problems);
  await until(async () => (await counts(late)).landmarks >= after.landmarks, "the late page to have the map");
  await until(async () => (await counts(late)).poses > (keepAs ? 0.75 : 0.3) * FRAMES, "poses", 60 + FRAMES / RATE);
  await late.screenshot({path: keepAs ?? `${work}/view.png`});
  expect(await publisher.ended === 0, "all images were published");
  // Whatever was on its way has come when nothing changes any more.
  let last = "";
  const settled = async () => last === (last = JSON.stringify(await counts(early)));
  await until(() => sleep(2000).then(settled), "the map to be whole");
  await until(async () => await wholeCopy(early) === await wholeCopy(late), "the late page to hold what the early one does");
  expect(last === JSON.stringify(await counts(late)), `a late page shows the same as an early one: ${last}`);

  // What is drawn, not only counted.
  const drawn = await worldLiveliness(late);
  await late.keyboard.press("p");
  const pointless = await worldLiveliness(late);
  await late.keyboard.press("k");
  const frameless = await worldLiveliness(late);
  await late.keyboard.press("t");
  const pathless = await worldLiveliness(late);
  const edges = [drawn, pointless, frameless, pathless, empty].map((picture) => picture.edges);
  expect(edges[0] > edges[1] + 3000 && edges[1] > edges[2] + 200 && edges[2] > edges[3] + 200 && edges[4] < 50,
    `points, keyframes and path are drawn: ${edges.join(", ")} edges without them, one after the other`);
  const features = await liveliness(late, late.locator("#picture canvas"));
  expect(features.edges > 500, `the features are drawn: ${features.edges} edges`);

  expect(await first.stop() === 0, "the server stops when it is told to");
  await until(async () => await text(early, "state") === "STOPPED", "the stop to be said");
  const second = start("server2", server);
  const again = publish("publisher2", 40, "mjpeg");
  for (const page of [early, late])
    await until(async () => await text(page, "event") === "server restarted: a new map" &&
      await page.locator("#event").isVisible(), "the restart to be said");
  await until(async () => (await counts(late)).poses < 45, "the old path to go");
  expect(true, "a restart of the server is shown on both pages, and the old map is gone");
  const picture = early.locator("#picture canvas");
  await until(async () => (await liveliness(early, picture)).grays > 60, "the image to be drawn");
  expect(await again.ended === 0 && await second.stop() === 0, "the second server too stops");

  expect(await view.stop() === 0, "the view stops when it is told to");
  await until(async () => /is it still running/.test(await text(early, "silence")), "the view's end to be said");
  expect(problems.length === 0, `the pages had no errors ${problems.join("; ")}`);
}

let code = 1;
const root = process.getuid() === 0;
try {
  const browser = await chromium.launch({executablePath, args: [
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...(root ? ["--no-sandbox"] : [])]});
  try {
    await run(browser);
    code = 0;
  } finally {
    await browser.close();
  }
} catch (error) {
  console.error(`FAILED: ${error.message}`);
} finally {
  killAll();
}
process.exit(code);
