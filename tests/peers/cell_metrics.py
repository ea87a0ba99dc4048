#!/usr/bin/python3
# What a cell shows of three measured parts (the third rejected), read by Prometheus' own Python library.
#   cell_metrics.py http://127.0.0.1:PORT
# Exit code 1: something is missing; 77: python3-prometheus-client is not installed.
import json
import sys
import urllib.request

try:
    from prometheus_client.parser import text_string_to_metric_families
except ImportError:
    print("python3-prometheus-client is not installed")
    sys.exit(77)

base = sys.argv[1]


def get(path):
    with urllib.request.urlopen(base + path, timeout=10) as answer:
        return answer.headers["Content-Type"], answer.read().decode()


def check(name, good, detail=""):
    print(("ok   " if good else "FAIL ") + name, detail)
    if not good:
        sys.exit(1)


kind, text = get("/metrics")
check("content type", kind.startswith("text/plain; version=0.0.4"), kind)
families = {family.name: family for family in text_string_to_metric_families(text)}
check("every family has a type and a help text", all(f.documentation and f.type != "unknown" for f in families.values()), str(len(families)))


def value(family, **labels):
    found = [s.value for s in families[family].samples if all(s.labels.get(k) == v for k, v in labels.items())]
    return found[0] if found else 0


check("runs", value("cmmlive_runs", verdict="accept") == 2 and value("cmmlive_runs_started") == 3)
check("results", value("cmmlive_cell_results", result="accepted") == 2 and value("cmmlive_cell_results", result="rejected") == 1)
check("rejected while measuring", value("cmmlive_rejections_while_measuring") >= 1)
check("samples", value("cmmlive_samples") > 100)
check("the link to the machine", value("cmmlive_link_exchanges") > 10)
check("the PLC", value("cmmlive_plc_requests") > 10 and value("cmmlive_plc_exceptions") == 0)
check("one state", sum(s.value for s in families["cmmlive_cell_state"].samples) == 1)
for name in ("cmmlive_cell_rejection_latency_seconds", "cmmlive_section_latency_seconds", "cmmlive_link_round_trip_seconds"):
    buckets = [s.value for s in families[name].samples if s.name.endswith("_bucket")]
    count = [s.value for s in families[name].samples if s.name.endswith("_count")][0]
    check(name, buckets == sorted(buckets) and buckets[-1] == count > 0, str(count))
_, text = get("/api/cell")
cell = json.loads(text)
check("state", cell["run"] == 3 and cell["result"] == "rejected" and cell["serial"] == "PY-0002", text)
check("runs of the page", len(json.loads(get("/api/runs")[1])["runs"]) == 3)
try:
    urllib.request.urlopen(urllib.request.Request(base + "/api/stop", data=b"{}", headers={"Content-Type": "application/json"}), timeout=10)
    check("nothing stops without the token", False)
except urllib.error.HTTPError as refused:
    check("nothing stops without the token", refused.code == 401)
