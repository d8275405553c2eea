// The state of things in words and numbers.

const EVENT_SHOWN_MS = 15000;

const element = (id) => document.getElementById(id);
const say = (id, text) => { element(id).textContent = text ?? ""; };
const count = (n) => (n ?? 0).toLocaleString("en");
const fixed = (x, digits) => (x ?? 0).toFixed(digits);

// Two digits that count, whatever the map's unit is.
const threeSigma = (sigma) => Number((3 * sigma).toPrecision(2)).toString();

function showState({state = "NO SERVER", reason, text, hint} = {}) {
  say("state", state);
  element("state").dataset.state = state;
  say("reason", reason);
  say("text", text);
  say("hint", hint);
  document.title = `${state} - eifmap`;
}

function showServer(server) {
  if (!server) {
    for (const id of ["rate", "latency", "images", "server"]) say(id, "");
    return;
  }
  say("rate", `${fixed(server.pose_hz, 1)} poses/s of ${fixed(server.input_hz, 1)} images`);
  say("latency", `${fixed(server.latency_ms_p50, 0)} ms (99 %: ${fixed(server.latency_ms_p99, 0)} ms)`);
  say("images", `${count(server.processed)} mapped, ${count(server.dropped)} passed over, ` +
    `${count(server.rejected)} refused, ${count(server.gaps)} lost`);
  say("server", `${server.name} ${server.version} on ${server.host}, ` +
    `${fixed(server.rss_bytes / 1e6, 0)} MB`);
}

// Where the scale is unknown lengths have no unit.
const isMetric = (map) => map?.scale === "metric";
const percent = (x) => `${Number((100 * x).toPrecision(2))} %`;

function scaleText(map) {
  if (!isMetric(map)) return "no scale";
  return map.scale_sigma === null ? "in metres" : `in metres, scale ± ${percent(map.scale_sigma)}`;
}

function showPose(pose, map) {
  say("source", pose && pose.source.replaceAll("_", " ").toLowerCase());
  say("sigma", pose?.sigmas &&
    `${pose.sigmas.map(threeSigma).join(" × ")}${isMetric(map) ? " m" : ""}` +
    `${pose.optimistic ? ", optimistic" : ""}`);
}

function showMap(map, copy, server) {
  say("map", map?.id ? `number ${map.id}, ${scaleText(map)}` : "none yet");
  say("incomplete", map?.behind ? "Parts of the map have not arrived yet; the server is asked for them. " +
    `Shown are ${count(copy.landmarks.size)} of ${count(server?.landmarks)} landmarks.` : "");
}

let lastEvent = 0, connected = true, hideTimer = 0;

// Each event is shown for a while; a page that comes late shows the last one, if there is one.
function showEvents(events) {
  const last = events?.at(-1);
  if (!last) lastEvent = 0;  // another run of the view counts anew
  if (!last || last.number === lastEvent) return;
  lastEvent = last.number;
  say("event", last.text);
  element("event").hidden = false;
  clearTimeout(hideTimer);
  hideTimer = setTimeout(() => { element("event").hidden = true; }, EVENT_SHOWN_MS);
}

// That a server is silent after it has said that it stops is no news.
function showSilence({silence_s, state}) {
  const text = !connected ? "`eifmap view` is not heard any more: is it still running?" :
    silence_s > 0 && state?.state !== "STOPPED" ?
      `no server heard for ${silence_s} s: is eifmap-server running, with the same --lcm-url?` : "";
  say("silence", text);
  element("silence").hidden = !text;
}

export function showConnected(is, copy) {
  connected = is;
  showSilence(copy.sections);
}

export function showPanel(copy) {
  const {camera, state, server, pose, map, events} = copy.sections;
  say("camera", camera ? `camera ${camera}` : "");
  showState(state);
  showServer(server);
  showPose(pose, map);
  showMap(map, copy, server);
  showEvents(events);
  showSilence(copy.sections);
  say("poses", count(copy.path.length));
  say("keyframes", count(copy.keyframes.size));
  say("landmarks", count(copy.landmarks.size));
}
