#!/usr/bin/env python3
"""Typical mistakes with the real programs: each must end with a code, and with one sentence that names
the value and says what to do.

With --no-route only what needs a network without a route for multicast: run that inside one
(support/private_network.sh), where this script takes the route away.
"""
import argparse
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

CALIBRATION = '{"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 32, "cy": 24}'


def png(width=64, height=48):
    """A gray image as a PNG file's bytes."""
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))
    rows = (b"\0" + b"\x80" * width) * height
    return (b"\x89PNG\r\n\x1a\n"
            + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def recording(folder, times="0\n0.1\n0.2\n", calibration=CALIBRATION, images=3):
    (folder / "images").mkdir(parents=True)
    for i in range(images):
        (folder / "images" / f"{i:06}.png").write_bytes(png())
    if times is not None:
        (folder / "times.txt").write_text(times)
    if calibration is not None:
        (folder / "calib.json").write_text(calibration)
    return folder


class Check:
    def __init__(self, programs):
        self.programs = programs
        self.failures = []
        self.count = 0

    def __call__(self, command, *words, code=2):
        program, *arguments = command
        done = subprocess.run([self.programs[program], *map(str, arguments)], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60)
        self.count += 1
        # What goes well before the mistake is found may be told.
        lines = [line for line in done.stdout.splitlines()
                 if " info " not in line and " images  " not in line]
        problems = [f"'{word}' is not said" for word in words if word not in done.stdout]
        if done.returncode != code:
            problems.append(f"the code is {done.returncode}, not {code}")
        if len(lines) != 1 or " error " not in lines[0]:
            problems.append(f"{len(lines)} lines instead of one error")
        if problems:
            call = " ".join([program, *map(str, arguments)])
            self.failures.append(f"{call}\n  {'; '.join(problems)}:\n  {done.stdout}")


def folders(check, top):
    publish = ("eifmap", "publish")
    check([*publish, top / "none"], "none: does not exist", "give a folder of images")
    (top / "empty").mkdir()
    check([*publish, top / "empty"], "empty: is empty; wanted a folder that holds images/")
    (top / "text").mkdir()
    (top / "text" / "readme.md").write_text("words")
    check([*publish, top / "text"], "text: holds no images in a known layout; wanted images/")
    (top / "hollow" / "images").mkdir(parents=True)
    check([*publish, top / "hollow"], "hollow/images: holds no images; wanted files .jpg")
    check([*publish, recording(top / "no_calib", calibration=None)],
          "no_calib: has no calibration", "--calib FILE", "--hfov DEGREES")
    check([*publish, recording(top / "no_times", times=None)],
          "times.txt: cannot be read; wanted a line an image", "--rate HZ")
    check([*publish, recording(top / "short", times="0\n0.1\n")],
          "short/times.txt: has 2 times for 3 images; wanted one each")
    check([*publish, recording(top / "unsorted", times="0\n0.2\n0.1\n")],
          "unsorted/times.txt line 3: 0.1 s is not after", "times must increase")
    check([*publish, recording(top / "words", times="0\nsoon\n0.2\n")],
          "words/times.txt line 2: 'soon' is no time; wanted seconds")
    sizes = recording(top / "sizes", calibration=CALIBRATION.replace("64", "128"))
    check([*publish, sizes], "the images are 64x48, but calib.json says 128x48", "--calib FILE")
    broken = recording(top / "broken")
    (broken / "images" / "000001.png").write_bytes(b"no PNG")
    check([*publish, "--lcm-url", "memq://", "--rate", "0", broken],
          "000001.png: cannot be decoded as an image", code=1)
    check([*publish, broken / "images" / "000000.png"], "000000.png: is a single image; give the folder")
    check([*publish, broken / "times.txt", "--hfov", "60"],
          "times.txt: cannot be opened as a video; give")
    check([*publish, "/dev/video987", "--hfov", "60"], "/dev/video987: there is no such camera; ls")


def calibrations(check, top):
    good = recording(top / "good")
    for text, *words in [
            ('{"width": 64,\n"height": 48,\n"fx": 50 "fy": 50}', "calib.json line 3: is no JSON",
             "look for a missing quote, comma or bracket"),
            (CALIBRATION.replace('"fx": 50', '"fx": -50'), "calib.json: camera: fx is -50", "wanted"),
            (CALIBRATION.replace('"fy": 50, ', ""), "'fy' is missing or no number; wanted pixels"),
            (CALIBRATION[:-1] + ', "model": "fishy"}', "'model' is \"fishy\"; wanted pinhole"),
            (CALIBRATION[:-1] + ', "distortion": "none"}', "'distortion' is \"none\"; wanted up to 5")]:
        (good / "calib.json").write_text(text)
        check(["eifmap", "publish", good], *words)
    check(["eifmap", "publish", good, "--hfov", "200"], "--hfov: '200' is out of range, wanted 10 to 150")
    check(["eifmap", "publish", good, "--hfov", "60", "--calib", "a.json"],
          "--hfov guesses what --calib a.json says: leave one of them out")
    check(["eifmap", "publish", good, "--calib", top / "none.json"], "none.json: cannot be read")
    (top / "folder.json").mkdir()
    check(["eifmap", "publish", good, "--calib", top / "folder.json"], "folder.json: cannot be read")
    (top / "folder.yaml").mkdir()
    check(["eifmap", "publish", good, "--calib", top / "folder.yaml"], "folder.yaml: cannot be read")
    check(["eifmap-server", "--lcm-url", "memq://", "--calib", top / "none.json"],
          "none.json: cannot be read")


def options(check, top):
    good = recording(top / "fine")
    publish = ("eifmap", "publish", good)
    check(["eifmap", "publsh", good], "'publsh' means nothing to eifmap; did you mean publish?")
    check(["eifmap"], "eifmap --help shows what there is")
    check(["eifmap", "publish"], "publish wants a source of images")
    check(["eifmap", "publish", "--simulate", "moon"], "'moon'", "courtyard")
    check([*publish, "--simulate", "courtyard"], "fine", "leave one of them out")
    check([*publish, "--rat", "5"], "'--rat' means nothing", "did you mean --rate?")
    check([*publish, "--rate", "-5"], "--rate: '-5' is out of range, wanted 0 to 10000")
    check([*publish, "--extractor", "orb"], "--extractor: 'orb' is unknown, wanted surf_upright")
    check([*publish, "--as", "png"], "--as: 'png' is unknown, wanted raw, mjpeg or features")
    check([*publish, "--features-cap", "0"], "--features-cap: '0' is out of range, wanted 1 to 100000")
    measurements = top / "measurements.jsonl"
    measurements.write_text('{"kind": "position", "utime": 5, "position": [1, 2], "sigma": 1}\n')
    check([*publish, "--measurements", measurements], "measurements.jsonl line 1: ", "3 numbers")
    check([*publish, "--measurements", top / "none.jsonl"], "none.jsonl: cannot be read")
    check([*publish, "--measurements", measurements, "--loop"], "--loop are others: leave one")
    view = ("eifmap", "view")
    check([*view, "--port", "65536"], "--port is 65536, wanted 0 to 65535")
    check([*view, "--address", "localhost"], "--address is 'localhost', wanted an IPv4 address")
    check([*view, "--address", "192.0.2.1"], "no address of this machine", "127.0.0.1", code=1)
    ctl = ("eifmap", "ctl")
    check([*ctl, "halt"], "'halt' is unknown, wanted ping, pause,")
    check([*ctl, "load"], "load name: name is missing")
    check([*ctl, "pause", "now"], "'now' is too much: pause is all that it takes")
    check([*ctl, "pause", "--camera", "a b"], "camera is 'a b', wanted 1 to 24 characters")
    check([*ctl, "pause", "--timeout", "0"], "--timeout: '0' is out of range, wanted 0.1 to 3600")
    check([*ctl, "pause", "--secret-file", top / "none"], "none: cannot be read: No such file")
    check([*ctl, "pause", "--secret-file", top], "is no file")
    check([*ctl, "pause", "--lcm-url", "nonsense://"], "LCM cannot be opened at nonsense://", code=1)
    check([*publish, "--camera", "front left"], "camera is 'front left', wanted 1 to 24 characters")
    for url, *words in [("nonsense://", "it names no kind of network", "wanted one like udpm://"),
                        ("udpm://239.255.76.67:99999", "its port is 99999, wanted 1 to 65535"),
                        ("udpm://10.0.0.1:7667", "its group is 10.0.0.1, wanted a multicast one")]:
        check([*publish, "--lcm-url", url], "LCM cannot be opened at " + url, *words, code=1)
        check(["eifmap-server", "--lcm-url", url], "LCM cannot be opened at " + url, *words, code=1)
    (top / "file").write_text("")
    check(["eifmap", "log", "--lcm-url", "memq://", top / "file" / "log"],
          "file/log: cannot be made", "give another folder")
    check(["eifmap", "eval", "--gt", top / "none.tum", "--est", top / "none.tum"],
          "none.tum: cannot be read", code=1)


def server(check, top):
    good = recording(top / "whole")
    run = ("eifmap-server", "--sequence", good)
    check(run, "--sequence needs --output FOLDER")
    check([*run, "--output", top / "file" / "out"], "file/out: nothing can be written there",
          "give another folder by --output", code=1)
    check([*run, "--output", top / "file"], "file: nothing can be written there", code=1)
    check(["eifmap-server", "--sequence", top / "none", "--output", top / "out"],
          "none: does not exist; give a folder", code=1)
    check([*run, "--output", top / "out", "--input", "newest"],
          "--input is of a live server", "leave one of them out")
    check([*run, "--output", top / "out", "--lcm-url", "memq://"], "--lcm-url is of a live server")
    check([*run, "--output", top / "out", "--every", "0"], "--every: '0' is out of range, wanted 1 or")
    check(["eifmap-server", "--every", "2"], "--every is of recorded images: give them by --sequence")
    log = ["eifmap-server", "--log", top / "none.log"]
    check(log, "--log needs --output FOLDER")
    check([*log, "--output", top / "out"], "none.log: cannot be read",
          "give a log that lcm-logger wrote", code=1)
    check([*log, "--sequence", good], "--sequence and --log are two runs")
    check([*log, "--input", "newest"], "--input is of a live server, and --log maps without a network")
    check(["eifmap-server", "--verify"], "--verify is of a log: give it by --log")
    check([*run, "--outptu", top / "out"], "'--outptu' means nothing", "did you mean --output?")
    check(["eifmap-server", "--input", "fastest"], "'fastest' is unknown, wanted newest or lossless")
    decisions = top / "decisions.jsonl"
    decisions.write_text('{"utime": 5, "publisher": 1, "seq": 0, "adopted_job": 0, '
                         '"state_digest": 7, "measurements": [[3, 0]]}\n')
    check([*run, "--output", top / "out", "--decisions", decisions],
          "1 absolute measurements had a part in that run; give its measurements.jsonl", code=1)
    for image in (good / "images").iterdir():
        image.write_bytes(b"no PNG")
    check([*run, "--output", top / "out"], "none of the 3 images could be used",
          "000000.png: cannot be decoded as an image", code=1)

    config = top / "config.json"
    for text, *words in [
            ('{"mapper": {"edge": {"enabld": true}}}', "config.json: mapper.edge.enabld: unknown",
             "did you mean enabled?"),
            ('{"mapper": {"keyframe": {"min_inliers": 2}}}', "keyframe.min_inliers is 2", "wanted"),
            ('{"features": {"max_features": "many"}}',
             'features.max_features: must be a whole number, is "many"'),
            ('{"features": {"extractor": "orb"}}', 'features.extractor: must be one of', 'is "orb"'),
            ('{\n"input": "newest",\n"camera" "front"}', "config.json: line 3 is not JSON; look for")]:
        config.write_text(text)
        check(["eifmap-server", "--config", config], *words)
    check(["eifmap-server", "--config", top / "none.json"], "none.json: cannot be read")


def no_route(check, top):
    subprocess.run(["ip", "route", "del", "224.0.0.0/4", "dev", "lo"], check=True)
    words = "LCM cannot be opened at udpm://", "there is no route for multicast", "ip route add"
    check(["eifmap", "publish", recording(top / "good")], *words, code=1)
    check(["eifmap", "log", top / "log"], *words, code=1)
    check(["eifmap-server"], *words, code=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("--client", required=True)
    parser.add_argument("--no-route", action="store_true")
    arguments = parser.parse_args()
    check = Check({"eifmap": arguments.client, "eifmap-server": arguments.server})
    with tempfile.TemporaryDirectory() as name:
        for group in [no_route] if arguments.no_route else [folders, calibrations, options, server]:
            group(check, pathlib.Path(name))
    if check.failures:
        sys.exit(f"FAILED {len(check.failures)} of {check.count}:\n" + "\n".join(check.failures))
    print(f"{check.count} mistakes, each answered by one sentence")


main()
