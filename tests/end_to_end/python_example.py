#!/usr/bin/env python3
"""The Python example prints the poses that the logger writes. Run it inside a private network."""
import os
import pathlib
import signal
import subprocess
import tempfile

from processes import Processes, fail, lines, live_options, parse_live, run_live, wait_for

ROOT = pathlib.Path(__file__).resolve().parents[2]


def make_types(folder):
    schemas = sorted(ROOT.glob("messages/*.lcm"))
    subprocess.run(["lcm-gen", "--python", "--ppath", folder, *schemas], check=True)


def hears_the_group():
    """Somebody in this network has joined 239.255.76.67, LCM's."""
    return "434CFFEF" in pathlib.Path("/proc/net/igmp").read_text()


def main():
    options = parse_live(live_options(__doc__))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make_types(folder / "types")
        os.environ["PYTHONPATH"] = str(folder / "types")
        with Processes(folder) as outer:
            example = outer.start("example", "python3", ROOT / "client/examples/follow_poses.py")
            wait_for("the example", hears_the_group)
            run_live(options, folder, "lossless")
            logged = lines(folder / "logged" / "trajectory.tum")
            wait_for("the last pose", lambda: len(example.text().splitlines()) >= len(logged))
            example.child.send_signal(signal.SIGTERM)
            example.child.wait(10)
            said = [[float(x) for x in line.split()] for line in example.text().splitlines()]
        logged = [[float(x) for x in line.split()] for line in logged]
        print(f"{len(said)} poses said, {len(logged)} logged")
        if len(logged) < 0.8 * options.frames:
            fail("next to nothing was tracked: this shows nothing")
        if len(said) != len(logged):
            fail("the example missed some, or said too many:\n" + example.text()[-2000:])
        for a, b in zip(said, logged):
            if max(abs(x - y) for x, y in zip(a, b)) > 1e-6:
                fail(f"the example says {a}, the log {b}")


main()
