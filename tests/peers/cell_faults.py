#!/usr/bin/python3
# What goes wrong between a PLC and `cmmlive cell`, from docs/cell.md and pymodbus alone.
#   cell_faults.py PORT SCENE
# Scenes: stops (silence, abort, part taken away, starts that cannot be), refusals (bad requests), begin (starts a part and
# leaves), killed (finds the part that was begun as killed), standing (measures a part, does not acknowledge), stands (finds
# that result, acknowledges and goes on), door (opens in the run and closes again), machine gone (during the part that was
# begun, and is there again later). Exit code 1: not as documented; 77: no pymodbus.
import sys
import time

from cell_plc import ABORT, ACKNOWLEDGE, ALIVE, BUSY, DONE, MOVING, PRESENT, READY, RESULTS, START, Plc, fail


def check(name, good, detail=""):
    if not good:
        fail(f"{name} {detail}")
    print("ok   " + name)


def begin(plc, program=1, serial="FAULT"):
    plc.command = PRESENT
    plc.cycle()
    plc.until("ready", lambda: plc.status & READY)
    plc.program, plc.serial, plc.command = program, serial, PRESENT | START
    plc.cycle()
    plc.until("busy", lambda: plc.status & (BUSY | DONE))
    plc.command = PRESENT


def finish(plc, result, reason):
    plc.until("done", lambda: plc.status & DONE, 20)
    check(f"{result}, {reason}", (RESULTS[plc.result], plc.reason) == (result, reason), f"but {RESULTS[plc.result]}, {plc.reason}")
    check("the machine rests", not plc.status & MOVING)
    plc.command = ACKNOWLEDGE
    plc.until("end of done", lambda: not plc.status & DONE)
    plc.command = 0
    plc.cycle()


def measure_a_while(plc, cycles=25):
    for _ in range(cycles):
        plc.cycle()
    check("it measures", plc.status & BUSY and plc.status & MOVING)


def stops(plc):
    begin(plc)
    measure_a_while(plc)
    plc.lose(3.0)  # longer than the watchdog waits
    seen, end = 0, time.monotonic() + 20
    while not seen & DONE and time.monotonic() < end:  # reads alone: the heartbeat stands still
        seen = plc.client.read_holding_registers(104, 1, slave=1).registers[0]
        check("a silent PLC is no live one", not seen & ALIVE)
        time.sleep(0.1)
    check("its run has ended", seen & DONE)
    finish(plc, "error", 202)
    begin(plc)
    measure_a_while(plc)
    plc.command = PRESENT | ABORT
    finish(plc, "error", 200)
    begin(plc)
    measure_a_while(plc)
    plc.command = 0
    finish(plc, "error", 201)
    begin(plc, program=9)
    finish(plc, "error", 100)
    begin(plc, program=3)
    finish(plc, "error", 101)
    begin(plc, serial='a"b')
    finish(plc, "error", 103)
    plc.command = 0
    plc.cycle()
    plc.until("ready", lambda: plc.status & READY)
    plc.program, plc.serial, plc.command = 1, "X", START
    finish(plc, "error", 102)
    # After all that a part is measured as ever.
    plc.part(1, 1)


def refusals(plc):
    plc.cycle()
    client = plc.client

    def code(answer):
        return answer.exception_code if answer.isError() else 0

    check("another function", code(client.read_coils(0, 1, slave=1)) == 1)
    check("registers that are not there", code(client.read_holding_registers(20, 1, slave=1)) == 2)
    check("across two blocks", code(client.read_holding_registers(90, 20, slave=1)) == 2)
    check("a result cannot be written", code(client.write_register(106, 1, slave=1)) == 2)
    check("unknown command bits", code(client.write_register(1, 0x10, slave=1)) == 3)
    check("another unit", code(client.read_holding_registers(100, 1, slave=7)) == 11)
    check("input registers are the same", client.read_input_registers(100, 2, slave=1).registers == [0x4345, 0x4C4C])
    both = client.readwrite_registers(read_address=116, read_count=1, write_address=0, write_registers=[4711], slave=1)
    check("write and read in one", not both.isError() and both.registers == [4711])


if __name__ == "__main__":
    plc = Plc(int(sys.argv[1]))
    scene = sys.argv[2]
    if scene == "stops":
        stops(plc)
    elif scene == "refusals":
        refusals(plc)
    elif scene == "begin":
        begin(plc, serial="KILLED")
        measure_a_while(plc)
    elif scene == "door":
        begin(plc, serial="DOOR")
        plc.until("waiting", lambda: plc.status & 64)
        check("for the door, and will go on", plc.reason == 408 and plc.status & BUSY and plc.status & MOVING)
        plc.until("end of the waiting", lambda: not plc.status & 64)
        finish(plc, "accepted", 1)
    elif scene == "machine gone":
        plc.command = PRESENT
        plc.cycle()
        plc.until("done", lambda: plc.status & DONE, 30)
        check("an error of the link", RESULTS[plc.result] == "error" and 500 <= plc.reason <= 502, str(plc.reason))
        check("nobody has seen it stand", plc.status & MOVING)
        plc.command = ACKNOWLEDGE
        plc.until("end of done", lambda: not plc.status & DONE)
        plc.part(1, 1)
    elif scene == "killed":
        plc.command = PRESENT | START  # as it was when the other side went
        for _ in range(5):
            plc.cycle()
        check("the part that was begun", plc.echo == "KILLED" and plc.run == 1 and plc.status & DONE)
        finish(plc, "error", 205)
        plc.part(1, 1)
        check("the next number", plc.run == 2)
    elif scene == "standing":
        begin(plc, serial="STANDS")
        plc.until("done", lambda: plc.status & DONE)
        check("accepted", RESULTS[plc.result] == "accepted")
    elif scene == "stands":
        plc.command = PRESENT
        plc.cycle()
        check("the same part", plc.echo == "STANDS" and plc.run == 3 and not plc.status & READY)
        finish(plc, "accepted", 1)
        time.sleep(0.2)
        plc.cycle()
        check("nothing is measured twice", plc.run == 3 and not plc.status & (BUSY | DONE))
    else:
        fail("no such scene")
