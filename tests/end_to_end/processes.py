"""What the tests of real processes share: children that never outlive their test, the shared data, and
the offline run that a live one is compared with.
"""
import argparse
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

SKIPPED = 77
PATIENCE_S = 240

# Measurements made of a recording's truth.
EVERY, SIGMA = 4, 0.02  # images; m
ORIGIN = (1000.0, -500.0, 40.0)  # m


def fail(message):
    sys.exit("FAILED: " + message)


def skip(message):
    print("skipped: " + message)
    sys.exit(SKIPPED)


def shared_folder(name):
    """Where a sequence of the shared data would be."""
    source = pathlib.Path(__file__).resolve().parents[2]
    root = pathlib.Path(os.environ.get("EIFMAP_SHARED", source.parent / "shared"))
    return root / "data" / name


def shared(name):
    """shared:NAME is a sequence of the shared data, which may not be there."""
    if not name.startswith("shared:"):
        return name
    folder = shared_folder(name[len("shared:"):])
    if not folder.is_dir():
        skip(f"no {folder}")
    return str(folder)


class Process:
    """A child whose output goes to a file."""

    def __init__(self, name, command, folder):
        self.name = name
        self.output = folder / (name + ".log")
        with open(self.output, "wb") as output:
            self.child = subprocess.Popen([str(word) for word in command], stdout=output,
                                          stderr=subprocess.STDOUT)

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


class Processes:
    """Of one test: all of them end with it."""

    def __init__(self, folder):
        self.folder = folder
        self.started = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in reversed(self.started):
            process.stop()

    def start(self, name, *command):
        self.started.append(Process(name, command, self.folder))
        return self.started[-1]


def live_options(description):
    """A parser of what every test of a live run against an offline one takes; see parse_live()."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--server", required=True)
    parser.add_argument("--client", required=True)
    parser.add_argument("--offline", required=True, help="recorded folder for the offline run")
    parser.add_argument("--publish", required=True, nargs=argparse.REMAINDER)
    return parser


def parse_live(parser):
    options = parser.parse_args()
    options.offline = shared(options.offline)
    options.publish = [shared(argument) for argument in options.publish]
    options.frames = len(lines(pathlib.Path(options.offline) / "times.txt"))
    return options


def measure(options, folder):
    """Positions of every few images, with noise, for the publisher."""
    draw = random.Random(1)
    made = []
    for line in lines(pathlib.Path(options.offline) / "groundtruth.tum")[::EVERY]:
        time_s, *place = map(float, line.split()[:4])
        made.append({"kind": "position", "utime": round(1e6 * time_s), "sigma": SIGMA,
                     "position": [x + o + draw.gauss(0, SIGMA) for x, o in zip(place, ORIGIN)]})
    file = folder / "measurements.jsonl"
    file.write_text("".join(json.dumps(m) + "\n" for m in made))
    options.publish += ["--measurements", file]
    return len(made)


def map_offline(options, output):
    subprocess.run([options.server, "--sequence", options.offline, "--output", output], check=True)


def run_live(options, folder, taking, before=None):
    """Server, logger and publisher to the end: `folder`/live is the server's, `folder`/logged the
    logger's. `taking`: newest or lossless; `before(processes)`: what else is done before publishing.
    Once more, at most twice, where the logger's socket had no room: it has less than was published,
    and that is neither the server's doing nor the client's.
    """
    for _ in range(3):
        for made in ("live", "logged"):
            shutil.rmtree(folder / made, ignore_errors=True)
        if run_live_once(options, folder, taking, before) == 0:
            break
        print("the logger's socket overflowed")


def run_live_once(options, folder, taking, before):
    """Datagrams that the logger's socket had no room for."""
    with Processes(folder) as processes:
        server = processes.start("server", options.server, "--input", taking,
                                 "--output", folder / "live")
        server.wait_for_words("listening on")
        logger = processes.start("logger", options.client, "log", folder / "logged")
        logger.wait_for_words("logging")
        if before:
            before(processes)
        processes.start("publisher", options.client, "publish", *options.publish).wait_for_end()
        wait_for_lines(folder / "logged" / "poses.jsonl", options.frames)
        lost = overflows(logger)
        server.child.send_signal(signal.SIGTERM)
        server.wait_for_end()
        logger.wait_for_end()
    return lost


def overflows(process):
    """Datagrams that a process' sockets in this network had no room for."""
    opened = set()
    for file in pathlib.Path(f"/proc/{process.child.pid}/fd").iterdir():
        try:
            opened.add(os.readlink(file))
        except FileNotFoundError:
            pass  # closed meanwhile
    sockets = [line.split() for line in pathlib.Path("/proc/net/udp").read_text().splitlines()[1:]]
    return sum(int(socket[-1]) for socket in sockets if f"socket:[{socket[9]}]" in opened)


def lines(file):
    return file.read_text().splitlines() if file.exists() else []


def last_status(log):
    """Of a log that is still being written: the last line that is whole."""
    return json.loads((log / "status.jsonl").read_text().rpartition("\n")[0].splitlines()[-1])


def wait_for(what, condition, seconds=PATIENCE_S):
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            fail(f"{what} never came")
        time.sleep(0.05)


def wait_until_quiet(state, for_s):
    """Until what `state` gives has been the same for as long."""
    last, since, begin = state(), time.monotonic(), time.monotonic()
    while time.monotonic() - since < for_s:
        now = state()
        if now != last:
            last, since = now, time.monotonic()
        if time.monotonic() - begin > PATIENCE_S:
            fail(f"it is never quiet: {last}")
        time.sleep(0.1)


def wait_for_lines(file, count):
    """Until the file has as many, or no more come."""
    newest, since = -1, time.monotonic()
    while newest < count and time.monotonic() - since < 10:
        now = len(lines(file))
        if now != newest:
            newest, since = now, time.monotonic()
        time.sleep(0.1)
