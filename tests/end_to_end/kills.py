#!/usr/bin/env python3
"""A server that is killed (SIGKILL) at random moments while it maps, and started again each time:
every keyframe that it had published is there, its map's file is whole, and mapping goes on. Run it
inside a private network.
"""
import json
import pathlib
import random
import re
import signal
import subprocess
import tempfile
import time

from processes import Processes, fail, live_options, parse_live


def checked(server, folder):
    """What --check-map says of each file: its map's id, last update, and keyframes ever."""
    maps = {}
    for file in sorted(folder.glob("**/map-*.eifmap")):
        run = subprocess.run([server, "--check-map", file], capture_output=True, text=True,
                             check=False)
        said = run.stdout
        found = re.search(r"map (\d+) \(epoch \d+, update (\d+)\): keyframes 0 to (\d+)", said)
        if run.returncode != 0 or not found:
            fail(f"{file}: {said}{run.stderr}")
        maps[int(found[1])] = (int(found[2]), int(found[3]) + 1)
    return maps


def run_until_killed(processes, options, folder, n, wait_s):
    """What the last published map was; None where nothing was published in the time."""
    server = processes.start(f"server{n}", options.server, "--maps", folder / "maps")
    logger = processes.start(f"logger{n}", options.client, "log", folder / f"logged{n}")
    server.wait_for_words("listening on")
    time.sleep(wait_s)
    server.child.send_signal(signal.SIGKILL)
    server.child.wait()
    time.sleep(0.2)  # what was sent arrives
    logger.child.send_signal(signal.SIGTERM)
    logger.child.wait()
    facts = folder / f"logged{n}" / "map.json"
    seen = json.loads(facts.read_text()) if facts.exists() else {}
    return seen if seen.get("map_id") else None


def run(options, folder):
    chance = random.Random(options.seed)
    lost = grown = unseen = 0
    known = {}
    with Processes(folder) as processes:
        publisher = processes.start("publisher", options.client, "publish", *options.publish,
                                    "--loop")
        for n in range(options.kills):
            seen = run_until_killed(processes, options, folder, n, chance.uniform(0.2, options.longest_s))
            if publisher.child.poll() is not None:
                fail("the publisher ended:\n" + publisher.text())
            now = checked(options.server, folder / "maps")
            for map_id, (seq, keyframes) in known.items():
                # It may have become part of another one, which then has more than both had.
                if map_id in now and now[map_id][1] < keyframes:
                    lost += keyframes - now[map_id][1]
            if seen is None:
                unseen += 1
            elif seen["map_id"] not in now:
                fail(f"kill {n}: map {seen['map_id']} was published and is not on the disk: {now}")
            else:
                seq, keyframes = now[seen["map_id"]]
                lost += max(0, seen["keyframes"] - keyframes)
                if seq < seen["map_seq"]:
                    fail(f"kill {n}: update {seen['map_seq']} was published, on the disk is {seq}")
            total = sum(keyframes for _, keyframes in now.values())
            grown += total > sum(keyframes for _, keyframes in known.values())
            known = now
    print(f"{options.kills} kills: {lost} published keyframes lost, the map grew in {grown} of the "
          f"lives, {unseen} ended before anything was published; in the end {known}")
    if lost or grown < max(2, options.kills // 20) or unseen > options.kills * 3 // 4:
        fail("that is not what was wanted")


def main():
    parser = live_options(__doc__)
    parser.add_argument("--kills", type=int, default=6)
    parser.add_argument("--longest-s", type=float, default=4)
    parser.add_argument("--seed", type=int, default=1)
    options = parse_live(parser)
    with tempfile.TemporaryDirectory() as folder:
        run(options, pathlib.Path(folder))


if __name__ == "__main__":
    main()
