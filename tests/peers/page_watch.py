#!/usr/bin/python3
# Watches a running job as another program would: the Debian package websockets, and nothing of ours.
#   page_watch.py PORT SECTIONS
# Exit code 1: something is missing or out of order; 77: websockets is not installed.
import asyncio
import json
import sys

try:
    import websockets
except ImportError:
    print("python3-websockets is not installed")
    sys.exit(77)

port, sections = int(sys.argv[1]), int(sys.argv[2])


def check(name, good, detail=""):
    print(("ok   " if good else "FAIL ") + name, detail)
    if not good:
        sys.exit(1)


async def watch(start):
    """Events from a sequence on, up to RunStopped."""
    seen = []
    async with websockets.connect(f"ws://127.0.0.1:{port}/api/events?from={start}") as socket:
        while not seen or seen[-1]["event"] != "RunStopped":
            message = await asyncio.wait_for(socket.recv(), 60)
            seen += [json.loads(line) for line in message.split("\n")]
    return seen


async def main():
    # Two at once, and one that comes late and asks from the middle.
    first, second = await asyncio.gather(watch(1), watch(1))
    check("both heard the same", first == second, f"{len(first)} events")
    check("no gap", [event["seq"] for event in first] == list(range(1, len(first) + 1)))
    finals = [event["section"] for event in first if event["event"] == "SectionFinal"]
    check("every section once", sorted(finals) == list(range(sections)), str(finals))
    samples = sum(event["count"] for event in first if event["event"] == "SampleBatch")
    check("samples", samples > 0 and samples == sum(e["points"] for e in first if e["event"] == "SectionFinal"), str(samples))
    late = await watch(100)
    check("a late one from where he asks", late == first[99:])
    try:
        async with websockets.connect(f"ws://127.0.0.1:{port}/api/events", origin="http://evil.example"):
            check("another origin is refused", False)
    except websockets.InvalidStatusCode as refused:
        check("another origin is refused", refused.status_code == 403)


asyncio.run(main())
