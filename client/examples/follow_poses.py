#!/usr/bin/env python3
"""Prints the poses that a server publishes, as TUM lines: time x y z qx qy qz qw.

Needs nothing but Python and the types that lcm-gen makes of eifmap's schemas:

  lcm-gen --python --ppath types messages/*.lcm
  PYTHONPATH=types client/examples/follow_poses.py

With LCM's own Python module, where there is one, the socket below is lcm.LCM().subscribe().
"""
import argparse
import socket
import struct

from eifmap import pose_t

GROUP, PORT = "239.255.76.67", 7667
WHOLE_MESSAGE, HEADER_BYTES = b"LC02", 8  # magic, number of the message


def join(group, port):
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    receiver.bind((group, port))
    receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                        socket.inet_aton(group) + struct.pack("=I", socket.INADDR_ANY))
    return receiver


def messages(receiver):
    """(channel, payload) of every message that fits one datagram, as poses do."""
    while True:
        datagram = receiver.recv(65536)
        end = datagram.find(b"\0", HEADER_BYTES)
        if datagram[:4] == WHOLE_MESSAGE and end >= 0:
            yield datagram[HEADER_BYTES:end].decode("ascii", "replace"), datagram[end + 1:]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--camera", default="", help="default: every one")
    options = parser.parse_args()
    for channel, payload in messages(join(GROUP, PORT)):
        if not channel.endswith(".pose") or options.camera not in ("", channel.split(".")[1]):
            continue
        try:
            pose = pose_t.decode(payload)
        except (ValueError, struct.error):
            continue  # not of this version
        if pose.state == pose_t.STATE_TRACKING:
            w, x, y, z = pose.quaternion
            print(f"{pose.utime / 1e6:.6f}", *pose.position, x, y, z, w, flush=True)


main()
