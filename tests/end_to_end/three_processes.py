#!/usr/bin/env python3
"""Server, publisher and logger as three processes over udpm, against the offline run.

The logger's trajectory.tum must be the offline trajectory.tum byte for byte where no frame was
dropped, and hold at least 95 % of it. With --before, another recording comes first, of a camera that
stands still: no map may come of it, the status must say NO_BASELINE, and what follows must be mapped as
if nothing had been. Run it inside a private network (support/private_network.sh).
"""
import json
import pathlib
import tempfile

from processes import (fail, lines, live_options, map_offline, parse_live, run_live, shared,
                       wait_for_lines)


def stand_still(options, processes, folder):
    processes.start("standstill", options.client, "publish", options.before).wait_for_end()
    frames = len(lines(pathlib.Path(options.before) / "times.txt"))
    wait_for_lines(folder / "logged" / "poses.jsonl", frames)
    poses = [json.loads(line) for line in lines(folder / "logged" / "poses.jsonl")]
    reasons = {pose["reason"] for pose in poses}
    if len(poses) < 0.95 * frames or reasons != {"NO_BASELINE"}:
        fail(f"{len(poses)} of {frames} frames of a standstill answered, with {reasons}")
    if lines(folder / "logged" / "trajectory.tum"):
        fail("a map was made of a standstill")
    print(f"standstill: {len(poses)} frames, no map, NO_BASELINE")
    options.frames += len(poses)


def last_status(folder):
    return json.loads(lines(folder / "logged" / "status.jsonl")[-1])


def compare(folder):
    offline = lines(folder / "offline" / "trajectory.tum")
    logged = lines(folder / "logged" / "trajectory.tum")
    if len(offline) < 10:
        fail(f"the offline run tracked {len(offline)} frames: this shows nothing")
    same = set(offline) & set(logged)
    status = last_status(folder)
    lost = (status["sequence_gaps"] + status["frames_dropped"] +
            int(status["diagnostics"].get("split_frames.incomplete", 0)))
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
    parser = live_options(__doc__)
    parser.add_argument("--before", help="recorded folder of a camera that stands still")
    options = parse_live(parser)
    options.before = options.before and shared(options.before)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        map_offline(options, folder / "offline")
        run_live(options, folder, "lossless",
                 lambda processes: options.before and stand_still(options, processes, folder))
        compare(folder)


main()
