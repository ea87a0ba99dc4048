#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A measuring session over the line protocol, written from docs/protocol-line.md alone, with Python's own library.

    line_scan.py /dev/... RADIUS_MM

Scans an arc about a round bar that stands along z at the origin; RADIUS_MM is that of the ball centre in contact.
Prints one line for each check; the exit code is 1 when one failed.
"""
import binascii
import math
import os
import select
import struct
import sys
import time
import tty
import zlib

OWNER = 7


def check(name, good, detail=""):
    print("ok   " if good else "FAIL ", name, detail)
    if not good:
        sys.exit(1)


def cobs_decode(data):
    out, at = bytearray(), 0
    while at < len(data):
        code = data[at]
        out += data[at + 1:at + code]
        at += code
        if code < 255 and at < len(data):
            out.append(0)
    return bytes(out)


class Varints:
    def __init__(self, data):
        self.data, self.at = data, 0

    def next(self):
        value, shift = 0, 0
        while True:
            byte = self.data[self.at]
            self.at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    def signed(self):
        value = self.next()
        return -(value + 1) // 2 if value & 1 else value // 2


class Controller:
    def __init__(self, port):
        self.fd = os.open(port, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.fd)
        self.tag, self.watchdog, self.buffer = 0, 0, b""
        self.seq = int(self.ask("ST").split()[5])

    def read(self, delimiter):
        deadline = time.monotonic() + 5
        while delimiter not in self.buffer:
            left = deadline - time.monotonic()
            check("an answer in time", left > 0) if left <= 0 else None
            if select.select([self.fd], [], [], max(0, left))[0]:
                self.buffer += os.read(self.fd, 4096)
        part, self.buffer = self.buffer.split(delimiter, 1)
        return part

    def send(self, body):
        self.tag += 1
        line = "#%d %s" % (self.tag, body)
        os.write(self.fd, ("%s*%04X\n" % (line, binascii.crc_hqx(line.encode(), 0xFFFF))).encode())

    def ask(self, body, mark="="):
        self.buffer = b""
        self.send(body)
        text, crc = self.read(b"\n").decode().rsplit("*", 1)
        check("CRC of an answer", int(crc, 16) == binascii.crc_hqx(text.encode(), 0xFFFF), text)
        check(body.split()[0], text.startswith("%s%d" % (mark, self.tag)), text)
        return text.partition(" ")[2]

    def samples(self, acknowledge, first):
        self.watchdog = self.watchdog % 65535 + 1
        self.send("SA %d %d %d 64" % (self.watchdog, acknowledge, first))
        self.read(b"\0")
        payload = cobs_decode(self.read(b"\0"))
        check("CRC-32 of a frame", struct.unpack("<I", payload[-4:])[0] == zlib.crc32(payload[:-4]))
        kind, tag, _, state, flags, path, first, newest, time_us, count = struct.unpack("<BHHBBHIIqH", payload[:27])
        check("a frame for the question", kind == ord("S") and tag == self.tag, (kind, tag))
        numbers, rows, points = Varints(payload[27:-4]), [[], [], [], []], []
        for k in range(count):
            for row in rows:
                expected = 0 if k == 0 else row[-1] if k == 1 else 2 * row[-1] - row[-2]
                row.append(expected + numbers.signed())
            points.append((first + k, [row[-1] for row in rows[:3]], time_us + rows[3][-1], numbers.next()))
        check("a frame without a rest", numbers.at == len(payload) - 31)
        return flags, newest, points

    def run(self, words, expected=0):
        self.seq = self.seq % 65535 + 1
        self.ask("DO %d %d %s" % (self.seq, OWNER, words))
        while True:
            self.samples(0, 1)
            status = [int(word) for word in self.ask("ST").split()]
            if status[5] == self.seq and status[6] != 1:
                break
        check("%s ends with %d" % (words.split()[0], expected), status[7] == expected, status)
        return status


def point(angle, radius_mm, last):
    normal = (math.cos(angle), math.sin(angle), 0.0)
    numbers = [round(radius_mm * part * 1e4) for part in normal] + [round(32767 * part) for part in normal]
    return " ".join(map(str, numbers + [2000, 3 if last else 1]))


def main():
    controller, radius_mm, count = Controller(sys.argv[1]), float(sys.argv[2]), 105
    identity = controller.ask("ID").split()
    check("identity", identity[0] == "CMM1" and identity[2] == "100", identity)
    os.write(controller.fd, b"#9 ST\n")
    check("a line without a CRC is not answered", not select.select([controller.fd], [], [], 0.1)[0])
    controller.ask("FLY", mark="!")
    for words in ("CLAIM", "HOME", "QUALIFY 10000", "MOVE 400000 0 0 200000"):
        controller.run(words)
    status = controller.run("TOUCH 0 0 0 5000 10000")
    check("touch", abs(status[8] * 1e-4 - radius_mm) < 0.01, status[8])
    points = [point(0.01 * i, radius_mm + 0.1, i + 1 == count) for i in range(count)]
    controller.run("PATH 1")
    for first in list(range(0, count, 10)) + [0]:
        controller.ask("PP 1 %d %s" % (first, " ".join(points[first:first + 10])))
    controller.ask("PP 1 %d %s" % (count + 5, points[0]), mark="!")
    controller.seq += 1
    controller.ask("DO %d %d SCAN 1 10000 10000 10000" % (controller.seq, OWNER))
    taken, last = [], 0
    while True:
        again = controller.samples(last, last + 1)
        flags, newest, batch = controller.samples(last, last + 1)
        check("the same points again", batch[:len(again[2])] == again[2])
        check("gap-free", [sample[0] for sample in batch] == list(range(last + 1, last + 1 + len(batch))))
        taken += batch
        last += len(batch)
        if not batch and flags & 4 and not flags & 2:
            break
    check("the touch comes as a sample", taken[0][3] & 4 == 4)
    check("105 points", len(taken) == 106, len(taken))
    worst = max(abs(math.hypot(x, y) * 1e-4 - radius_mm) for _, (x, y, _), _, _ in taken[1:])
    check("on the bar", worst < 0.01, "%.4f mm" % worst)
    steps = [b[2] - a[2] for a, b in zip(taken[1:], taken[2:])]
    check("not faster than the sample clock", min(steps) >= 980, min(steps))
    controller.run("RELEASE")
    check("nobody owns it", controller.ask("ST").split()[-1] == "0")


main()
