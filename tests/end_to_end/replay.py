#!/usr/bin/env python3
"""A live server that maps the newest image, over udpm, and its run made again from the log's decisions.

Which images it took, and when a keyframe's map was there, was up to the machine. The replay of the
recorded images with the decisions that were logged must give the logged trajectory byte for byte, and
the live server's own results. With --metric, positions made from the recording's truth are published
next to the images: the map must become metric, live, and the log must end with the metric map and path;
which image each measurement came before was up to the machine, too. Run it inside a private network
(support/private_network.sh).
"""
import json
import math
import pathlib
import struct
import subprocess
import tempfile

from processes import fail, lines, live_options, measure, parse_live, run_live

SCALE_WITHIN = 0.02


def replay(options, folder, decisions, measurements=None):
    """The exit code and what was said."""
    command = [options.server, "--sequence", options.offline, "--output", folder / "again",
               "--decisions", decisions]
    if options.metric:
        command += ["--measurements", measurements or folder / "logged" / "measurements.jsonl"]
    run = subprocess.run(command, capture_output=True, text=True)
    return run.returncode, run.stderr


def points(file):
    """Of a map.ply."""
    body = file.read_bytes().partition(b"end_header\n")[2]
    return [point[:3] for point in struct.iter_unpack("<fff3Bi", body)]


def expect_metric(options, folder, sent):
    status = json.loads(lines(folder / "logged" / "status.jsonl")[-1])
    poses = [json.loads(line) for line in lines(folder / "logged" / "poses.jsonl")]
    figures = {key: value for key, value in status["diagnostics"].items() if "measurements" in key}
    print(f"scale {status['scale']}, {status['metres_per_unit']:.4f} m a unit, {figures}")
    if status["scale"] != "metric" or status["map_epoch"] != 1:
        fail(f"the map is not metric in the end: {status}")
    if figures["measurements.arrived"] != str(sent) or figures["measurements.missing"] != "0":
        fail(f"{sent} measurements were sent, {figures}")
    if len(lines(folder / "logged" / "measurements.jsonl")) != sent:
        fail("not every measurement was logged")
    for pose in poses:
        if (pose["scale"] == "metric") != (pose["map_epoch"] == 1):
            fail(f"scale and epoch of a pose disagree: {pose}")
    if not 5 < sum(pose["map_epoch"] == 1 for pose in poses) < len(poses):
        fail("the map did not become metric on the way: this shows nothing")
    result = subprocess.run(
        [options.client, "eval", "--gt", pathlib.Path(options.offline) / "groundtruth.tum",
         "--est", folder / "logged" / "trajectory.tum", "--json"],
        check=True, capture_output=True, text=True)
    scale = json.loads(result.stdout)["scale"]
    print(f"the logged path in metres: scale {scale:.4f}")
    if not abs(scale - 1) <= SCALE_WITHIN:
        fail(f"the logged path is not in metres: {scale}")
    logged, live = points(folder / "logged" / "map.ply"), points(folder / "live" / "map.ply")
    # What moved by less than a hundredth of its depth is not sent again.
    off = max(math.dist(a, b) / (1 + math.hypot(*b)) for a, b in zip(logged, live))
    print(f"map of {len(live)} points, {len(logged)} logged, at most {off:.2g} of their distance off")
    if len(logged) != len(live) or not off < 0.03:
        fail("the logged map is not the server's")


def expect_a_gap_is_said(options, folder):
    """A measurement that the log has lost."""
    given = lines(folder / "logged" / "measurements.jsonl")
    fewer = folder / "fewer.jsonl"
    fewer.write_text("\n".join(given[:3] + given[4:]) + "\n")
    code, said = replay(options, folder, folder / "logged" / "decisions.jsonl", fewer)
    if code != 1 or "1 of the" not in said or "measurements that had a part" not in said:
        fail(f"a measurement that is missing was not noticed: {code}, {said}")


def expect_same(folder, live, again):
    of_live = (folder / live).read_bytes()
    if of_live != (folder / again).read_bytes():
        fail(f"{again} is not {live}")
    if of_live.count(b"\n") < 10:
        fail(f"{live} has hardly a line: this shows nothing")


def compare(options, folder):
    decisions = folder / "logged" / "decisions.jsonl"
    made = [json.loads(line) for line in lines(decisions)]
    adopted = sum(decision["adopted_job"] > 0 for decision in made)
    passed_over = options.frames - len(made)
    code, said = replay(options, folder, decisions)
    if code != 0:
        fail(f"the replay ended with {code}:\n{said}")
    print(f"{len(made)} images mapped, {passed_over} passed over; {adopted} keyframes adopted beside")
    expect_same(folder, "logged/trajectory.tum", "again/trajectory.tum")
    for file in ("trajectory_final.tum", "keyframes.tum", "decisions.jsonl", "map.ply"):
        expect_same(folder, "live/" + file, "again/" + file)
    if adopted < 3:
        fail("hardly a keyframe was adopted beside the frames: this shows nothing")
    if options.hurried and passed_over < 10:
        fail("hardly an image was passed over: this shows nothing")


def expect_a_departure(options, folder):
    """A decision that was another is noticed."""
    made = lines(folder / "logged" / "decisions.jsonl")
    adopting = next(i for i, line in enumerate(made) if json.loads(line)["adopted_job"] > 0)
    other = json.loads(made[adopting]) | {"adopted_job": 0}
    changed = folder / "changed.jsonl"
    changed.write_text("\n".join(made[:adopting] + [json.dumps(other)] + made[adopting + 1:]))
    code, said = replay(options, folder, changed)
    if code != 1 or "the replay departs from" not in said:
        fail(f"a keyframe adopted later was not noticed: {code}, {said}")


def main():
    parser = live_options(__doc__)
    parser.add_argument("--hurried", action="store_true", help="images must have been passed over")
    parser.add_argument("--metric", action="store_true", help="with measurements of the truth")
    parser.add_argument("--max-frames", type=int, default=0, help="publish the first ones alone")
    options = parse_live(parser)
    if options.max_frames:
        options.frames = min(options.frames, options.max_frames)
        options.publish += ["--max-frames", str(options.max_frames)]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        sent = measure(options, folder) if options.metric else 0
        run_live(options, folder, "newest")
        if options.metric:
            expect_metric(options, folder, sent)
        compare(options, folder)
        if options.metric:
            expect_a_gap_is_said(options, folder)
        expect_a_departure(options, folder)


main()
