#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A digital readout on a pseudo-terminal, with a person who measures the sections of an analytic blade: written from
docs/dro.md and the formulas of docs/part-file.md alone, with Python's own library.

    dro_printer.py --go FILE --truth FOLDER [--style letters|tagged|counts] [--end crlf|cr|lf] [--noise] [--z Z...]
                   [--points N]

Prints the terminal's name. Once FILE exists it sends the ball centres of each section, counter-clockwise and past the
start, in pieces as a slow line does; in style counts one point for each request "P" and CR. FOLDER receives the true
contour of each section. At the end it prints how many lines were no points, and stays until it is killed.
"""
import argparse
import math
import os
import pty
import select
import time
import tty

CHORD, THICKNESS, CAMBER, STAGGER, R_LE, R_TE = 60.0, 6.0, math.radians(28.0), math.radians(24.0), 0.4, 0.25
BALL = 1.0


def section(offset, step, arc_step):
    """The envelope of circles on the camber line, moved outwards by `offset`; starts in the middle of the suction side."""
    k = CHORD - R_LE - R_TE
    radius = k / (2.0 * math.sin(CAMBER / 2.0))
    length = radius * CAMBER
    h = THICKNESS / 2.0 - (R_LE + R_TE) / 2.0

    def frame(t):
        a = (t - 0.5) * CAMBER
        return ((radius * math.sin(a), radius * (math.cos(a) - math.cos(CAMBER / 2.0))),
                (math.cos(a), -math.sin(a)), (math.sin(a), math.cos(a)))

    def direction(t, side):
        slope = R_TE - R_LE + h * (2.0 * (1.0 - 2.0 * t) + 27.0 / 8.0 * ((1.0 - t) ** 2 - 2.0 * t * (1.0 - t)))
        q = slope / length
        s = side * math.sqrt(1.0 - q * q)
        _, e, n = frame(t)
        return -q * e[0] + s * n[0], -q * e[1] + s * n[1]

    def side_point(t, side):
        f = 2.0 * t * (1.0 - t) + 27.0 / 8.0 * t * (1.0 - t) ** 2
        rho = R_LE * (1.0 - t) + R_TE * t + h * f
        m, u = frame(t)[0], direction(t, side)
        return m[0] + (rho + offset) * u[0], m[1] + (rho + offset) * u[1]

    def arc(t, r, begin, end):
        m = frame(t)[0]
        a = math.atan2(*reversed(direction(t, begin)))
        turn = (math.atan2(*reversed(direction(t, end))) - a) % (2.0 * math.pi)
        count = max(2, round(turn / arc_step))
        return [(m[0] + (r + offset) * math.cos(a + turn * i / count), m[1] + (r + offset) * math.sin(a + turn * i / count))
                for i in range(1, count)]

    count = round(length / step)
    suction = [side_point(1.0 - i / count, 1.0) for i in range(count + 1)]
    pressure = [side_point(i / count, -1.0) for i in range(count + 1)]
    points = suction + arc(0.0, R_LE, 1.0, -1.0) + pressure + arc(1.0, R_TE, -1.0, 1.0)
    points = points[count // 2:] + points[:count // 2]
    c, s = math.cos(STAGGER), math.sin(STAGGER)
    return [(c * x - s * y, s * x + c * y) for x, y in points]


class Readout:
    def __init__(self, options):
        self.options = options
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        print(os.ttyname(slave), flush=True)
        self.slave = slave  # held, so that programs may come and go
        self.end = {"crlf": b"\r\n", "cr": b"\r", "lf": b"\n"}[options.end]
        self.garbled = 0
        self.number = 0

    def line(self, x, y, z):
        self.number += 1
        if self.options.style == "letters":
            return b"X%.4f,Y%.4f,Z%.4f" % (x, y, z)
        if self.options.style == "tagged":  # inches, a point number, and the pedal's mark
            return b"P %5d  %+.6f  %+.6f  %+.6f" % (self.number, x / 25.4, y / 25.4, z / 25.4)
        return b"X%d,Y%d,Z%d,W%d" % (round(x * 1e4), round(y * 1e4), round(z * 1e4), self.number % 360)

    def write(self, data):
        while data:
            piece = 1 + (self.number * 7) % 11
            os.write(self.master, data[:piece])
            data = data[piece:]

    def spoil(self):
        """Lines that are no points: noise, half a line, a line with a byte too many, a live value nobody asked for."""
        for bad in (b"\xb1\x9f\x03", b"X12.3", b"X1.0000,Y2.00\xff00,Z3.0000", b"X1.0000,,Y2.0000,Z3.0000"):
            self.write(bad + self.end)
            self.garbled += 1
        if self.options.style == "tagged":
            self.write(b"L     0  +0.100000  +0.100000  +0.100000" + self.end)

    def requested(self):
        waiting = getattr(self, "waiting", b"")
        while b"P\r" not in waiting:
            if not select.select([self.master], [], [], 30.0)[0]:
                raise SystemExit("no request came")
            waiting += os.read(self.master, 256)
        self.waiting = waiting[waiting.index(b"P\r") + 2:]

    def measure(self, points, z):
        for k, (x, y) in enumerate(points):
            if self.options.noise and k % 40 == 0:
                self.spoil()
            if self.options.style == "counts":
                self.requested()
            self.write(self.line(x, y, z) + self.end)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--go", required=True)
    parser.add_argument("--truth", required=True)
    parser.add_argument("--style", default="letters")
    parser.add_argument("--end", default="crlf")
    parser.add_argument("--noise", action="store_true")
    parser.add_argument("--z", type=float, nargs="+", default=[10.0])
    parser.add_argument("--points", type=int, default=0)
    options = parser.parse_args()
    with open(os.path.join(options.truth, "truth.csv"), "w") as truth:
        truth.writelines("%.7f,%.7f\n" % point for point in section(0.0, 0.02, math.radians(0.5)))
    readout = Readout(options)
    while not os.path.exists(options.go):
        time.sleep(0.01)
    lap = section(BALL, 0.5, math.radians(8.0))
    for z in options.z:
        # The first point again, once more a little further: only then has the start been passed.
        points = lap + lap[:1] if options.points == 0 else lap[:options.points]
        readout.measure(points, z)
    print(len(lap), readout.garbled, flush=True)
    while True:
        time.sleep(60)


main()
