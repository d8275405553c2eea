#!/usr/bin/env python3
"""A live server that maps the newest image, over udpm, and its run made again from the log's decisions.

Which images it took, and when a keyframe's map was there, was up to the machine. The replay of the
recorded images with the decisions that were logged must give the logged trajectory byte for byte, and
the live server's own results. Run it inside a private network (support/private_network.sh).
"""
import json
import pathlib
import subprocess
import tempfile

from processes import fail, lines, live_options, parse_live, run_live


def replay(options, folder, decisions):
    """The exit code and what was said."""
    run = subprocess.run([options.server, "--sequence", options.offline, "--output", folder / "again",
                          "--decisions", decisions], capture_output=True, text=True)
    return run.returncode, run.stderr


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
    parser.add_argument("--max-frames", type=int, default=0, help="publish the first ones alone")
    options = parse_live(parser)
    if options.max_frames:
        options.frames = min(options.frames, options.max_frames)
        options.publish += ["--max-frames", str(options.max_frames)]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run_live(options, folder, "newest")
        compare(options, folder)
        expect_a_departure(options, folder)


main()
