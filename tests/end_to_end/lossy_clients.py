#!/usr/bin/env python3
"""A server and five loggers behind a link that loses a fifth of all datagrams, doubles and reorders:
two from the start, one that comes in the middle, one at the end, one that is killed and started again.
Each ends with exactly the published map, by its digest. Run it inside a private network.
"""
import json
import pathlib
import signal
import sys
import tempfile

from processes import (Processes, fail, last_status, lines, live_options, parse_live, wait_for_lines,
                       wait_until_quiet)
from two_hosts import FarHost, URL

SOURCE = pathlib.Path(__file__).resolve().parent
LINK = ["--lose", 0.2, "--double", 0.05, "--delay", 0.1]


def relay(processes, name, folder, seed, to, kinds, around=lambda *words: list(words)):
    process = processes.start(name, *around(
        sys.executable, SOURCE / "relay.py", "--to", to, "--record", folder / (name + ".json"),
        "--seed", seed, *LINK, "--kinds", *kinds))
    process.wait_for_words("relaying")
    return process


class Loggers:
    """Behind the link."""

    def __init__(self, options, processes, far, folder):
        self.options, self.processes, self.far, self.folder = options, processes, far, folder
        self.running = {}

    def start(self, name):
        self.running[name] = self.processes.start(name, *self.far.inside(
            self.options.client, "log", self.folder / name, "--lcm-url", URL))
        self.running[name].wait_for_words("logging")

    def kill(self, name):
        self.running.pop(name).stop()

    def maps(self):
        for process in self.running.values():
            process.child.send_signal(signal.SIGTERM)
        for process in self.running.values():
            process.wait_for_end()
        return {name: json.loads((self.folder / name / "map.json").read_text())
                for name in self.running}


def run(options, folder, seed):
    with Processes(folder) as processes:
        far = FarHost(processes)
        far.keep_to_itself()
        server = processes.start("server", options.server, "--lcm-url", URL)
        server.wait_for_words("listening on")
        near = processes.start("near", options.client, "log", folder / "near", "--lcm-url", URL)
        near.wait_for_words("logging")
        here = processes.start("holder", "sleep", "600").child.pid
        there = relay(processes, "there", folder, 2 * seed, far.holder, ["map", "pose", "status"])
        relay(processes, "back", folder, 2 * seed + 1, here, ["map_request"], far.inside)
        loggers = Loggers(options, processes, far, folder)
        for name in ("first", "second", "restarted"):
            loggers.start(name)
        publisher = processes.start("publisher", options.client, "publish", *options.publish,
                                    "--lcm-url", URL, "--start-delay", 1)
        poses = folder / "near" / "poses.jsonl"
        wait_for_lines(poses, options.frames // 3)
        loggers.kill("restarted")
        loggers.start("middle")
        wait_for_lines(poses, options.frames // 2)
        loggers.start("again")
        publisher.wait_for_end()
        loggers.start("late")
        wait_until_quiet(lambda: asked(folder / "near"), options.quiet_s)
        maps = loggers.maps()
        there.child.send_signal(signal.SIGTERM)
        there.wait_for_end()
        server.child.send_signal(signal.SIGTERM)
        server.wait_for_end()
        near.wait_for_end()
    return maps


def asked(log):
    """Of the published map, and how often it was asked for: who misses some of it goes on asking."""
    status = last_status(log)
    return [status["map_seq"]] + [status["diagnostics"][key] for key in ("map_requests", "map_parts_again")]


def judge(maps, folder, seed):
    status = json.loads(lines(folder / "near" / "status.jsonl")[-1])
    link = json.loads((folder / "there.json").read_text())
    counts = {key: status["diagnostics"][key]
              for key in ("map_requests", "map_parts_again", "map_whole_again")}
    print(f"seed {seed}: published map {status['map_seq']} of {status['keyframes']} keyframes; "
          f"{counts}; the link lost {len(link['lost'])}; requests "
          f"{[maps[name]['requests'] for name in maps]}")
    if status["keyframes"] < 5:
        fail("there was next to no map: this shows nothing")
    if sum(facts["requests"] for facts in maps.values()) == 0:
        fail("nobody had to ask: this shows nothing")
    for name, facts in maps.items():
        for key in ("server_epoch", "map_id", "map_epoch", "map_seq", "map_digest"):
            if facts[key] != status[key]:
                fail(f"seed {seed}: {name} has {key} {facts[key]}, published is {status[key]}")


def main():
    parser = live_options(__doc__)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--quiet-s", type=float, default=8)
    options = parse_live(parser)
    for seed in range(options.seeds):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            judge(run(options, folder, seed), folder, seed)


main()
