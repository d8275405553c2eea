#!/usr/bin/env python3
"""A recorded street with absolute measurements made from its truth: the map must come out in metres.

gps: a position a second with 0.3 m of noise on each axis, in a frame of its own; the path must be
right without any alignment of its scale. distance: one known distance between the ends of the first
straight; that straight must be that long.
"""
import argparse
import bisect
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

from processes import shared

SIGMA, RATE = 0.3, 1.0  # m, Hz
ORIGIN = (1000.0, -500.0, 40.0)  # m
LARGEST_ERROR = 0.6  # m, RMSE
LEAST_STRAIGHT, BEND = 30.0, 0.01  # m; way over distance, less 1
LENGTH_WITHIN = 0.01
SCALE_WITHIN = 3  # of its own sigmas
DISTANCE_SIGMA = 0.003  # of the distance


def read(file):
    rows = [line.split() for line in open(file) if line.strip() and not line.startswith("#")]
    return [(float(row[0]), tuple(map(float, row[1:4]))) for row in rows]


def positions(truth, seed):
    draw = random.Random(seed)
    next_time = truth[0][0]
    for time, place in truth:
        if time < next_time - 1e-9:
            continue
        next_time += 1 / RATE
        yield {"kind": "position", "utime": round(1e6 * time), "sigma": SIGMA,
               "position": [x + o + draw.gauss(0, SIGMA) for x, o in zip(place, ORIGIN)]}


def first_straight(truth):
    for first in range(len(truth)):
        way = 0
        for last in range(first + 1, len(truth)):
            way += math.dist(truth[last - 1][1], truth[last][1])
            distance = math.dist(truth[first][1], truth[last][1])
            if way > (1 + BEND) * distance:
                break
            if distance >= LEAST_STRAIGHT:
                return truth[first], truth[last]
    sys.exit("FAILED: the truth has no straight")


def place_at(path, time):
    at = bisect.bisect([t for t, _ in path], time - 1e-3)
    if at == len(path) or abs(path[at][0] - time) > 0.01:
        sys.exit(f"FAILED: no pose at {time}")
    return path[at][1]


def run(options, folder, measurements, output):
    file = output / "measurements.jsonl"
    file.write_text("".join(json.dumps(m) + "\n" for m in measurements))
    subprocess.run([options.server, "--sequence", folder, "--output", output,
                    "--measurements", file], check=True, stderr=subprocess.DEVNULL)
    report = json.loads((output / "report.json").read_text())["measurements"]
    if report["scale"] != "fixed":
        sys.exit(f"FAILED: the scale is free: {report}")
    return report, read(output / "trajectory_final.tum")


def similarity(options, folder, output):
    result = subprocess.run(
        [options.client, "eval", "--gt", folder / "groundtruth.tum",
         "--est", output / "trajectory_final.tum", "--times", folder / "times.txt", "--json"],
        check=True, capture_output=True, text=True)
    return json.loads(result.stdout)


def gps(options, folder, truth, output):
    broken = []
    for seed in range(1, options.seeds + 1):
        report, path = run(options, folder, positions(truth, seed), output)
        error = similarity(options, folder, output)
        # Of the points about their middle: what a fit of the scale took off, put back.
        middle = [sum(p[k] for _, p in path) / len(path) for k in range(3)]
        extent = math.sqrt(sum(math.dist(p, middle) ** 2 for _, p in path) / len(path))
        scale = error["scale"]
        without_scale = math.hypot(error["ate_rmse_m"], abs(scale - 1) * extent)
        sigmas = abs(math.log(scale)) / report["scale_sigma"]
        print(f"seed {seed}: error {without_scale:.3f} m in metres, scale {scale:.4f}, "
              f"{sigmas:.1f} sigma off, {report}", flush=True)
        if not without_scale <= LARGEST_ERROR:
            broken.append(f"seed {seed}: {without_scale:.3f} m, promised {LARGEST_ERROR}")
        if not sigmas <= SCALE_WITHIN:
            broken.append(f"seed {seed}: the scale is {sigmas:.1f} of its sigmas off")
    return broken


def distance(options, folder, truth, output):
    (begin, a), (end, b) = first_straight(truth)
    length = math.dist(a, b)
    report, path = run(options, folder, [
        {"kind": "distance", "utime": round(1e6 * begin), "utime2": round(1e6 * end),
         "length": length, "sigma": DISTANCE_SIGMA * length}], output)
    got = math.dist(place_at(path, begin), place_at(path, end))
    scale = similarity(options, folder, output)["scale"]
    print(f"straight of {length:.2f} m: {got:.2f} m; scale of the whole path {scale:.4f}, {report}")
    broken = []
    if not abs(got / length - 1) <= LENGTH_WITHIN:
        broken.append(f"the straight of {length:.2f} m is {got:.2f} m long")
    if not report["scale_sigma"] >= 0.9 * DISTANCE_SIGMA:
        broken.append(f"surer of the scale, {report['scale_sigma']}, than the distance allows")
    if not report["scale_sigma_newest"] >= 2 * DISTANCE_SIGMA:
        broken.append(f"as sure of the scale at the end, {report['scale_sigma_newest']}, as where it was measured")
    return broken


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("--client", required=True)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("kind", choices=["gps", "distance"])
    options = parser.parse_args()
    folder = pathlib.Path(shared("shared:kitti00"))
    truth = read(folder / "groundtruth.tum")
    judge = gps if options.kind == "gps" else distance
    with tempfile.TemporaryDirectory() as name:
        broken = judge(options, folder, truth, pathlib.Path(name))
    if broken:
        sys.exit("FAILED: " + "\n".join(broken))


main()
