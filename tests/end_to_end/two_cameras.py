#!/usr/bin/env python3
"""Two cameras on one server, as real processes over udpm: two publishers of features, two loggers.

Each ends with a map of its own: its log says which camera it is of, and where no frame was lost the
logged trajectory is the server's, and both maps are those that each camera has on a server of its own.
Run it inside a private network (support/private_network.sh).
"""
import argparse
import json
import pathlib
import signal
import tempfile

from processes import Processes, fail, lines, wait_for_lines

CAMERAS = {"front": ["--simulate", "courtyard"], "left": ["--simulate", "courtyard", "--seed", "5"]}


def run(options, folder, cameras):
    """Maps these cameras at once: `folder`/live is the server's, `folder`/NAME a camera's log."""
    folder.mkdir()
    with Processes(folder) as processes:
        server = processes.start("server", options.server, "--input", "lossless",
                                 "--output", folder / "live")
        server.wait_for_words("listening on")
        loggers = []
        for name in cameras:
            loggers.append(processes.start("logger_" + name, options.client, "log", folder / name,
                                           "--camera", name))
            loggers[-1].wait_for_words("logging")
        publishers = [
            processes.start("publisher_" + name, options.client, "publish", *CAMERAS[name],
                            "--camera", name, "--as", "features", "--rate", "10",
                            "--max-frames", options.frames)
            for name in cameras]
        for publisher in publishers:
            publisher.wait_for_end()
        for name in cameras:
            wait_for_lines(folder / name / "poses.jsonl", options.frames)
        server.child.send_signal(signal.SIGTERM)
        server.wait_for_end()
        for logger in loggers:
            logger.wait_for_end()


def lost_frames(status):
    return (status["sequence_gaps"] + status["frames_dropped"] +
            int(status["diagnostics"].get("split_frames.incomplete", 0)))


def judge(folder, name, results):
    status = json.loads(lines(folder / name / "status.jsonl")[-1])
    facts = json.loads((folder / name / "map.json").read_text())
    logged = lines(folder / name / "trajectory.tum")
    if status["camera"] != name or facts["camera"] != name:
        fail(f"the log of {name} is of {status['camera']} and {facts['camera']}")
    if status["keyframes"] < 3 or status["landmarks"] < 100 or len(logged) < 20:
        fail(f"{name} has no map: {len(logged)} poses, {status['message']}")
    lost = lost_frames(status)
    if lost == 0 and logged != lines(results / "trajectory.tum"):
        fail(f"no frame of {name} was lost, but the logged trajectory is another than the server's")
    print(f"{name}: {len(logged)} poses tracked, {status['keyframes']} keyframes, "
          f"{status['landmarks']} landmarks, frames lost on the way: {lost}")
    return lost, logged, facts["map_digest"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("--client", required=True)
    parser.add_argument("--frames", type=int, default=60)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(options, folder / "both", list(CAMERAS))
        for camera in CAMERAS:
            run(options, folder / camera, [camera])
            beside = judge(folder / "both", camera, folder / "both" / "live" / camera)
            alone = judge(folder / camera, camera, folder / camera / "live")
            if beside[0] == alone[0] == 0 and beside != alone:
                fail(f"{camera}'s map is another beside the other camera than alone")


main()
