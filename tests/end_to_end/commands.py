#!/usr/bin/env python3
"""A running server under command, over udpm: eifmap ctl, with and without a secret.

Run it inside a private network (support/private_network.sh). What was paused and reset on the way must
be replayed from its decisions to the bit.
"""
import json
import pathlib
import subprocess
import tempfile
import time

from processes import Processes, fail, last_status, lines, live_options, parse_live, wait_for

OFF_HOST = "udpm://239.255.76.67:7667?ttl=1&recv_buf_size=2097152"
CAMERA = "camera"  # as publish calls it
SECRET, WRONG = "the secret of this test\n", "another one of that length\n"


class Control:
    """eifmap ctl, and what it must answer."""

    def __init__(self, client, *options):
        self.client, self.options = client, options

    def run(self, *arguments):
        return subprocess.run([self.client, "ctl", *arguments, *self.options], text=True,
                              capture_output=True, timeout=60, check=False)

    def expect(self, code, *arguments, words=()):
        run = self.run(*arguments)
        said = run.stdout + run.stderr
        print(f"ctl {' '.join(map(str, arguments))}: {run.returncode} {said.strip()}")
        if run.returncode != code:
            fail(f"ctl {arguments} ended with {run.returncode}, not {code}:\n{said}")
        for word in words:
            if word not in said:
                fail(f"ctl {arguments} does not say '{word}':\n{said}")
        return said

    def reply(self, *arguments):
        return json.loads(self.expect(0, *arguments, "--json"))


def pause_and_resume(control, folder):
    poses = folder / "logged" / "poses.jsonl"
    control.expect(0, "pause", words=["OK: paused"])
    wait_for("the status of a pause", lambda: last_status(folder / "logged")["state"] == 4, seconds=20)
    if control.reply("ping", "--camera", CAMERA)["values"]["state"] != "PAUSED":
        fail("a paused camera does not say so")
    before = len(lines(poses))
    time.sleep(1)
    if len(lines(poses)) != before:
        fail("a paused camera was mapped")
    left_out = int(control.reply("resume")["values"]["frames_left_out"])
    if left_out < 3:
        fail(f"{left_out} frames were left out in a second: this shows nothing")
    wait_for("what comes after a pause", lambda: len(lines(poses)) >= before + 20)
    status = last_status(folder / "logged")
    if status["state"] == 4 or int(status["diagnostics"]["frames.PAUSED"]) != left_out:
        fail(f"{left_out} frames were left out, but {status}")


def reset(control, folder):
    # Where the pause was long the camera may have been lost after it, and be in another map.
    before = int(control.reply("map", "--camera", CAMERA)["values"]["map_id"])
    given_up = int(control.reply("reset", "--camera", CAMERA)["values"]["map_given_up"])
    if before < 1 or given_up != before:
        fail(f"map {given_up} was given up, there was {before}")
    wait_for("another map", lambda: last_status(folder / "logged")["map_id"] == before + 1, seconds=20)


def one_run(options, folder):
    """Everything once, while images come; the server ends by command."""
    control = Control(options.client)
    with Processes(folder) as processes:
        control.expect(1, "ping", "--timeout", "0.5",
                       words=["no reply in 0.5 s: is a server running at udpm://"])
        server = processes.start("server", options.server, "--output", folder / "live")
        server.wait_for_words("listening on")
        control.expect(1, "pause", words=["NO_MAP"])
        logger = processes.start("logger", options.client, "log", folder / "logged")
        logger.wait_for_words("logging")
        publisher = processes.start("publisher", options.client, "publish", *options.publish)
        wait_for("a map", lambda: len(lines(folder / "logged" / "poses.jsonl")) >= 30)
        if control.reply("ping")["values"]["cameras"] != CAMERA:
            fail("the server does not say what it maps")
        pause_and_resume(control, folder)
        reset(control, folder)
        control.expect(1, "save", words=["UNSUPPORTED", "--maps"])
        control.expect(1, "ping", "--camera", "cam1", "--timeout", "0.5", words=["and mapping cam1?"])
        publisher.wait_for_end()
        if int(control.reply("snapshot")["values"]["parts"]) < 1:
            fail("no map was sent again")
        control.expect(0, "shutdown", words=["OK: the server ends"])
        server.wait_for_end()
        logger.wait_for_end()
    control.expect(1, "ping", "--timeout", "0.5", words=["no reply"])


def wait_until_all_is_published(control, poses):
    """Of a map that stays: poses rest on it as it is, and it is published once it is on the disk."""
    count = len(lines(poses)) + 3
    wait_for("a pose in the map that stays", lambda: len(lines(poses)) >= count)
    seq = json.loads(lines(poses)[count - 1])["map_seq"]
    wait_for("the whole of the map that stays",
             lambda: control.reply("map", "--camera", CAMERA)["map_seq"] == seq)


