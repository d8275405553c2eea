#!/usr/bin/env python3
"""The figures that a running server of two cameras serves for Prometheus, read with urllib.

They must be there while it maps, be of both cameras, and be the status's; whatever else is asked for is
refused, and a connection that asks for nothing holds up nobody. Run it inside a private network
(support/private_network.sh).
"""
import argparse
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

from processes import Processes, fail, last_status, wait_for_lines

PORT = 19464
URL = f"http://127.0.0.1:{PORT}/metrics"
CAMERAS = ["front", "left"]
SAMPLE = re.compile(r'^(eifmap_\w+(?:\{(?:\w+="(?:[^"\\\n]|\\.)*",?)+\})?) (\S+)$')


def scrape():
    with urllib.request.urlopen(URL, timeout=10) as answer:
        kind = answer.headers["Content-Type"]
        text = answer.read().decode()
    if kind != "text/plain; version=0.0.4; charset=utf-8":
        fail(f"its type is {kind}")
    samples = {}
    for line in text.splitlines():
        if line.startswith("# HELP ") or line.startswith("# TYPE "):
            continue
        match = SAMPLE.match(line)
        if not match:
            fail(f"no sample: {line}")
        samples[match[1]] = float(match[2])
    return samples


def refused_with(request):
    try:
        with urllib.request.urlopen(request, timeout=10) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def check_refusals():
    for request, status in [
            (urllib.request.Request(URL.replace("/metrics", "/")), 404),
            (urllib.request.Request(URL, data=b"x=1"), 405),
            (urllib.request.Request(URL, headers={"Host": "elsewhere.example"}), 403),
            (urllib.request.Request(URL, headers={"Origin": "http://elsewhere.example"}), 403)]:
        answered = refused_with(request)
        if answered != status:
            fail(f"{request.get_method()} {request.full_url} {request.headers}: {answered}, "
                 f"wanted {status}")


def check_taken_port(options):
    ended = subprocess.run([options.server, "--metrics-port", str(PORT)], capture_output=True,
                           text=True, timeout=30, check=False)
    if ended.returncode != 1 or f"port {PORT} of 127.0.0.1 is taken" not in ended.stderr:
        fail(f"a second server at the same port ended with {ended.returncode}: {ended.stderr}")


def of_camera(samples, name, camera):
    return samples.get(f'eifmap_{name}{{camera="{camera}"}}')


def check_figures(samples, folder):
    """What is wrong with them, beside what each camera's last status says; "" nothing."""
    if samples["eifmap_cameras"] != len(CAMERAS):
        return f"{samples['eifmap_cameras']} cameras"
    if samples["eifmap_resident_memory_bytes"] < 1e6:
        return "no memory in use"
    for camera in CAMERAS:
        status = last_status(folder / camera)
        for name, key in [("frames_processed_total", "frames_processed"), ("keyframes", "keyframes"),
                          ("frames_received_total", "frames_received"), ("landmarks", "landmarks"),
                          ("map_seq", "map_seq")]:
            if of_camera(samples, name, camera) != status[key]:
                return (f"{camera}: {name} is {of_camera(samples, name, camera)}, "
                        f"the status says {status[key]}")
        if status["keyframes"] < 3:
            return f"{camera} has no map"
        print(f"{camera}: {status['frames_processed']} frames, {status['keyframes']} keyframes")
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True)
    parser.add_argument("--client", required=True)
    parser.add_argument("--frames", type=int, default=40)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, Processes(pathlib.Path(name)) as processes:
        folder = pathlib.Path(name)
        server = processes.start("server", options.server, "--metrics-port", PORT,
                                 "--input", "lossless")
        server.wait_for_words("listening on")
        if scrape()["eifmap_cameras"] != 0:
            fail("there are cameras before any was heard")
        check_refusals()
        check_taken_port(options)
        idle = socket.create_connection(("127.0.0.1", PORT))
        for camera in CAMERAS:
            processes.start("logger_" + camera, options.client, "log", folder / camera,
                            "--camera", camera).wait_for_words("logging")
        publishers = [processes.start(camera, options.client, "publish", "--simulate", "courtyard",
                                      "--camera", camera, "--rate", "10", "--max-frames",
                                      options.frames) for camera in CAMERAS]
        during = 0
        while any(publisher.child.poll() is None for publisher in publishers):
            during = scrape().get("eifmap_cameras", 0)
            time.sleep(0.2)
        if during != len(CAMERAS):
            fail(f"{during} cameras while {len(CAMERAS)} were published")
        for camera in CAMERAS:
            wait_for_lines(folder / camera / "poses.jsonl", options.frames)
        # The status comes every second.
        deadline = time.monotonic() + 20
        while problem := check_figures(scrape(), folder):
            if time.monotonic() > deadline:
                fail(problem)
            time.sleep(0.5)
        idle.close()
        server.child.send_signal(signal.SIGTERM)
        server.wait_for_end()


main()
