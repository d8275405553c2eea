#!/usr/bin/env python3
"""What recordings made worse cost: a table of error and coverage, over kitti00 and kitchen or over
recorded folders of your own in any layout, mapped with the defaults.
"""
import argparse
import math
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
from processes import shared_folder
from runs import Programs

JITTER_PX = 0.05
LOST_COVERAGE = 0.1
RECORDINGS = ["kitti00", "kitchen"]
BEGIN = "<!-- tables: written by tests/robustness/run, do not edit -->\n"
END = "<!-- end of tables -->\n"


class Row:
    """A degradation, as `degrade --list` has it."""

    def __init__(self, line):
        self.name, seeded, self.title = line.split("\t")
        self.seeded = seeded == "1"


class Outcome:
    def __init__(self, error_m, coverage):
        self.error_m, self.coverage = error_m, coverage

    def lost(self):
        return self.coverage < LOST_COVERAGE


def outcomes_of(programs, options, source, row):
    """A run for each seed. Seed 0 has no noise on the keypoints; what is random in the degradation
    is another with each seed."""
    outcomes = []
    with tempfile.TemporaryDirectory() as name:
        folder, output = pathlib.Path(name) / "images", pathlib.Path(name) / "out"
        for seed in range(options.seeds + 1):
            if seed == 0 or row.seeded:
                folder = pathlib.Path(name) / f"images{seed}"
                programs.call("degrade", source, folder, "--how", row.name, "--seed", seed,
                              *options.camera)
            jitter = ["--jitter-px", JITTER_PX, "--seed", seed] if seed else []
            report = programs.map(folder, output, *jitter)
            truth = folder / "groundtruth.tum"
            error = (programs.error_m(truth, output / "trajectory_final.tum")
                     if truth.exists() else None)
            outcomes.append(Outcome(error, report["coverage"]))
            print(f"{source.name}: {row.title}, seed {seed}: error "
                  f"{'-' if error is None else f'{error:.4f} m'}, coverage {report['coverage']:.3f}, "
                  f"{report['losses']} losses, {report['cpu_s']:.1f} CPU s", file=sys.stderr, flush=True)
            if row.seeded:
                forget(folder)
    return outcomes


def forget(folder):
    """A thousand images at a time are enough."""
    for image in (folder / "images").iterdir():
        image.unlink()


def error_cell(outcomes):
    kept = [outcome.error_m for outcome in outcomes
            if not outcome.lost() and outcome.error_m is not None]
    lost = sum(outcome.lost() for outcome in outcomes)
    if lost == len(outcomes):
        return "**lost**"
    if not kept:
        return "-"
    worst = f"{max(kept):.3f}" if lost == 0 else f"**lost** {lost} of {len(outcomes)}"
    return f"{sum(kept) / len(kept):.3f} / {worst}"


def coverage_cell(outcomes):
    """Rounded down: what is called 1.000 is all."""
    return f"{math.floor(1000 * min(o.coverage for o in outcomes) + 1e-9) / 1000:.3f}"


def table(rows, recordings):
    """recordings: (name, outcomes of each row)."""
    lines = ["| |" + "".join(f" {name}: error (m), mean / worst | coverage |" for name, _ in recordings),
             "|---|" + "---:|---:|" * len(recordings)]
    for i, row in enumerate(rows):
        cells = "".join(f" {error_cell(outcomes[i])} | {coverage_cell(outcomes[i])} |"
                        for _, outcomes in recordings)
        lines.append(f"| {row.title} |{cells}")
    return "\n".join(lines) + "\n"


def explanation(options, skipped):
    seeds = f"{options.seeds + 1} runs each, all but the first with {JITTER_PX} px of noise of their own on every keypoint" \
        if options.seeds else "One run each"
    missing = "".join(f" {name}: skipped, not there." for name in skipped)
    return f"""Recordings as they are and made worse as cameras and links make them, mapped with the defaults.{missing} {seeds}; what is random in a row is another in each run.

- Error: RMSE of `trajectory_final.tum` after a similarity transform, mean and worst of the runs. **lost**: less than {LOST_COVERAGE} of the images; the mean is of the runs that were not. An error says nothing about images that are not covered: read it with the next column.
- Coverage: share of the images given (of those left, where some are dropped) that are in that trajectory, least of the runs.

`tests/robustness/run` writes this again, with the recordings in `$EIFMAP_SHARED/data`, or `../shared/data` beside the project. `tests/robustness/run FOLDER...` prints the same of recordings of your own, in any layout that the [README](../README.md) lists (with `--calib FILE` or `--hfov DEGREES` where they have no calibration); `--seeds 0` is one run each, `--rows TEXT` the rows with that text alone.

"""


def page_with_tables(page, tables):
    """What is written by hand around the tables stays."""
    if not page:
        return ("# Recordings made worse\n\n" + BEGIN + "\n" + tables + "\n" + END + "\n## What it says\n\n"
                "<!-- Written by hand, kept when the tables are written again. -->\n")
    begin, end = page.find(BEGIN), page.find(END)
    if begin < 0 or end < begin:
        sys.exit("the page has no markers around its tables: move it away, or put back "
                 + BEGIN + "and " + END)
    return page[:begin] + BEGIN + "\n" + tables + "\n" + page[end:]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", required=True, help="folder of eifmap-server, eifmap, degrade")
    parser.add_argument("--seeds", type=int, default=5, help="runs with noise beside the one without")
    parser.add_argument("--rows", default="", help="only those with this text in their title")
    parser.add_argument("--calib", help="calibration of folders that have none")
    parser.add_argument("--hfov", help="guess it: degrees from left to right")
    parser.add_argument("--output", help="page to write; what is around its tables stays")
    parser.add_argument("sources", nargs="*", metavar="SOURCE", help="recorded folders in any layout")
    options = parser.parse_args()
    options.camera = [f"--{name}={value}" for name in ("calib", "hfov")
                      if (value := getattr(options, name)) is not None]
    return options


def find_sources(options):
    """(folders, names of those that are not there)"""
    if options.sources:
        return [pathlib.Path(source) for source in options.sources], []
    folders = {name: shared_folder(name) for name in RECORDINGS}
    skipped = [name for name, folder in folders.items() if not folder.is_dir()]
    for name in skipped:
        print(f"{name}: skipped, no {folders[name]}", file=sys.stderr)
    return [folder for folder in folders.values() if folder.is_dir()], skipped


def main():
    options = arguments()
    programs = Programs(options.programs)
    sources, skipped = find_sources(options)
    if not sources:
        print("skipped: no recordings; give folders of your own")
        return 77
    rows = [row for row in map(Row, programs.call("degrade", "--list").splitlines())
            if options.rows in row.title]
    if not rows:
        sys.exit(f"--rows {options.rows}: no row has that text")
    page = pathlib.Path(options.output) if options.output else None
    before = page.read_text() if page and page.exists() else ""
    page_with_tables(before, "")  # a page that cannot be written is found out before the long work
    try:
        recordings = [(source.resolve().name,
                       [outcomes_of(programs, options, source, row) for row in rows])
                      for source in sources]
    except RuntimeError as error:
        sys.exit(f"FAILED: {error}")
    text = explanation(options, skipped) + table(rows, recordings)
    if page:
        page.write_text(page_with_tables(before, text))
    else:
        print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
