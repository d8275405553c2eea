#!/usr/bin/env python3
"""A bad link: carries LCM's datagrams from this network namespace to that of another process, and on
the way loses, doubles and delays some. Calibrations pass. In the end, at SIGTERM, writes what it did
with each datagram of the frames, as JSON: {"lost": [...], "delivered": [...]} of [channel, time_us,
part, parts], in the order of delivery. A datagram carries one message: larger ones are refused.
"""
import argparse
import ctypes
import json
import random
import select
import signal
import socket
import struct
import time

GROUP, PORT = "239.255.76.67", 7667
WHOLE_MESSAGE, MAGIC_BYTES = b"LC02", 8
CLONE_NEWNET, SO_RCVBUFFORCE = 0x40000000, 33


def receiving_socket():
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        receiver.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 1 << 23)
    except OSError:  # for root alone
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 23)
    receiver.bind((GROUP, PORT))
    receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                        socket.inet_aton(GROUP) + struct.pack("=I", socket.INADDR_ANY))
    return receiver


def sending_socket(process):
    """Of the other network: a socket stays in the namespace that it was made in."""
    with open(f"/proc/{process}/ns/net") as namespace:
        if ctypes.CDLL(None, use_errno=True).setns(namespace.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), "setns")
    return socket.socket(socket.AF_INET, socket.SOCK_DGRAM)


def channel_of(datagram):
    if datagram[:4] != WHOLE_MESSAGE:
        raise ValueError(f"not a whole LCM message: {datagram[:4]}")
    return datagram[MAGIC_BYTES:datagram.index(b"\0", MAGIC_BYTES)].decode()


def describe(datagram):
    """[channel, time_us, part, parts] of a whole message; the frames begin with their time."""
    channel = channel_of(datagram)
    fields = datagram[MAGIC_BYTES + len(channel) + 1 + 8:]  # without the fingerprint
    part, parts = 0, 1
    if channel.endswith(".features"):
        part, parts = struct.unpack(">hh", fields[24:28])
    return [channel, struct.unpack(">q", fields[:8])[0], part, parts]


class Link:
    def __init__(self, options, send):
        self.options, self.send = options, send
        self.random = random.Random(options.seed)
        self.held = []  # (datagrams until it may go, when it must, it)
        self.record = {"lost": [], "delivered": []}

    def take(self, datagram):
        channel = channel_of(datagram)
        if not channel.startswith("eifmap.") or not self.is_mine(channel):
            return None  # LCM's own, or the way back
        if channel.endswith(".calibration"):
            return self.send(datagram)
        about = describe(datagram)
        self.release(passed=1)
        fate = self.random.random()
        if fate < self.options.lose:
            self.record["lost"].append(about)
        elif fate < self.options.lose + self.options.double:
            self.deliver(datagram, about)
            self.deliver(datagram, about)
        elif fate < self.options.lose + self.options.double + self.options.delay:
            due = time.monotonic() + self.options.hold_s
            self.held.append((self.options.behind, due, datagram, about))
        else:
            self.deliver(datagram, about)

    def is_mine(self, channel):
        kind = channel.rsplit(".", 1)[-1]
        return not self.options.kinds or kind in self.options.kinds

    def deliver(self, datagram, about):
        self.send(datagram)
        self.record["delivered"].append(about)

    def release(self, passed, everything=False):
        now, held = time.monotonic(), self.held
        self.held = []
        for left, due, datagram, about in held:
            if left <= 0 or due <= now or everything:
                self.deliver(datagram, about)
            else:
                self.held.append((left - passed, due, datagram, about))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", required=True, type=int, help="a process of the other network")
    parser.add_argument("--kinds", nargs="*", default=[], help="of channels; default: all")
    parser.add_argument("--lose", type=float, default=0.02)
    parser.add_argument("--double", type=float, default=0.02)
    parser.add_argument("--delay", type=float, default=0.05)
    parser.add_argument("--behind", type=int, default=2, help="a delayed one is so many behind")
    parser.add_argument("--hold-s", type=float, default=0.01, help="... or so long, at most")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--record", required=True)
    options = parser.parse_args()
    stopping = []
    signal.signal(signal.SIGTERM, lambda *_: stopping.append(True))
    receiver = receiving_socket()
    sender = sending_socket(options.to)
    link = Link(options, lambda datagram: sender.sendto(datagram, (GROUP, PORT)))
    print("relaying", flush=True)
    give_up = time.monotonic() + 300
    while not stopping and time.monotonic() < give_up:
        if select.select([receiver], [], [], 0.002)[0]:
            link.take(receiver.recv(65536))
        link.release(passed=0)
    link.release(passed=0, everything=True)
    with open(options.record, "w") as record:
        json.dump(link.record, record)


if __name__ == "__main__":
    main()
