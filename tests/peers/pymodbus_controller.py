#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A measuring controller on a foreign Modbus server (pymodbus 3), as far as docs/protocol-modbus.md asks for a scan.

    pymodbus_controller.py PORT        Modbus TCP on 127.0.0.1:PORT
    pymodbus_controller.py /dev/...    Modbus RTU on a serial port at 115200 baud

Prints "ready" when it is about to listen. Motions end with the next exchange; a scan gives five points an exchange.
The exit code is 77 when pymodbus is not installed.
"""
import struct
import sys

from registers import crc16, unsigned, words

try:
    from pymodbus.datastore import ModbusServerContext, ModbusSlaveContext
    from pymodbus.server import StartSerialServer, StartTcpServer
except ImportError:
    print("pymodbus is not installed")
    sys.exit(77)
try:
    from pymodbus.framer import FramerType
    RTU = FramerType.RTU
except ImportError:  # before 3.7
    from pymodbus.transaction import ModbusRtuFramer as RTU

IDENTITY, STATUS, COMMAND, STOP, PATH, EXCHANGE, FIFO = 0, 64, 128, 200, 256, 384, 400
IDLE, SCANNING, STARVED, STOPPED = 0, 4, 5, 6
RUNNING, DONE, FAILED = 1, 2, 3


def text(characters):
    padded = characters.encode().ljust(16, b"\0")
    return list(struct.unpack(">8H", padded))


class Controller(ModbusSlaveContext):
    """The registers, the same for every function code; what is written to them happens at once."""

    def __init__(self):
        super().__init__()
        self.registers = [0] * 600
        self.state, self.seq, self.fate, self.result = IDLE, 0, 0, 0
        self.path_id, self.path, self.passed = 0, [], 0
        self.samples, self.acked, self.owner, self.running, self.heartbeat = [], 0, 0, 0, 0
        block = [0x434D, 0x4D31, 1, 0x0300] + text("pymodbus") + text("PY-1") + [100, 1000, 4096, 200, 10, 500, 15, 0]
        block += 3 * words(-5000000) + 3 * words(5000000) + words(400000) + words(1500000) + [9]
        self.keep(IDENTITY, block + [crc16(block)])
        self.publish()

    def keep(self, at, registers):
        self.registers[at:at + len(registers)] = registers

    def validate(self, _function, address, count=1):
        return address + count <= len(self.registers)

    def getValues(self, _function, address, count=1):
        return self.registers[address:address + count]

    def setValues(self, _function, address, values):
        self.keep(address, list(values))
        if address == COMMAND:
            self.command(list(values))
        elif address == STOP:
            self.running and self.end(FAILED, 13)
            self.state = STOPPED
        elif address == PATH:
            self.take_window(list(values))
        elif address == EXCHANGE:
            self.step()
            self.fill_fifo(unsigned(values[1:3]), unsigned(values[3:5]))
        self.publish()

    def command(self, block):
        assert crc16(block[:20]) == block[20], "command CRC"
        seq, opcode, owner, args = block[0], block[1], unsigned(block[2:4]), [unsigned(block[4 + 2 * k:6 + 2 * k]) for k in range(8)]
        if seq == self.seq:
            return
        self.seq, self.fate, self.result = seq, DONE, 0
        if opcode == 1:
            self.owner = owner
        elif opcode == 2:
            self.owner = 0
        elif opcode == 9:
            self.state = IDLE
        elif opcode == 10:
            self.path_id, self.path, self.passed = args[0], [], 0
        elif owner != self.owner:
            self.fate, self.result = FAILED, 7
        else:
            self.running, self.fate, self.state = opcode, RUNNING, SCANNING if opcode == 7 else 2

    def end(self, fate, result):
        self.running, self.fate, self.result, self.state = 0, fate, result, IDLE

    def take_window(self, block):
        path_id, first, count = block[0], unsigned(block[1:3]), block[3]
        assert crc16(block[:4] + block[5:]) == block[4], "path CRC"
        assert path_id == self.path_id and first <= len(self.path) and len(block) == 6 + 11 * count, "path window"
        points = [block[6 + 11 * k:17 + 11 * k] for k in range(count)]
        self.path[first:] = points

    def step(self):
        self.heartbeat = (self.heartbeat + 1) & 0xFFFF
        if self.running and self.running != 7:
            self.end(DONE, 0)
        for _ in range(5 if self.running == 7 else 0):
            if self.passed == len(self.path):
                self.state = STARVED
                break
            self.state = SCANNING
            point = self.path[self.passed]
            self.passed += 1
            if point[10] & 1:
                self.samples.append(point[:6] + [self.path_id])
            if point[10] & 2:
                self.end(DONE, 0)
                break

    def fill_fifo(self, ack, first):
        self.acked = max(self.acked, ack)
        first = max(first, self.acked + 1)
        batch = self.samples[first - 1:first + 13]
        newest = len(self.samples)
        flags = (2 if first + len(batch) <= newest else 0) | (0 if self.running == 7 else 4)
        path_id = batch[0][6] if batch else self.path_id
        head = [self.state, self.heartbeat, path_id] + words(first) + words(newest) + [len(batch), flags] + words(first * 1000, 3)
        points = []
        for index, sample in enumerate(batch):
            points += sample[:6] + [100 if index else 0, 0]
        block = head + [crc16(head + points)] + points
        self.keep(FIFO, block + [0] * (125 - len(block)))

    def publish(self):
        flags = 3 | (8 if self.running else 0) | (16 if self.owner else 0)
        block = [self.state, self.heartbeat, flags, 0, self.seq, self.fate, self.result] + [0] * 8 + [self.path_id]
        block += words(self.passed) + words(len(self.path)) + words(len(self.samples)) + words(self.acked) + [0] * 6
        block += [len(self.samples) - self.acked] + [0] * 3 + words(self.owner)
        self.keep(STATUS, block + [crc16(block)])


if __name__ == "__main__":
    context = ModbusServerContext(slaves=Controller(), single=True)
    print("ready", flush=True)
    if sys.argv[1].isdigit():
        StartTcpServer(context=context, address=("127.0.0.1", int(sys.argv[1])))
    else:
        StartSerialServer(context=context, framer=RTU, port=sys.argv[1], baudrate=115200, timeout=0.005)
