#!/usr/bin/env python3
"""A live server under load, over udpm, everything recorded by lcm-logger, and its run made again from
that log alone, to the bit.

More images come than the machine can map, beside processes that take its time: images are passed over,
and keyframes go in beside the others. `eifmap-server --log FILE --verify` must then find each frame's
digest as it was, and write what the live server wrote, byte for byte. A log that was tampered with, that
lost a frame or is cut must be told. Run it inside a private network (support/private_network.sh).
"""
import json
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

from processes import (Processes, fail, lines, live_options, measure, overflows, parse_live, skip,
                       wait_for, wait_until_quiet)

MARK = 0xEDA1DA01
HEADER = struct.Struct(">Iqqii")  # mark, number, time, lengths of channel and message
SAME = ("trajectory.tum", "trajectory_final.tum", "keyframes.tum", "decisions.jsonl", "map.ply")


class Event:
    """Of a log: its bytes, and where they say what it is."""

    def __init__(self, head, channel, message):
        self.head, self.channel, self.message = head, channel, message

    @property
    def kind(self):
        return self.channel.rpartition(b".")[2].decode()

    @property
    def utime(self):
        """Of an image and of a decision, both right behind the fingerprint."""
        return struct.unpack_from(">q", self.message, 8)[0]

    def bytes(self):
        return self.head + self.channel + self.message


def read_events(file):
    text, at, events = file.read_bytes(), 0, []
    while at < len(text):
        mark, _, _, channel, message = HEADER.unpack_from(text, at)
        if mark != MARK:
            fail(f"{file} is no log at {at}")
        middle = at + HEADER.size + channel
        events.append(Event(text[at:at + HEADER.size], text[at + HEADER.size:middle],
                            text[middle:middle + message]))
        at = middle + message
    return events


def write_events(file, events):
    with open(file, "wb") as out:
        for event in events:
            out.write(event.bytes())
    return file


def replay(options, log, output, *more):
    """The exit code and what was said."""
    run = subprocess.run([options.server, "--log", log, "--output", output, *more],
                         capture_output=True, text=True)
    return run.returncode, run.stderr


def expect(result, code, *words):
    if result[0] != code:
        fail(f"ended with {result[0]} instead of {code}:\n{result[1]}")
    for word in words:
        if str(word) not in result[1]:
            fail(f"'{word}' was not said, but:\n{result[1]}")


def record(options, folder):
    """Server, lcm-logger and publisher to the end, beside what takes the machine's time. Datagrams
    that the log's socket had no room for."""
    with Processes(folder) as processes:
        server = processes.start("server", options.server, "--output", folder / "live")
        server.wait_for_words("listening on")
        # A logger that loses what the server hears would show nothing.
        log = processes.start("lcm-logger", "lcm-logger", "-q", "--channel", r"eifmap\..*", "--lcm-url",
                              "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152", folder / "log")
        for i in range(options.load):
            processes.start(f"load{i}", "nice", "-n", "5", sys.executable, "-c", "while True: pass")
        # It hears the server, whose status comes every second.
        wait_for("a log", lambda: (folder / "log").exists() and (folder / "log").stat().st_size > 0)
        processes.start("publisher", options.client, "publish", *options.publish).wait_for_end()
        time.sleep(2)  # what is still on its way
        server.child.send_signal(signal.SIGTERM)
        lost = overflows(log)
        server.wait_for_end()
        wait_until_quiet(lambda: (folder / "log").stat().st_size, for_s=1)
        log.child.send_signal(signal.SIGTERM)
        log.child.wait()
    return lost


def record_all(options, folder):
    """A log of all that the server heard; once more where its socket had no room."""
    for _ in range(3):
        for made in (folder / "log", folder / "live"):
            shutil.rmtree(made) if made.is_dir() else made.unlink(missing_ok=True)
        if record(options, folder) == 0:
            break
        print("the log's socket overflowed")
    return folder / "log"


