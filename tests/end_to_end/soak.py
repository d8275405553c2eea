#!/usr/bin/env python3
"""Four cameras on one server whose maps are at their bound, and twenty loggers of which five are
stopped (SIGSTOP) half-way and stay so. Run it in a private network (support/private_network.sh).
What is published must have the simulated camera's calibration, as the places before have it.

What must hold:
- No pose is later for it: the time from a frame's departure to its pose's arrival, by the kernel's
  clock, has after the stop a 99th percentile of at most 1.5 times that of before, and 20 ms. So has
  the server's own latency_ms_p99, where there is time for some of its windows of 256 frames.
- Every frame that was processed has its pose in a logger that runs. LCM promises none of them every
  message, a machine in a hurry loses some: asked for is that 99 % of them are in the logs of the
  camera's running loggers taken together, none that was never sent, and in no log one twice.
- Every frame is accounted for, exactly: received = sent - sequence gaps, and processed + dropped +
  rejected = received. Frames that lost parts are received, those that lost all are gaps. The last
  one of each camera is sent to an idle server, so that what was lost before it shows as a gap.
- The server's memory does not grow once maps are at their bound, and as many are kept as may be:
  judged where there are minutes.
"""
import argparse
import json
import pathlib
import signal
import tempfile
import time

from playback import Cameras, PoseListener, Recording
from processes import Processes, fail, lines, shared

CAMERAS = "abcd"
RATE_HZ = 10
LOGGERS, STOPPED = 20, 5
# Where each camera was before: as many places as maps are kept, and unlike where it is then. Else it
# is chance when a camera is lost, and has one map more.
BEFORE = [["--simulate", world, "--motion", motion, "--max-frames", "80"]
          for world, motion in (("block", "lap"), ("street", "drive"))]
KEPT = len(BEFORE)
# The least that can be asked for.
MAPPER = {"bound": {"max_keyframes": 20, "max_landmarks": 500}, "lost": {"max_kept_maps": KEPT}}
LONG_S = 120  # from here on there is enough to judge growth and the server's own latencies
MAX_GROWTH = 1.0  # MB/min
LATER, LATER_MS = 1.5, 20


class Loggers:
    """Number i is of camera i mod 4; those stopped are of all cameras."""

    def __init__(self, processes, client, folder):
        self.folder = folder
        self.all = [processes.start(f"logger{i}", client, "log", folder / f"logged{i}", "--camera",
                                    self.camera(i)) for i in range(LOGGERS)]
        for logger in self.all:
            logger.wait_for_words("logging")
        self.poses_at_stop = []

    @staticmethod
    def camera(i):
        return CAMERAS[i % len(CAMERAS)]

    def of(self, camera):
        """Folders of those that run."""
        return [self.folder / f"logged{i}" for i in range(STOPPED, LOGGERS)
                if self.camera(i) == camera]

    def poses_of_stopped(self):
        return [len(lines(self.folder / f"logged{i}" / "poses.jsonl")) for i in range(STOPPED)]

    def stop_some(self):
        for logger in self.all[:STOPPED]:
            logger.child.send_signal(signal.SIGSTOP)
        time.sleep(0.05)
        self.poses_at_stop = self.poses_of_stopped()

    def check_stopped(self):
        if min(self.poses_at_stop) == 0 or self.poses_of_stopped() != self.poses_at_stop:
            fail(f"loggers with {self.poses_at_stop} poses were stopped and have now "
                 f"{self.poses_of_stopped()}")

    def wait_for_end(self):
        for logger in self.all[STOPPED:]:
            logger.wait_for_end()


def play(cameras, loggers, seconds):
    """When it began and when some were stopped, us."""
    begin, begin_us = time.monotonic(), time.time_ns() // 1000
    cameras.play_until(begin + seconds / 2)
    stop_us = time.time_ns() // 1000
    loggers.stop_some()
    cameras.play_until(begin + seconds)
    cameras.send_last()
    return begin_us, stop_us


def run(options, folder):
    config = folder / "config.json"
    config.write_text(json.dumps({"mapper": MAPPER}))
    with Processes(folder) as processes:
        recording = Recording(processes, options.client, options.publish)
        before = [Recording(processes, options.client, what) for what in BEFORE]
        cameras = Cameras(CAMERAS, recording, RATE_HZ, before)
        server = processes.start("server", options.server, "--maps", folder / "maps", "--config",
                                 config)
        server.wait_for_words("listening on")
        loggers = Loggers(processes, options.client, folder)
        listener = PoseListener()
        times = play(cameras, loggers, options.seconds)
        time.sleep(2.5)  # two periods of the status
        loggers.check_stopped()
        server.child.send_signal(signal.SIGTERM)
        server.wait_for_end()
        loggers.wait_for_end()
        listener.stop()
    return cameras, loggers, listener, times


def statuses_of(loggers, camera):
    """Of all that run, each once."""
    said = {status["utime"]: status for folder in loggers.of(camera)
            for status in map(json.loads, lines(folder / "status.jsonl"))
            if status["camera"] == camera}
    return [said[utime] for utime in sorted(said)]


def check_counts(camera, last):
    sent, name = len(camera.sent_us), camera.name
    received, gaps = last["frames_received"], last["sequence_gaps"]
    if received != sent - gaps:
        fail(f"{name}: {sent} frames were sent and {gaps} are missing, but {received} received")
    done = {key: last["frames_" + key] for key in ("processed", "dropped", "rejected")}
    if sum(done.values()) != received:
        fail(f"{name}: of {received} frames {done}")
    if last["bad_messages"] or last["diagnostics"]["publisher_restarts"] != "0":
        fail(f"{name}: what was sent was good, and from one publisher: {last}")
    return done


