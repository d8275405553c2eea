#!/usr/bin/env python3
"""The same images in every layout are the same map: the server's files must be the same to the bit.

But for the times of images alone. The folder is one of eifmap's own, of a pinhole camera; its images are linked into the others.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

FRAMES = 40
FILES = ["trajectory.tum", "trajectory_final.tum", "keyframes.tum", "map.ply"]


def link(images, folder, name):
    folder.mkdir(parents=True, exist_ok=True)
    for i, image in enumerate(images):
        (folder / name(i, image)).symlink_to(image.resolve())


def kitti(top, images, times, camera):
    folder = top / "sequences" / "00"
    link(images, folder / "image_0", lambda i, image: image.name)
    (folder / "times.txt").write_text("\n".join(times))
    (folder / "calib.txt").write_text(
        f"P0: {camera['fx']} 0 {camera['cx']} 0 0 {camera['fy']} {camera['cy']} 0 0 0 1 0\n")
    return [folder]


def tum(top, images, times, camera):
    link(images, top / "rgb", lambda i, image: times[i] + image.suffix)
    (top / "rgb.txt").write_text(
        "# color images\n"
        + "".join(f"{time} rgb/{time}{image.suffix}\n" for time, image in zip(times, images)))
    (top / "camera.yaml").write_text(
        f"image_width: {camera['width']}\nimage_height: {camera['height']}\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{camera['fx']}, 0, {camera['cx']}, "
        f"0, {camera['fy']}, {camera['cy']}, 0, 0, 1]\ndistortion_model: plumb_bob\n"
        "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0, 0, 0, 0, 0]\n")
    return [top, "--calib", top / "camera.yaml"]


def euroc(top, images, times, camera):
    stamps = [str(round(float(time) * 1e6) * 1000) for time in times]
    cam0 = top / "mav0" / "cam0"
    link(images, cam0 / "data", lambda i, image: stamps[i] + image.suffix)
    (cam0 / "data.csv").write_text(
        "#timestamp [ns],filename\n"
        + "".join(f"{stamp},{stamp}{image.suffix}\n" for stamp, image in zip(stamps, images)))
    (cam0 / "sensor.yaml").write_text(
        "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
        f"resolution: [{camera['width']}, {camera['height']}]\ncamera_model: pinhole\n"
        f"intrinsics: [{camera['fx']}, {camera['fy']}, {camera['cx']}, {camera['cy']}]\n"
        "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n")
    return [top]


def plain(top, images, times, camera):
    link(images, top, lambda i, image: f"shot{i}{image.suffix}")  # shot9 before shot10
    rate = (len(times) - 1) / (float(times[-1]) - float(times[0]))
    (top / "calib.json").write_text(json.dumps(camera))
    return [top, "--rate", str(round(rate, 6))]


def without_times(files):
    """Images alone begin at 0."""
    return {name: [line.split(b" ", 1)[-1] for line in text.splitlines()]
            for name, text in files.items()}


def run(server, arguments, output):
    command = [server, "--sequence", *map(str, arguments), "--output", output]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"FAILED: {' '.join(map(str, command))}\n{done.stdout}")
    return {file: (output / file).read_bytes() for file in FILES}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("folder", type=pathlib.Path)
    options = parser.parse_args()
    camera = json.loads((options.folder / "calib.json").read_text())
    images = sorted((options.folder / "images").iterdir())[:FRAMES]
    times = (options.folder / "times.txt").read_text().split()[:FRAMES]
    with tempfile.TemporaryDirectory() as name:
        top = pathlib.Path(name)
        own = run(options.server, [options.folder, "--max-frames", FRAMES], top / "own")
        if own["trajectory.tum"].count(b"\n") < FRAMES / 2:
            sys.exit("FAILED: few images were mapped: this shows nothing")
        for layout in (kitti, tum, euroc, plain):
            folder = top / layout.__name__
            folder.mkdir()
            found = run(options.server, layout(folder, images, times, camera), folder / "out")
            wanted = own
            if layout is plain:
                found, wanted = without_times(found), without_times(own)
            other = [file for file in FILES if found[file] != wanted[file]]
            if other:
                sys.exit(f"FAILED: {layout.__name__}: {', '.join(other)} are others")
            print(f"{layout.__name__}: the same to the bit")


main()