def expect_same(options, folder, log):
    made = [json.loads(line) for line in lines(folder / "live" / "decisions.jsonl")]
    adopted = sum(decision["adopted_job"] > 0 for decision in made)
    sent = options.frames
    print(f"{sent} images sent, {len(made)} mapped, {adopted} keyframes adopted beside")
    begin = time.monotonic()
    expect(replay(options, log, folder / "again", "--verify"), 0,
           f"{len(made)} frames mapped, all with the digests that were recorded")
    print(f"made again in {time.monotonic() - begin:.1f} s")
    measured = ["measurements.jsonl"] if options.metric else []
    for file in (*SAME, *measured):
        live = (folder / "live" / file).read_bytes()
        if live != (folder / "again" / file).read_bytes():
            fail(f"{file} is not the live server's")
        if live.count(b"\n") < 10:
            fail(f"{file} has hardly a line: this shows nothing")
    if adopted < 3 or (options.hurried and sent - len(made) < 10):
        fail("hardly an image was passed over, or a keyframe adopted beside: this shows nothing")


def expect_tampering_is_told(options, folder, log):
    events = read_events(log)
    decisions = [i for i, event in enumerate(events) if event.kind == "decision"]
    chosen = events[decisions[len(decisions) // 2]]
    digest = struct.unpack_from(">q", chosen.message, len(chosen.message) - 8)[0]

    changed = [Event(e.head, e.channel, e.message[:-8] + struct.pack(">q", digest ^ 1))
               if e is chosen else e for e in events]
    file = write_events(folder / "changed", changed)
    told = (f"the frame of {chosen.utime} us", "is the first that comes out otherwise",
            f"digest {digest}, recorded {digest ^ 1}")
    expect(replay(options, file, folder / "other", "--verify"), 1, *told)
    expect(replay(options, file, folder / "other"), 0, " warning ", *told)

    file = write_events(folder / "fewer", [e for e in events
                                           if e.kind != "image" or e.utime != chosen.utime])
    expect(replay(options, file, folder / "other", "--verify"), 1,
           f"1 of the {len(decisions)} frames that were mapped are not in the log: the frame of "
           f"{chosen.utime} us")

    file = write_events(folder / "undecided", [e for e in events if e is not chosen])
    expect(replay(options, file, folder / "other", "--verify"), 1,
           f"1 decisions on frames that have a pose are not in the log: the frame of {chosen.utime} us")

    file = folder / "cut"
    file.write_bytes(log.read_bytes()[:log.stat().st_size // 2])
    expect(replay(options, file, folder / "other", "--verify"), 1, "cut: is cut off at byte")
    expect(replay(options, file, folder / "other"), 0, "cut: is cut off at byte", " warning ")


def expect_all_without_decisions(options, folder, log):
    kept = [e for e in read_events(log) if e.kind in ("image", "calibration", "measurement")]
    file = write_events(folder / "bare", kept)
    images = sum(event.kind == "image" for event in kept)
    expect(replay(options, file, folder / "other"), 0, "every frame of it is mapped",
           f"{images} frames mapped;")
    expect(replay(options, file, folder / "other", "--verify"), 1, "no decisions of a server")


def main():
    parser = live_options(__doc__)
    parser.add_argument("--load", type=int, default=2, help="processes that take the machine's time")
    parser.add_argument("--hurried", action="store_true", help="images must have been passed over")
    parser.add_argument("--sent", type=int, help="that are sent; default: those recorded")
    parser.add_argument("--metric", action="store_true", help="with measurements of the truth")
    parser.add_argument("--brief", action="store_true", help="the replay alone, no tampering")
    options = parse_live(parser)
    options.frames = options.sent or options.frames
    if not shutil.which("lcm-logger"):
        skip("no lcm-logger")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if options.metric:
            measure(options, folder)
        log = record_all(options, folder)
        expect_same(options, folder, log)
        if not options.brief:
            expect_tampering_is_told(options, folder, log)
            expect_all_without_decisions(options, folder, log)


main()