def stored(options, folder):
    """Maps on the disk, by command."""
    control = Control(options.client)
    with Processes(folder) as processes:
        server = processes.start("server", options.server, "--maps", folder / "maps")
        server.wait_for_words("listening on")
        logger = processes.start("logger", options.client, "log", folder / "logged")
        logger.wait_for_words("logging")
        publisher = processes.start("publisher", options.client, "publish", *options.publish)
        poses = folder / "logged" / "poses.jsonl"
        wait_for("a map", lambda: len(lines(poses)) >= 40)
        control.expect(1, "load", "nothing", words=["MAP_FILE_UNREADABLE"])
        control.expect(1, "save", "../up", words=["BAD_ARGUMENTS"])
        saved = pathlib.Path(control.reply("save", "kitchen", "--camera", CAMERA)["values"]["file"])
        if not saved.is_relative_to(folder / "maps"):
            fail(f"the map was saved as {saved}")
        subprocess.run([options.server, "--check-map", saved], check=True)
        # From here to the undo the map must stay: it is the checkpoint's.
        control.expect(0, "localize-only", "on")
        wait_until_all_is_published(control, poses)
        before = control.reply("map", "--camera", CAMERA)["values"]
        control.expect(0, "checkpoint")
        localized = len(lines(poses)) + 25
        wait_for("what is localized", lambda: len(lines(poses)) >= localized)
        after = control.reply("map", "--camera", CAMERA)["values"]
        if before["digest"] != after["digest"]:
            fail("the map has changed, although the camera was only to be localized")
        control.expect(0, "undo")
        undone = control.reply("map", "--camera", CAMERA)["values"]
        if undone["map_id"] != "2" or any(undone[of] != before[of] for of in ("keyframes", "landmarks")):
            fail(f"undone to {undone}, the map was {before}")
        control.expect(0, "localize-only", "off")
        publisher.wait_for_end()
        # The camera may have gone on to where that map does not reach: then another begins.
        ids = [json.loads(line)["map_id"] for line in lines(folder / "logged" / "status.jsonl")]
        if 2 not in ids:
            fail(f"the map that was gone back to was never in use, but {set(ids)}")
        if int(control.reply("load", "kitchen", "--camera", CAMERA)["values"]["map_id"]) < 3:
            fail("no map was loaded")
        control.expect(0, "shutdown")
        server.wait_for_end()
        logger.wait_for_end()


def replay(options, folder):
    decisions = folder / "logged" / "decisions.jsonl"
    made = [json.loads(line) for line in lines(decisions)]
    resets = [made.index(decision) for decision in made if decision.get("after_reset")]
    print(f"{len(made)} images mapped of {options.frames}, reset before number {resets}")
    if len(resets) != 1 or len(made) > options.frames - 5:
        fail("a reset and left-out images are not in the decisions: this shows nothing")
    for file in (decisions, folder / "live" / "decisions.jsonl"):
        run = subprocess.run(
            [options.server, "--sequence", options.offline, "--output", folder / "again",
             "--decisions", file], capture_output=True, text=True, check=False)
        if run.returncode != 0:
            fail(f"the replay of {file} ended with {run.returncode}:\n{run.stderr}")
        for name in ("trajectory.tum", "trajectory_final.tum", "keyframes.tum", "decisions.jsonl",
                     "map.ply"):
            live = (folder / "live" / name).read_bytes()
            if live != (folder / "again" / name).read_bytes() or live.count(b"\n") < 5:
                fail(f"{name} of the replay of {file} is another, or there is none")


def secret_files(folder):
    files = {}
    for name, text in (("right", SECRET), ("wrong", WRONG), ("short", "short\n"), ("open", SECRET)):
        files[name] = folder / name
        files[name].write_text(text)
        files[name].chmod(0o644 if name == "open" else 0o600)
    return files


def who_may_command(options, folder):
    files = secret_files(folder)
    for name, words in (("short", "holds 5 bytes, wanted 16"), ("open", "others can read it; chmod")):
        Control(options.client).expect(2, "ping", "--secret-file", files[name], words=[words])
        run = subprocess.run([options.server, "--secret-file", files[name]], capture_output=True,
                             text=True, timeout=60, check=False)
        if run.returncode != 2 or words not in run.stderr:
            fail(f"a server with a bad secret ended with {run.returncode}:\n{run.stderr}")
    control = Control(options.client, "--lcm-url", OFF_HOST)
    with Processes(folder) as processes:
        server = processes.start("no_secret", options.server, "--lcm-url", OFF_HOST)
        server.wait_for_words("listening on")
        control.expect(1, "shutdown", words=["DENIED SECRET_WANTED", "--secret-file"])
        if server.child.poll() is not None:
            fail("a server without a secret was shut down from its network")
    config = folder / "config.json"
    config.write_text(json.dumps({"secret_file": str(files["right"])}))
    with Processes(folder) as processes:
        server = processes.start("secret", options.server, "--lcm-url", OFF_HOST, "--config", config)
        server.wait_for_words("listening on")
        control.expect(1, "shutdown", words=["DENIED NOT_SIGNED", "--secret-file"])
        control.expect(1, "shutdown", "--secret-file", files["wrong"], words=["DENIED BAD_SIGNATURE"])
        if server.child.poll() is not None:
            fail("a server was shut down without its secret")
        control.expect(0, "ping", "--secret-file", files["right"], words=["OK: here"])
        control.expect(0, "shutdown", "--secret-file", files["right"])
        server.wait_for_end()
        if SECRET.strip() in server.text():
            fail("a secret was written")


def main():
    options = parse_live(live_options(__doc__))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        one_run(options, folder)
        replay(options, folder)
        who_may_command(options, folder)
    with tempfile.TemporaryDirectory() as name:
        stored(options, pathlib.Path(name))


main()
