# SPDX-License-Identifier: Apache-2.0
"""Registers as docs/protocol-modbus.md has them: checksum, and numbers over several registers, high word first."""
import struct


def crc16(registers):
    crc = 0xFFFF
    for byte in b"".join(struct.pack(">H", r) for r in registers):
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ 0xA001 if crc & 1 else crc >> 1
    return crc


def words(value, count=2):
    value &= (1 << (16 * count)) - 1
    return [(value >> (16 * i)) & 0xFFFF for i in reversed(range(count))]


def unsigned(registers):
    value = 0
    for register in registers:
        value = value << 16 | register
    return value
