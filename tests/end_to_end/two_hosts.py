"""A second host for the tests of real processes: a network namespace, and how it is reached."""
import os
import subprocess
import time

from processes import fail, skip

URL = "udpm://239.255.76.67:7667?ttl=1&recv_buf_size=2097152"


def run(*command):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if result.returncode != 0:
        fail(" ".join(map(str, command)) + ": " + result.stderr)
    return result.stdout


class FarHost:
    """A network namespace of its own, held by a process that sleeps in it."""

    def __init__(self, processes):
        here = os.readlink("/proc/self/ns/net")
        self.holder = processes.start("far_host", "unshare", "--net", "sleep", "600").child.pid
        deadline = time.monotonic() + 10
        while os.readlink(f"/proc/{self.holder}/ns/net") == here:
            if time.monotonic() > deadline:
                skip("no second network namespace can be made here")
            time.sleep(0.01)
        run(*self.inside("ip", "link", "set", "lo", "up", "multicast", "on"))

    def inside(self, *command):
        return ["nsenter", f"--net=/proc/{self.holder}/ns/net", *command]

    def join_by_cable(self):
        run("ip", "link", "add", "near", "mtu", "1500", "type", "veth",
            "peer", "name", "far", "mtu", "1500", "netns", self.holder)
        for name, address, where in (("near", "10.9.0.1/24", lambda *words: words),
                                     ("far", "10.9.0.2/24", self.inside)):
            run(*where("ip", "address", "add", address, "dev", name))
            run(*where("ip", "link", "set", name, "up"))
            run(*where("ip", "route", "replace", "224.0.0.0/4", "dev", name))

    def keep_to_itself(self):
        run(*self.inside("ip", "route", "add", "224.0.0.0/4", "dev", "lo"))
