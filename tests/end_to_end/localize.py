#!/usr/bin/env python3
"""Half of a recording is mapped and the map saved; the other half is localized in it. The map's file
is the same, to the byte, afterwards.
"""
import argparse
import hashlib
import json
import pathlib
import subprocess
import tempfile

from processes import fail, lines, shared


def run(options, output, *arguments):
    subprocess.run([options.server, "--sequence", options.sequence, "--output", output, *arguments],
                   check=True)
    return json.loads((output / "report.json").read_text())


def digest(file):
    return hashlib.sha256(file.read_bytes()).hexdigest()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("--sequence", required=True)
    parser.add_argument("--least", type=float, required=True, help="share of images localized")
    options = parser.parse_args()
    options.sequence = shared(options.sequence)
    half = len(lines(pathlib.Path(options.sequence) / "times.txt")) // 2
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        file = folder / "half.eifmap"
        run(options, folder / "mapped", "--max-frames", str(half), "--save-map", file)
        before = digest(file)
        report = run(options, folder / "localized", "--first-frame", str(half), "--load-map", file,
                     "--localize-only")
        print(f"{report['tracked']} of {report['frames']} images localized, coverage "
              f"{report['coverage']}")
        if digest(file) != before:
            fail("the map's file is another")
        if report["tracked"] < options.least * report["frames"] or report["frames"] < half:
            fail("that is not what was wanted")
        again = folder / "again.eifmap"
        run(options, folder / "again", "--first-frame", str(half), "--load-map", file,
            "--localize-only", "--max-frames", "50", "--save-map", again)
        checks = [subprocess.run([options.server, "--check-map", f], capture_output=True, text=True,
                                 check=True).stdout.split(" keyframes ", 1)[1].split(" images", 1)[0]
                  for f in (file, again)]
        # Of what was localized only where it was is added.
        if checks[0].rsplit(",", 1)[0] != checks[1].rsplit(",", 1)[0]:
            fail(f"the map has changed: {checks}")


if __name__ == "__main__":
    main()
