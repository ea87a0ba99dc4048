#!/usr/bin/python3
# A PLC before `cmmlive cell`, from docs/cell.md and pymodbus alone: nothing of ours.
#   cell_plc.py PORT PARTS [--unit N]
# Part after part through the handshake. The connection is lost in the middle of each second part, and in the middle of a
# result that was read but not acknowledged. Exit code 1: something was lost, doubled or out of order; 77: no pymodbus.
import sys
import time

try:
    from pymodbus.client import ModbusTcpClient
except ImportError:
    print("python3-pymodbus is not installed")
    sys.exit(77)

PRESENT, START, ABORT, ACKNOWLEDGE = 1, 2, 4, 8
READY, BUSY, DONE, OUT, ALIVE, MOVING = 1, 2, 4, 8, 16, 32
RESULTS = ["none", "accepted", "rejected", "undecided", "error", "measured"]
CYCLE_S = 0.02


def fail(text):
    print("FAIL " + text)
    sys.exit(1)


def words(text):
    data = text.encode("ascii").ljust(32, b"\0")
    return [data[i] << 8 | data[i + 1] for i in range(0, 32, 2)]


class Plc:
    def __init__(self, port):
        self.port = port
        self.beat = 0
        self.command = 0
        self.program = 0
        self.serial = ""
        self.losses = 0
        self.lost_in_the_middle = 0
        self.client = None
        self.connect()

    def connect(self):
        self.client = ModbusTcpClient("127.0.0.1", port=self.port, timeout=5)
        if not self.client.connect():
            fail("no connection")

    def lose(self, seconds):
        self.client.close()
        self.losses += 1
        time.sleep(seconds)
        self.connect()

    def cycle(self):
        """Writes the PLC's block, reads the cell's."""
        self.beat = (self.beat + 1) & 0xFFFF
        block = [self.beat, self.command, self.program, 0] + words(self.serial)
        if self.client.write_registers(0, block, slave=1).isError():
            fail("a write was refused")
        answer = self.client.read_holding_registers(100, 33, slave=1)
        if answer.isError():
            fail("a read was refused")
        r = answer.registers
        self.status, self.result, self.reason = r[4], r[6], r[7]
        self.decision, self.run = r[8], r[10] << 16 | r[11]
        self.echo = b"".join(w.to_bytes(2, "big") for w in r[17:33]).rstrip(b"\0").decode()
        self.echo_program = r[12]
        if r[0:3] != [0x4345, 0x4C4C, 1]:
            fail("identity")
        if r[16] != self.beat:
            fail("the heartbeat that was written is not the one that is echoed")
        time.sleep(CYCLE_S)

    def until(self, what, test, seconds=60):
        end = time.monotonic() + seconds
        while not test():
            if time.monotonic() > end:
                fail(f"no {what} within {seconds} s (status {self.status:#x})")
            self.cycle()

    def part(self, number, program, lose_in_the_middle=False, lose_before_acknowledging=False):
        before = getattr(self, "run", 0)
        self.command = PRESENT
        self.cycle()
        self.until("ready", lambda: self.status & READY)
        if self.status & (BUSY | DONE) or self.result:
            fail("ready with a result")
        self.program, self.serial, self.command = program, f"PY-{number:04d}", PRESENT | START
        self.cycle()
        self.until("busy", lambda: self.status & (BUSY | DONE))
        if self.echo != self.serial or self.echo_program != program or self.run != before + 1:
            fail(f"taken on as {self.echo}, program {self.echo_program}, run {self.run} after {before}")
        self.command = PRESENT
        decided_early = False
        cycles = 0
        while not self.status & DONE:
            self.cycle()
            cycles += 1
            decided_early = decided_early or bool(self.status & BUSY and self.decision == 2)
            if cycles == 20 and lose_in_the_middle:
                if not self.status & BUSY:
                    fail("over before the connection could be lost in the middle")
                self.lose(0.7)
                self.lost_in_the_middle += 1
                self.cycle()
                if self.echo != self.serial or self.run != before + 1 or not self.status & (BUSY | DONE):
                    fail("after the loss it was another part")
            if cycles > 6000:
                fail("never done")
        if lose_before_acknowledging:
            seen = (self.run, self.result, self.reason)
            self.lose(3.0)
            self.cycle()
            if not self.status & DONE or (self.run, self.result, self.reason) != seen:
                fail("the result did not wait")
        told = (self.run, self.echo, RESULTS[self.result], self.reason, decided_early)
        if self.status & MOVING:
            fail("done, but it may be moving")
        self.command = PRESENT | ACKNOWLEDGE
        self.until("end of done", lambda: not self.status & DONE)
        if self.status & READY:
            fail("ready while the acknowledgement stands")
        self.command = 0
        self.cycle()
        print(f"ok   part {number}: run {told[0]}, {told[1]}, {told[2]}, reason {told[3]}" + (", told early" if decided_early else ""))
        return told


if __name__ == "__main__":
    plc = Plc(int(sys.argv[1]))
    plc.cycle()
    first = plc.run
    told = []
    for k in range(int(sys.argv[2])):
        bad = k % 3 == 2
        part = plc.part(k, 2 if bad else 1, lose_in_the_middle=k % 2 == 1, lose_before_acknowledging=k == 4)
        told.append(part)
        if part[2] != ("rejected" if bad else "accepted"):
            fail(f"{part[2]} instead")
    if [part[0] for part in told] != list(range(first + 1, first + 1 + len(told))):
        fail("the runs are not numbered one by one")
    if len(told) > 1 and not plc.lost_in_the_middle:
        fail("no connection was lost in the middle of a part: they are too short for this test")
    print(f"ok   {len(told)} parts, {plc.losses} lost connections")
