#!/usr/bin/env python3
"""Strange images among the good ones of a recording (black, noise, of another size, shifted, half
covered) cost the good ones next to nothing, whatever the mapper makes of the strange ones.

Judged by the good images alone, of trajectory_final.tum and of trajectory.tum, the poses as
published at the time.
"""
import argparse
import collections
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
from processes import shared
from runs import Programs

STRANGE_SHARE = 0.3  # as many as of the good images
LEAST_COVERAGE = 0.95  # of the clean run's
TRAJECTORIES = ["trajectory.tum", "trajectory_final.tum"]


def lines_by_time(file):
    """By whole microseconds."""
    lines = (line for line in file.read_text().splitlines() if line)
    return {round(1e6 * float(line.split()[0])): line for line in lines}


class Judged:
    """The good images' part of a run's trajectory."""

    def __init__(self, programs, truth, good_times, trajectory, scratch):
        poses = {time: line for time, line in lines_by_time(trajectory).items() if time in good_times}
        self.times = set(poses)
        self.coverage = len(poses) / len(good_times)
        scratch.write_text("".join(line + "\n" for line in poses.values()))
        self.error_m = programs.error_m(truth, scratch)


def problems_of(name, clean, now, more_error_m):
    if now.error_m is None:
        return [f"{name}: no trajectory to judge"]
    checks = {
        f"{name}: coverage {now.coverage:.3f}, promised {LEAST_COVERAGE} of {clean.coverage:.3f}":
            now.coverage >= LEAST_COVERAGE * clean.coverage,
        f"{name}: error {now.error_m:.4f} m, promised at most {more_error_m} m more than "
        f"{clean.error_m:.4f} m": now.error_m <= clean.error_m + more_error_m,
    }
    return [text for text, kept in checks.items() if not kept]


class Recording:
    """The first images of a folder, mapped without any strange ones."""

    def __init__(self, programs, source, max_frames, scratch):
        self.programs, self.source, self.scratch = programs, pathlib.Path(source), scratch
        times = sorted(lines_by_time(self.source / "times.txt"))
        self.good_times = set(times[:max_frames] if max_frames else times)
        self.output = scratch / "clean"
        programs.map(self.source, self.output, "--max-frames", len(self.good_times))
        self.clean = self.judge(self.output)

    def judge(self, output):
        return {name: Judged(self.programs, self.source / "groundtruth.tum", self.good_times,
                             output / name, self.scratch / "good.tum") for name in TRAJECTORIES}

    def corrupt(self, seed, kinds):
        """(folder, kinds of the strange images by time)"""
        folder = self.scratch / f"strange{seed}{kinds}"
        words = ["--kinds", kinds] if kinds else []
        self.programs.call("degrade", self.source, folder, "--corrupt",
                           round(STRANGE_SHARE * len(self.good_times)), "--seed", seed,
                           "--max-frames", len(self.good_times), *words)
        lines = (folder / "corrupted.txt").read_text().splitlines()
        return folder, {int(time): kind for time, kind in map(str.split, lines)}


def lost_after(recording, judged, strange):
    """How many good images have no pose that have one in the clean run, by what the last strange
    image before them was."""
    counts = collections.Counter()
    lost = recording.clean["trajectory.tum"].times - judged["trajectory.tum"].times
    for time in lost:
        before = [other for other in strange if other < time]
        counts[strange[max(before)] if before else "none"] += 1
    return dict(counts)


def run(recording, seed, kinds, more_error_m):
    folder, strange = recording.corrupt(seed, kinds)
    output = recording.scratch / "out"
    report = recording.programs.map(folder, output)
    judged = recording.judge(output)
    posed = collections.Counter(kind for time, kind in strange.items()
                                if time in lines_by_time(output / "trajectory.tum"))
    keyframes = collections.Counter(kind for time, kind in strange.items()
                                    if time in lines_by_time(output / "keyframes.tum"))
    for name, clean in recording.clean.items():
        now = judged[name]
        print(f"{recording.source.name} seed {seed} {kinds or 'all'}: {name}: coverage "
              f"{now.coverage:.3f} (clean {clean.coverage:.3f}), error {now.error_m or 0:.4f} m "
              f"(clean {clean.error_m:.4f} m)", flush=True)
    print(f"  {report['losses']} losses, {report['starts']} starts, strange: "
          f"{dict(collections.Counter(strange.values()))}, of them posed {dict(posed)}, keyframes "
          f"{dict(keyframes)}, good images lost after {lost_after(recording, judged, strange)}, "
          f"rejected {report['rejected_reasons']}", flush=True)
    problems = [problem for name, clean in recording.clean.items()
                for problem in problems_of(name, clean, judged[name], more_error_m)]
    return problems + problems_of_sizes(report, strange.values())


def problems_of_sizes(report, kinds):
    wrong = sum(kind == "wrong_size" for kind in kinds)
    expected = {"BAD_IMAGE_SIZE": wrong} if wrong else {}
    if report["rejected_reasons"] == expected:
        return []
    return [f"rejected: {report['rejected_reasons']}, promised {expected}"]


def sizes_cost_nothing(recording):
    """Images of another size alone: not a bit of the trajectories is another."""
    folder, _ = recording.corrupt(0, "wrong_size")
    output = recording.scratch / "sizes"
    recording.programs.map(folder, output)
    return [f"images of another size change {name}" for name in TRAJECTORIES
            if (output / name).read_bytes() != (recording.output / name).read_bytes()]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", required=True, help="folder of eifmap-server, eifmap, degrade")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--max-frames", type=int, default=0, help="good images; 0: all")
    parser.add_argument("--kinds", default="", help="of strange images; default: all")
    parser.add_argument("--more-error", type=float, default=0.01, help="than the clean run's, m")
    parser.add_argument("--sizes", action="store_true", help="also those of another size alone")
    parser.add_argument("source", help="folder of eifmap's own layout with the truth, or shared:NAME")
    options = parser.parse_args()
    source = shared(options.source)
    with tempfile.TemporaryDirectory() as name:
        recording = Recording(Programs(options.programs), source, options.max_frames,
                              pathlib.Path(name))
        broken = sizes_cost_nothing(recording) if options.sizes else []
        for seed in range(1, options.seeds + 1):
            broken += [f"seed {seed}: {text}" for text in run(recording, seed, options.kinds, options.more_error)]
    if broken:
        sys.exit("FAILED: " + "\n".join(broken))


if __name__ == "__main__":
    main()