def check_poses(name, loggers, sent, processed):
    """How many of the processed frames' poses are in no running logger."""
    numbers = set()
    for folder in loggers.of(name):
        logged = [json.loads(line)["seq"] for line in lines(folder / "poses.jsonl")]
        if len(set(logged)) != len(logged) or not set(logged) <= set(range(sent)):
            fail(f"{folder.name} has a pose twice, or of a frame that was never sent")
        numbers.update(logged)
    missing = processed - len(numbers)
    if not 0 <= missing <= 0.01 * processed:
        fail(f"{name}: {processed} frames were processed, {len(numbers)} have a logged pose")
    return missing


def at_bound_s(statuses, begin_us):
    """From when on as many maps are kept as may be, and something was taken out of the one in use."""
    for status in statuses:
        said = status["diagnostics"]
        removed = int(said["bound.removed_keyframes"]) + int(said["bound.removed_landmarks"])
        if int(said["submaps.kept"]) == KEPT and removed > 0:
            return (status["utime"] - begin_us) / 1e6
    return float("inf")


def growth(statuses):
    """Of the last half: slope of the least squares line, MB/min."""
    middle = (statuses[0]["utime"] + statuses[-1]["utime"]) / 2
    points = [(s["utime"] / 6e7, s["rss_bytes"] / 1e6) for s in statuses if s["utime"] > middle]
    x = sum(p[0] for p in points) / len(points)
    y = sum(p[1] for p in points) / len(points)
    return (sum((p[0] - x) * (p[1] - y) for p in points) /
            sum((p[0] - x) ** 2 for p in points))


def percentile(values, share):
    return sorted(values)[int(share * (len(values) - 1))]


def delays(cameras, listener, begin_us, end_us):
    """ms from departure to the pose's arrival, of the frames that left in that time."""
    return [(listener.heard_us[camera.name, seq] - sent) / 1000
            for camera in cameras.all for seq, sent in enumerate(camera.sent_us)
            if begin_us <= sent < end_us and (camera.name, seq) in listener.heard_us]


def check_later(what, before, after):
    if after > LATER * before + LATER_MS:
        fail(f"{what}: {before:.1f} ms before loggers were stopped, {after:.1f} ms after")


def own_latencies(said, stop_us):
    """The worst camera's latency_ms_p99, ms: when some were stopped, and at the end."""
    return (max([s for s in statuses if s["utime"] < stop_us][-1]["latency_ms_p99"]
                for statuses in said.values()),
            max(statuses[-1]["latency_ms_p99"] for statuses in said.values()))


def judge(options, cameras, loggers, listener, times):
    begin_us, stop_us = times
    said = {name: statuses_of(loggers, name) for name in CAMERAS}
    last = {name: statuses[-1] for name, statuses in said.items()}
    total = {key: sum(status[key] for status in last.values())
             for key in ("frames_received", "frames_processed", "frames_dropped", "frames_rejected",
                         "sequence_gaps", "keyframes", "landmarks")}
    bound_s = max(at_bound_s(statuses, begin_us) for statuses in said.values())
    warm_us = begin_us + (stop_us - begin_us) // 2
    heard = [delays(cameras, listener, warm_us, stop_us),
             delays(cameras, listener, stop_us, cameras.all[0].sent_us[-1])]
    p50 = [percentile(values, 0.5) for values in heard]
    p99 = [percentile(values, 0.99) for values in heard]
    own = own_latencies(said, stop_us)
    mb_per_min = growth(said["a"])
    incomplete = sum(int(status["diagnostics"].get("split_frames.incomplete", 0))
                     for status in last.values())
    print(f"{options.seconds:.0f} s: sent {sum(len(c.sent_us) for c in cameras.all)}, {total}, "
          f"incomplete {incomplete}, at bound after {bound_s:.1f} s; departure to pose p50 "
          f"{p50[0]:.1f} -> {p50[1]:.1f} ms, p99 {p99[0]:.1f} -> {p99[1]:.1f} ms, server's p99 "
          f"{own[0]:.1f} -> {own[1]:.1f} ms; RSS {last['a']['rss_bytes'] / 1e6:.1f} MB, "
          f"{mb_per_min:+.2f} MB/min", flush=True)
    missing = 0
    for camera in cameras.all:
        done = check_counts(camera, last[camera.name])
        missing += check_poses(camera.name, loggers, len(camera.sent_us), done["processed"])
    print(f"poses in no running logger: {missing}")
    if bound_s > options.seconds / 3:
        fail(f"the maps came to their bound after {bound_s:.1f} s: this shows nothing")
    check_later("departure to pose, 99 %", *p99)
    if options.seconds < LONG_S:
        return
    check_later("the server's latency_ms_p99", *own)
    if mb_per_min > MAX_GROWTH:
        fail(f"the server grows by {mb_per_min:.2f} MB/min")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("--client", required=True)
    parser.add_argument("--seconds", type=float, default=120)
    parser.add_argument("--keep", type=pathlib.Path, help="a folder for what was logged")
    parser.add_argument("--publish", required=True, nargs=argparse.REMAINDER)
    options = parser.parse_args()
    options.publish = [shared(argument) for argument in options.publish]
    with tempfile.TemporaryDirectory() as name:
        folder = options.keep or pathlib.Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        judge(options, *run(options, folder))


main()
