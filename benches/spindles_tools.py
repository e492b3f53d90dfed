#!/usr/bin/env python3
"""A design and a tuned PID for each of several spindles with each of several tools: figures and times, one row each.

usage: benches/spindles_tools.py [--muspin PROGRAM] [--work DIR] [--tools A,B] [SPINDLE ...]

Default: the reference spindle as updated, five others of tests/data/spindles, and the ten tools of spindles/tools.
The paper's tool is designed from nothing, the others start from its design (`muspin batch --from`). Writes
results/bench/spindles_tools.csv after every row. A folder that an earlier call finished in DIR is not computed again, and
its times are those of reading it; without --work every design is computed in a temporary folder.
"""

import argparse
import csv
import datetime
import json
import os
import resource
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SPINDLES = ["reference-updated", "s01-short-fast", "s04-noncollocated", "s06-strong-ks", "s09-four-modes", "s12-big-discs"]
FIRST = "paper-tool"
TABLE = ROOT / "results" / "bench" / "spindles_tools.csv"
COLUMNS = [
    "spindle",
    "tool",
    "start",
    "meets_specification",
    "order",
    "largest_mu",
    "minimum_stiffness_at_rest_n_per_m",
    "minimum_stiffness_at_top_speed_n_per_m",
    "worst_stiffness_n_per_m",
    "iso_zone",
    "pid_minimum_stiffness_at_rest_n_per_m",
    "pid_minimum_stiffness_at_top_speed_n_per_m",
    "pid_iso_zone",
    "over_pid_at_10_hz",
    "over_pid_at_minimum",
    "over_pid_at_top_speed_frequency",
    "proven_stable",
    "wall_s",
    "cpu_s",
    "date",
    "commit",
]


def called(command):
    """Exit code, wall time and processor time of a command."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    code = subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode
    wall = time.monotonic() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return code, wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def least(summary):
    """Smallest stiffness that no rotor within the uncertainty falls below, over the speeds, N/m."""
    found = [
        axis["minimum"]["not_below_n_per_m"]
        for speed in (summary.get("worst_case") or {}).get("mu", [])
        for axis in (speed.get("stiffness") or {}).values()
        if isinstance(axis, dict) and axis.get("minimum")
    ]
    return min(found) if found else None


def over_pid(stiffness, key):
    """Stiffness of the delivered controller in that of the tuned PID, the smaller of rest and top speed."""
    mu, pid = stiffness["mu"], stiffness.get("pid")
    ends = [(mu, pid), (mu.get("at_top_speed"), (pid or {}).get("at_top_speed"))]
    ratios = [own[key] / other[key] for own, other in ends if own and other and own.get(key) and other.get(key)]
    return round(min(ratios), 3) if ratios else None


def figures(folder):
    """What the summary of a tool says of the delivered controller."""
    summary = json.loads((folder / "summary.json").read_text())
    design, stiffness = summary["design"], summary["stiffness"]["mu"]
    top = stiffness.get("at_top_speed") or {}
    pid = summary["stiffness"].get("pid") or {}
    return {
        "order": design["controller_order"],
        "largest_mu": design["largest_mu"],
        "minimum_stiffness_at_rest_n_per_m": stiffness["minimum_n_per_m"],
        "minimum_stiffness_at_top_speed_n_per_m": top.get("minimum_n_per_m"),
        "worst_stiffness_n_per_m": least(summary),
        "iso_zone": summary["sensitivity"]["mu"]["zone"],
        "pid_minimum_stiffness_at_rest_n_per_m": pid.get("minimum_n_per_m"),
        "pid_minimum_stiffness_at_top_speed_n_per_m": (pid.get("at_top_speed") or {}).get("minimum_n_per_m"),
        "pid_iso_zone": (summary["sensitivity"].get("pid") or {}).get("zone"),
        "over_pid_at_10_hz": over_pid(summary["stiffness"], "at_10_hz_n_per_m"),
        "over_pid_at_minimum": over_pid(summary["stiffness"], "minimum_n_per_m"),
        "over_pid_at_top_speed_frequency": over_pid(summary["stiffness"], "at_max_speed_n_per_m"),
        "proven_stable": design["speed_proof"]["complete"],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--muspin", default=str(ROOT / "target" / "release" / "muspin"))
    parser.add_argument("--work")
    parser.add_argument("--tools")
    parser.add_argument("spindles", nargs="*", default=SPINDLES)
    arguments = parser.parse_args()
    work = Path(arguments.work or tempfile.mkdtemp(prefix="muspin-spindles-"))
    tools = arguments.tools.split(",") if arguments.tools else sorted((p.stem for p in (ROOT / "spindles" / "tools").glob("*.yaml")), key=lambda t: (t != FIRST, t))
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    rows = []
    for spindle in arguments.spindles:
        path = ROOT / "tests" / "data" / "spindles" / f"{spindle}.yaml"
        start = None
        for tool in tools:
            out = work / spindle
            command = [arguments.muspin, "batch", "--no-table", "--spindle", str(path), "--tools", tool, "--out", str(out)]
            if start:
                command += ["--from", str(out / start)]
            code, wall, cpu = called(command)
            row = {
                "spindle": spindle,
                "tool": tool,
                "start": start or "",
                "meets_specification": {0: "true", 1: "false"}.get(code, f"exit {code}"),
                "wall_s": round(wall, 1),
                "cpu_s": round(cpu, 1),
                "date": datetime.date.today().isoformat(),
                "commit": commit,
            }
            folder = out / tool
            if (folder / "summary.json").is_file():
                row.update(figures(folder))
                start = start or tool
            rows.append(row)
            TABLE.parent.mkdir(parents=True, exist_ok=True)
            written = TABLE.with_suffix(".csv.part")
            with written.open("w", newline="") as file:
                table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                table.writeheader()
                table.writerows({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in r.items()} for r in rows)
            os.replace(written, TABLE)
            print(spindle, tool, row["meets_specification"], f"{wall:.1f} s", flush=True)


if __name__ == "__main__":
    main()
