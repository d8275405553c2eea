#!/usr/bin/env python3
"""Server, publisher and logger as three processes over udpm, against the offline run.

The logger's trajectory.tum must be the offline trajectory.tum byte for byte where no frame was
dropped, and hold at least 95 % of it. With --before, another recording comes first, of a camera that
stands still: no map may come of it, the status must say NO_BASELINE, and what follows must be mapped as
if nothing had been. Run it inside a private network (support/private_network.sh).
"""
import argparse
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
PATIENCE_S = 240


def fail(message):
    sys.exit("FAILED: " + message)


def shared(name):
    """shared:NAME is a sequence of the shared data, which may not be there."""
    if not name.startswith("shared:"):
        return name
    source = pathlib.Path(__file__).resolve().parents[2]
    root = pathlib.Path(os.environ.get("EIFMAP_SHARED", source.parent / "shared"))
    folder = root / "data" / name[len("shared:"):]
    if not folder.is_dir():
        print(f"skipped: no {folder}")
        sys.exit(SKIPPED)
    return str(folder)


class Process:
    """A child whose output goes to a file; whatever happens, it does not outlive the test."""

    def __init__(self, name, command, folder):
        self.name = name
        self.output = folder / (name + ".log")
        with open(self.output, "wb") as output:
            self.child = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)

    def text(self):
        return self.output.read_text(errors="replace")

    def wait_for_words(self, words):
        deadline = time.monotonic() + PATIENCE_S
        while words not in self.text():
            if self.child.poll() is not None or time.monotonic() > deadline:
                fail(f"{self.name} never said '{words}':\n{self.text()}")
            time.sleep(0.05)

    def wait_for_end(self):
        try:
            code = self.child.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            fail(f"{self.name} did not end:\n{self.text()}")
        if code != 0:
            fail(f"{self.name} ended with {code}:\n{self.text()}")

    def stop(self):
        if self.child.poll() is None:
            self.child.kill()
            self.child.wait()


def lines(file):
    return file.read_text().splitlines() if file.exists() else []


def expect_no_map(options, folder):
    frames = len(lines(pathlib.Path(options.before) / "times.txt"))
    wait_for_poses(folder / "logged" / "poses.jsonl", frames)
    poses = [json.loads(line) for line in lines(folder / "logged" / "poses.jsonl")]
    reasons = {pose["reason"] for pose in poses}
    if len(poses) < 0.95 * frames or reasons != {"NO_BASELINE"}:
        fail(f"{len(poses)} of {frames} frames of a standstill answered, with {reasons}")
    if lines(folder / "logged" / "trajectory.tum"):
        fail("a map was made of a standstill")
    print(f"standstill: {len(poses)} frames, no map, NO_BASELINE")
    options.frames += len(poses)


def wait_for_poses(file, count):
    """Until the logger has as many, or no more come."""
    newest, since = -1, time.monotonic()
    while newest < count and time.monotonic() - since < 10:
        now = len(lines(file))
        if now != newest:
            newest, since = now, time.monotonic()
        time.sleep(0.1)


def run_live(options, folder):
    started = []

    def start(name, *command):
        started.append(Process(name, command, folder))
        return started[-1]

    try:
        server = start("server", options.server, "--input", "lossless", "--output", folder / "live")
        server.wait_for_words("listening on")
        logger = start("logger", options.client, "log", folder / "logged")
        logger.wait_for_words("logging")
        if options.before:
            start("standstill", options.client, "publish", options.before).wait_for_end()
            expect_no_map(options, folder)
        publisher = start("publisher", options.client, "publish", *options.publish)
        publisher.wait_for_end()
        wait_for_poses(folder / "logged" / "poses.jsonl", options.frames)
        server.child.send_signal(signal.SIGTERM)
        server.wait_for_end()
        logger.wait_for_end()
    finally:
        for process in reversed(started):
            process.stop()


def last_status(folder):
    return json.loads(lines(folder / "logged" / "status.jsonl")[-1])


def compare(folder):
    offline = lines(folder / "offline" / "trajectory.tum")
    logged = lines(folder / "logged" / "trajectory.tum")
    if len(offline) < 10:
        fail(f"the offline run tracked {len(offline)} frames: this shows nothing")
    same = set(offline) & set(logged)
    status = last_status(folder)
    lost = status["sequence_gaps"] + status["frames_dropped"]
    print(f"offline {len(offline)} poses, logged {len(logged)}, the same to the bit {len(same)}; "
          f"frames lost on the way: {lost}")
    if len(same) < 0.95 * len(offline):
        fail("less than 95 % of the offline trajectory was logged")
    if lost == 0 and logged != offline:
        fail("no frame was lost, but the logged trajectory is another")
    final = [lines(folder / run / "trajectory_final.tum") for run in ("offline", "live")]
    if lost == 0 and final[0] != final[1]:
        fail("no frame was lost, but the final trajectory is another")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("--client", required=True)
    parser.add_argument("--offline", required=True, help="recorded folder for the offline run")
    parser.add_argument("--before", help="recorded folder of a camera that stands still")
    parser.add_argument("--publish", required=True, nargs=argparse.REMAINDER)
    options = parser.parse_args()
    options.offline = shared(options.offline)
    options.before = options.before and shared(options.before)
    options.publish = [shared(argument) for argument in options.publish]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([options.server, "--sequence", options.offline,
                        "--output", folder / "offline"], check=True)
        options.frames = len(lines(pathlib.Path(options.offline) / "times.txt"))
        run_live(options, folder)
        compare(folder)


main()
