"""Cameras that extract features in hardware of their own: what `eifmap publish` sends of a
recording is heard once, then sent again and again under as many names as wanted, at a steady rate
and stamped with the moment when it leaves. Four extractors would take the machine that is measured.
"""
import itertools
import re
import select
import socket
import struct
import threading
import time

from processes import fail
from relay import GROUP, MAGIC_BYTES, PORT, channel_of, receiving_socket

FINGERPRINT = 8
RECORDED_AS = "x"  # names of cameras are as long, so that nothing moves in a message
PART_AT = FINGERPRINT + 24
SO_TIMESTAMPNS = 35


def now_us():
    return time.time_ns() // 1000


def payload_of(datagram):
    return bytearray(datagram[MAGIC_BYTES + len(channel_of(datagram)) + 1:])


class Recording:
    """What a publisher sends of each image, and of its calibration."""

    def __init__(self, processes, client, what):
        receiver = receiving_socket()
        publisher = processes.start("recorded", client, "publish", *what, "--as", "features",
                                    "--rate", "0", "--camera", RECORDED_AS)
        self.frames, self.calibration = [], None
        while publisher.child.poll() is None or select.select([receiver], [], [], 0.3)[0]:
            if select.select([receiver], [], [], 0.1)[0]:
                self.take(receiver.recv(65536))
        publisher.wait_for_end()
        sent = re.search(r"published (\d+).* images in (\d+) messages", publisher.text())
        heard = sum(len(parts) for parts in self.frames)
        if (len(self.frames), heard) != (int(sent[1]), int(sent[2])) or not self.calibration:
            fail(f"{len(self.frames)} images in {heard} messages were heard: {publisher.text()}")

    def take(self, datagram):
        channel = channel_of(datagram)
        if channel == f"eifmap.{RECORDED_AS}.calibration":
            self.calibration = payload_of(datagram)
        elif channel == f"eifmap.{RECORDED_AS}.features":
            message = payload_of(datagram)
            if struct.unpack_from(">h", message, PART_AT)[0] == 0:
                self.frames.append([])
            self.frames[-1].append(message)


class Camera:
    """Goes through other recordings once, and through this one in this order again and again."""

    def __init__(self, name, recording, publisher, order, before=()):
        self.name, self.publisher, self.calibration = name, publisher, recording.calibration
        self.frames = itertools.chain(*(other.frames for other in before),
                                      itertools.cycle([recording.frames[i] for i in order]))
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sent_us = []  # by number

    def send(self, kind, message):
        channel = f"eifmap.{self.name}.{kind}".encode()
        self.socket.sendto(b"LC02\0\0\0\0" + channel + b"\0" + message, (GROUP, PORT))

    def send_calibration(self):
        message = self.calibration[:]
        struct.pack_into(">qi2s", message, FINGERPRINT, now_us(), 2, self.name.encode() + b"\0")
        self.send("calibration", message)

    def send_frame(self):
        seq = len(self.sent_us)
        self.sent_us.append(now_us())
        for message in next(self.frames):
            struct.pack_into(">qqq", message, FINGERPRINT, self.sent_us[-1], self.publisher, seq)
            struct.pack_into(">i2s", message, PART_AT + 4, 2, self.name.encode() + b"\0")
            self.send("features", message)


def order_of(i, n):
    """Cameras 0 and 1 go there and back; 2 and 3 are carried to the beginning, lost, and make a new
    map from there. Every other one is ahead by a quarter.
    """
    forth = list(range(n))
    order = forth + forth[-2:0:-1] if i % 4 < 2 else forth
    ahead = i % 2 * n // 4
    return order[ahead:] + order[:ahead]


class Cameras:
    """All in a row, the pauses between them alike."""

    def __init__(self, names, recording, rate_hz, before=()):
        self.all = [Camera(name, recording, 1000 + i, order_of(i, len(recording.frames)), before)
                    for i, name in enumerate(names)]
        self.period_s = 1 / rate_hz

    def play_until(self, end):
        """`end` by the monotonic clock. What cannot leave in time leaves late, none is left out."""
        begin, n = time.monotonic(), 0
        while (due := begin + n * self.period_s / len(self.all)) < end:
            time.sleep(max(0, due - time.monotonic()))
            camera = self.all[n % len(self.all)]
            if len(camera.sent_us) % round(1 / self.period_s) == 0:
                camera.send_calibration()
            camera.send_frame()
            n += 1

    def send_last(self):
        """To a server that has had time to take the rest: it knows now what it missed."""
        time.sleep(2)
        for camera in self.all:
            camera.send_frame()
            time.sleep(0.5)


class PoseListener:
    """When each pose arrived, by the kernel's clock: no matter when this process had its turn."""

    def __init__(self):
        self.heard_us = {}  # by camera and number
        self.socket = receiving_socket()
        self.socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self.stopping = False
        self.thread = threading.Thread(target=self.listen, daemon=True)
        self.thread.start()

    def listen(self):
        while not self.stopping:
            if not select.select([self.socket], [], [], 0.2)[0]:
                continue
            datagram, extra, _, _ = self.socket.recvmsg(65536, 64)
            kind = datagram[MAGIC_BYTES:MAGIC_BYTES + 40].split(b"\0", 1)[0].decode().split(".")
            if kind[0] == "eifmap" and kind[-1] == "pose":
                seq = struct.unpack_from(">q", payload_of(datagram), FINGERPRINT + 16)[0]
                s, ns = struct.unpack("@qq", extra[0][2])
                self.heard_us[kind[1], seq] = s * 1_000_000 + ns // 1000

    def stop(self):
        self.stopping = True
        self.thread.join()
