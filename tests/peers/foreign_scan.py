#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A measuring session by a foreign Modbus client (pymodbus 3), written from docs/protocol-modbus.md alone.

    foreign_scan.py PORT|/dev/... RADIUS_MM

Scans an arc about a round bar that stands along z at the origin; RADIUS_MM is that of the ball centre in contact.
Prints one line for each check; the exit code is 1 when one failed, 77 when pymodbus is not installed.
"""
import inspect
import math
import struct
import sys

from registers import crc16, unsigned, words

try:
    from pymodbus.client import ModbusSerialClient, ModbusTcpClient
except ImportError:
    print("pymodbus is not installed")
    sys.exit(77)
try:
    from pymodbus.framer import FramerType
    RTU = FramerType.RTU
except ImportError:  # before 3.7
    from pymodbus.transaction import ModbusRtuFramer as RTU

# pymodbus 3.0 says write_registers, 3.8 says values.
VALUES = "values" if "values" in inspect.signature(ModbusTcpClient.readwrite_registers).parameters else "write_registers"
UNIT = 1
OWNER = 7
IDENTITY, STATUS, COMMAND, PATH, EXCHANGE, FIFO = 0, 64, 128, 256, 384, 400
CLAIM, RELEASE, HOME, QUALIFY, MOVE, TOUCH, SCAN, PATH_BEGIN = 1, 2, 3, 4, 5, 6, 7, 10


def signed32(registers):
    value = unsigned(registers)
    return value - (1 << 32) if value & 0x80000000 else value


def check(name, good, detail=""):
    print("ok   " if good else "FAIL ", name, detail)
    if not good:
        sys.exit(1)


class Machine:
    def __init__(self, port):
        self.serial = not port.isdigit()
        self.client = (ModbusSerialClient(port=port, framer=RTU, baudrate=115200, timeout=2) if self.serial
                       else ModbusTcpClient("127.0.0.1", port=int(port)))
        check("connect", self.client.connect())
        self.seq = self.status()[4]
        self.watchdog = 0

    def read(self, address, count):
        reply = self.client.read_holding_registers(address, count=count, slave=UNIT)
        check("FC3 at %d" % address, not reply.isError(), reply) if reply.isError() else None
        return reply.registers

    def status(self):
        block = self.read(STATUS, 37)
        if crc16(block[:36]) != block[36]:
            check("status CRC", False, block)
        return block

    def exchange(self, acknowledge=0, first=0):
        self.watchdog = (self.watchdog + 1) & 0xFFFF
        values = [self.watchdog] + words(acknowledge) + words(first)
        if self.serial:  # pymodbus 3.0 sends FC 23 to unit 0 there, a broadcast
            reply = self.client.write_registers(EXCHANGE, values, slave=UNIT)
            check("FC16 of the exchange", not reply.isError(), reply) if reply.isError() else None
            block = self.read(FIFO, 125)
        else:
            reply = self.client.readwrite_registers(
                read_address=FIFO, read_count=125, write_address=EXCHANGE, slave=UNIT, **{VALUES: values})
            check("FC23", not reply.isError(), reply) if reply.isError() else None
            block = reply.registers
        used = block[:13 + 8 * block[7]]
        if crc16(used[:12] + used[13:]) != used[12]:
            check("FIFO CRC", False, block)
        return block

    def start(self, opcode, *args):
        self.seq = self.seq % 65535 + 1
        block = [self.seq, opcode] + words(OWNER)
        for i in range(8):
            block += words(args[i] if i < len(args) else 0)
        reply = self.client.write_registers(COMMAND, block + [crc16(block)], slave=UNIT)
        check("command %d written" % opcode, not reply.isError(), reply)

    def finish(self, opcode, expected=0):
        while True:
            self.exchange()
            status = self.status()
            if status[4] == self.seq and status[5] != 1:
                break
        check("command %d ends with %d" % (opcode, expected), status[6] == expected, status[5:7])
        return status

    def run(self, opcode, *args, expected=0):
        self.start(opcode, *args)
        return self.finish(opcode, expected)

    def send_window(self, path, first, points):
        header = [path] + words(first) + [len(points)]
        body = [register for point in points for register in point]
        block = header + [crc16(header + [0] + body), 0] + body
        return self.client.write_registers(PATH, block, slave=UNIT)


def path_point(angle, radius_mm, last):
    normal = (math.cos(angle), math.sin(angle), 0.0)
    point = []
    for axis in range(3):
        point += words(round(radius_mm * normal[axis] * 1e4))
    point += [round(32767 * component) & 0xFFFF for component in normal]
    return point + [2000, 3 if last else 1]  # 20 mm/s


def read_identity(machine):
    block = machine.read(IDENTITY, 46)
    check("identity CRC", crc16(block[:45]) == block[45])
    check("magic", block[0:2] == [0x434D, 0x4D31], block[0:2])
    check("map version", block[2] == 1)
    model = b"".join(struct.pack(">H", r) for r in block[4:12]).rstrip(b"\0").decode("ascii")
    check("model", len(model) > 0, model)
    check("counts of 100 nm", block[20] == 100)
    return block


def scan(machine, radius_mm, count):
    points = [path_point(0.01 * i, radius_mm + 0.1, i + 1 == count) for i in range(count)]
    machine.run(PATH_BEGIN, 1)
    for first in range(0, count, 10):
        check("window at %d" % first, not machine.send_window(1, first, points[first:first + 10]).isError())
    check("a repeated window", not machine.send_window(1, 0, points[:10]).isError())
    check("a window too far is refused", machine.send_window(1, count + 5, points[:1]).isError())
    machine.start(SCAN, 1, 10000, 10000, 10000)
    taken, acknowledge = [], machine.status()
    acknowledge = unsigned(acknowledge[22:24])
    expected = acknowledge + 1
    while True:
        block = machine.exchange(acknowledge)
        again = machine.exchange(acknowledge)
        n = block[7]
        check("the same points again", again[13:13 + 8 * n] == block[13:13 + 8 * n]) if n else None
        if n:
            check("sequence %d" % expected, unsigned(block[3:5]) == expected)
            time_us = unsigned(block[9:12])
            for k in range(n):
                point = block[13 + 8 * k:21 + 8 * k]
                time_us += 10 * point[6]
                taken.append((time_us, [signed32(point[i:i + 2]) * 1e-4 for i in (0, 2, 4)], point[7]))
            expected += n
            acknowledge = expected - 1
        elif block[8] & 4 and not block[8] & 2:
            return taken


def main():
    machine = Machine(sys.argv[1])
    radius_mm = float(sys.argv[2])
    read_identity(machine)
    machine.run(CLAIM)
    machine.run(HOME)
    machine.run(QUALIFY, 10000)
    machine.run(MOVE, 400000, 0, 0, 200000)
    status = machine.run(TOUCH, 0, 0, 0, 5000, 10000)
    check("touch", abs(signed32(status[7:9]) * 1e-4 - radius_mm) < 0.01, signed32(status[7:9]))
    taken = scan(machine, radius_mm, 105)
    touch, points = taken[0], taken[1:]
    check("the touch comes as a sample", touch[2] & 4 == 4)
    check("105 points", len(points) == 105, len(points))
    check("all in contact", all(quality & 1 == 0 for _, _, quality in points))
    worst = max(abs(math.hypot(x, y) - radius_mm) for _, (x, y, _), _ in points)
    check("on the bar", worst < 0.01, "%.4f mm" % worst)
    steps = [b[0] - a[0] for a, b in zip(points, points[1:])]
    check("not faster than the sample clock", min(steps) >= 980, min(steps))
    machine.finish(SCAN)
    machine.run(SCAN, 1, 10000, 10000, 10000, expected=8)
    check("an address outside is an exception", machine.client.read_holding_registers(60000, count=1, slave=UNIT).isError())
    machine.run(RELEASE)
    check("nobody owns it", unsigned(machine.status()[34:36]) == 0)


main()
