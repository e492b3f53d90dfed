"""A shaft that `muspin ross` writes, in ROSS: its free-free whirl frequencies are those of `muspin modes`.

usage: python3 tests/ross_rotor.py [MUSPIN]    (the program, by default target/release/muspin)
Needs ross-rotordynamics; exit 77 says that it or the program is missing.
"""
import json
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
PROGRAM = sys.argv[1] if len(sys.argv) > 1 else os.path.join(HERE, "..", "target", "release", "muspin")
sys.path.insert(0, os.path.join(HERE, "data", "ross"))
try:
    import ross
    from make import TO_HZ, frequencies
except ImportError as missing:
    print(f"missing: {missing}")
    sys.exit(77)
if not os.path.exists(PROGRAM):
    print(f"missing: {PROGRAM}")
    sys.exit(77)


def muspin(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=True).stdout


# The stiffness is the same. Where diameters for mass are others, the mass is a layer of its own in ROSS, which interpolates the motion
# between the nodes with the shear of that layer; this moves frequencies by up to 7e-6 with the elements of these shafts.
LIMIT = 2e-5
worst = compared = 0
with tempfile.TemporaryDirectory() as place:
    for spindle, tool in (("reference", "paper-tool"), ("reference", "drill-8")):
        muspin("--quiet", "ross", "--spindle", spindle, "--tool", tool, "--out", place)
        speeds = [0, 20000, 50000]
        own = json.loads(muspin("--json", "modes", "--spindle", spindle, "--tool", tool, "--speeds", ",".join(map(str, speeds))))
        for file in ("rotor.toml", "rotor.json"):
            rotor = ross.Rotor.load(os.path.join(place, file))
            for rpm, mode in zip(speeds, own["speeds"]):
                here = [f for f in mode["damped_frequencies_hz"] if 1 < f < TO_HZ]
                there = [f for f, _ in frequencies(rotor, rpm)]
                if len(here) != len(there):
                    sys.exit(f"{spindle} with {tool} at {rpm} rpm: {len(here)} modes, in ROSS {len(there)}: {here} {there}")
                for a, b in zip(here, there):
                    # Modal damping of 0.004 lowers the damped frequency by its half square.
                    worst = max(worst, abs(a / b - 1) - 0.004**2 / 2)
                    compared += 1
print(f"{compared} frequencies, largest relative difference {worst:.1e}")
sys.exit(int(worst > LIMIT))
