#!/usr/bin/env python3
"""Designs of the rotors of tests/data/rotors, whose gyroscopics count: what µ comes to, one row each.

usage: benches/rotors.py [--muspin PROGRAM] [ROTOR ...]

Writes results/bench/rotors.csv, in which rotors that are not named keep their rows. µ is of the specification as written with
the whole sampled machine, its largest value at 25 and more speeds from rest to 1.2 times the top speed. `mu_before_growth` is that
of the best controller before its order grows, empty where it does not; `least_mu` is a bound below which no controller comes, where
µ exceeds one; `proven_to_rpm` is 1.2 times the top speed at most.
"""

import argparse
import csv
import json
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ROTORS = ROOT / "tests" / "data" / "rotors"
TABLE = ROOT / "results" / "bench" / "rotors.csv"
COLUMNS = ["rotor", "mu_before_growth", "largest_mu", "least_mu", "order", "minimum_stiffness_at_rest_n_per_m", "iso_zone",
           "proven_to_rpm", "slowest_growth_rate_per_s", "wall_s", "commit"]
GROWN = "sections where µ peaks"


def rounded(value, digits=4):
    return "" if value is None else f"{value:.{digits}g}"


def row(program, name):
    """The figures of one design."""
    tool = ROTORS / f"{name}.tool.yaml"
    tool = tool if tool.exists() else ROTORS / f"{name.split('-small')[0]}.tool.yaml"
    with tempfile.TemporaryDirectory() as folder:
        begin = time.monotonic()
        spindle = str(ROTORS / f"{name}.yaml")
        subprocess.run([program, "design", "--spindle", spindle, "--tool", str(tool), "--out", folder + "/d", "--quiet"], check=False)
        wall = time.monotonic() - begin
        found = json.loads(Path(folder, "d", "summary.json").read_text())
    design = found["design"]
    attempts = design["polish"]["attempts"]
    grown = [k for k, attempt in enumerate(attempts) if GROWN in attempt["start"]]
    earlier = [a["polished"] for a in attempts[: grown[0]] if a["polished"] and not a["objections"]] if grown else []
    before = earlier[-1] if earlier else None
    kept = [a["polished"] for a in attempts if a["delivered"]] or [design["polish"]["dk"]]
    return dict(
        rotor=name,
        mu_before_growth=rounded(before and before["largest_mu"]),
        largest_mu=rounded(design["largest_mu"]),
        least_mu=rounded((design["specification_scale"] or {}).get("least_mu")),
        order=design["controller_order"],
        minimum_stiffness_at_rest_n_per_m=rounded(kept[0]["minimum_n_per_m"]),
        iso_zone=kept[0]["zone"],
        proven_to_rpm=rounded(design["speed_proof"]["proven_to_rpm"], 6),
        slowest_growth_rate_per_s=rounded(design["speed_proof"]["slowest_growth_rate_per_s"]),
        wall_s=rounded(wall, 3),
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--muspin", default=str(ROOT / "target" / "release" / "muspin"))
    parser.add_argument("rotors", nargs="*")
    arguments = parser.parse_args()
    names = sorted(p.name[:-5] for p in ROTORS.glob("*.yaml") if not p.name.endswith(".tool.yaml"))
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    rows = {}
    if arguments.rotors and TABLE.exists():
        with open(TABLE, newline="") as file:
            rows = {old["rotor"]: old for old in csv.DictReader(file)}
    for name in arguments.rotors or names:
        rows[name] = dict(row(arguments.muspin, name), commit=commit)
        print(rows[name], flush=True)
        with open(TABLE, "w", newline="") as file:
            table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            table.writeheader()
            table.writerows(rows[name] for name in sorted(rows))


if __name__ == "__main__":
    main()
