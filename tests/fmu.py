"""The units of `muspin export --fmu`, loop closed with FMPy, against `muspin simulate`.

usage: pip install fmpy && python3 tests/fmu.py [muspin]
Exit 77 says that fmpy, numpy or the C compiler is missing.
"""

import csv
import os
import shutil
import subprocess
import sys
import tempfile

try:
    import numpy as np
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave
    from fmpy.validation import validate_fmu
except ImportError as missing:
    print(f"missing: {missing}")
    sys.exit(77)
if shutil.which("cc") is None:
    print("missing: cc")
    sys.exit(77)

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MUSPIN = os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else os.path.join(ROOT, "target", "release", "muspin")
CONTROLLER = os.path.join(ROOT, "results", "reference", "controller", "discrete.json")
#: Samples that have to be the same to rounding.
EXACT = 200
AXES = ["front_x", "front_y", "rear_x", "rear_y"]
PLACES = ["tool_x", "tool_y", "front_actuator_x", "front_actuator_y", "rear_actuator_x", "rear_actuator_y"]


class Unit:
    """A unit with its variables by name."""

    def __init__(self, path, folder):
        problems = validate_fmu(path)
        assert not problems, f"{path}: {problems}"
        description = read_model_description(path)
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        made = extract(path, unzipdir=folder)
        self.three = description.fmiVersion.startswith("3")
        kind = FMU3Slave if self.three else FMU2Slave
        self.unit = kind(guid=description.guid, unzipDirectory=made, modelIdentifier=description.coSimulation.modelIdentifier)
        self.unit.instantiate()
        if self.three:
            self.unit.enterInitializationMode(startTime=0.0)
        else:
            self.unit.setupExperiment(startTime=0.0)
            self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()

    def set(self, names, values):
        numbers = [self.references[name] for name in names]
        (self.unit.setFloat64 if self.three else self.unit.setReal)(numbers, list(map(float, values)))

    def get(self, names):
        numbers = [self.references[name] for name in names]
        return np.array((self.unit.getFloat64 if self.three else self.unit.getReal)(numbers))

    def step(self, time, length):
        self.unit.doStep(currentCommunicationPoint=time, communicationStepSize=length)

    def end(self):
        self.unit.terminate()
        self.unit.freeInstance()


def loop(folder, version, load_n, samples, period):
    """Displacements and currents at every sample: sensors to the controller, currents to the machine."""
    machine = Unit(os.path.join(folder, f"muspin_machine-{version}.fmu"), os.path.join(folder, "m" + version))
    controller = Unit(os.path.join(folder, f"muspin_controller-{version}.fmu"), os.path.join(folder, "c" + version))
    found = []
    parts = 20
    for k in range(samples):
        time = k * period
        found.append(machine.get([f"displacement_{p}" for p in PLACES] + [f"current_{a}" for a in AXES]))
        controller.set([f"sensor_{a}" for a in AXES], machine.get([f"sensor_{a}" for a in AXES]))
        controller.step(time, period)
        machine.set([f"command_{a}" for a in AXES], controller.get([f"current_{a}" for a in AXES]))
        for j in range(parts):
            now = time + j * period / parts
            # The mean of a substep, because a load is held over a step of the unit.
            machine.set(["load_tool_x"], [load_n(now + 0.5 * period / parts)])
            machine.step(now, period / parts)
    machine.end()
    controller.end()
    return np.array(found)


def simulated(folder, case, *arguments):
    out = os.path.join(folder, case)
    command = [MUSPIN, "simulate", "--controller", CONTROLLER, "--case", case, "--out", out, *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    with open(os.path.join(out, "response.csv"), encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    table = dict(zip(head, np.array(rows, dtype=float).T))
    places = [p.replace("_actuator", "") for p in PLACES]
    names = [f"displacement_{p}_m" for p in places] + [f"current_{a}_a" for a in AXES]
    return table["time_s"], np.array([table[name] for name in names]).T


def main():
    folder = tempfile.mkdtemp()
    try:
        done = subprocess.run(
            [MUSPIN, "export", "--controller", CONTROLLER, "--fmu", "--out", os.path.join(folder, "export")],
            capture_output=True, text=True,
        )
        assert done.returncode == 0 and "no binary" not in done.stderr, done.stderr
        # A push that reaches the limits of the magnets and the backup bearings, and a load that stays.
        push_s = 5e-4
        cases = [
            ("step", lambda t: 40.0, ["--force", "40", "--duration", "0.1"]),
            ("impulse", lambda t: 50.0 * np.sin(np.pi * t / push_s) if t < push_s else 0.0, ["--duration", "0.1"]),
            ("contact", lambda t: 4000.0 * np.sin(np.pi * t / push_s) if t < push_s else 0.0,
             ["--force", "4000", "--speed", "0", "--duration", "0.1"]),
        ]
        worst = 0.0
        for case, load_n, arguments in cases:
            time, expected = simulated(folder, case, *arguments)
            period = time[1] - time[0]
            for version in ("fmi2", "fmi3"):
                found = loop(os.path.join(folder, "export"), version, load_n, len(time), period)
                for columns, what in ((slice(0, 6), "displacement"), (slice(6, 10), "current")):
                    difference = found[:, columns] - expected[:, columns]
                    size = np.abs(expected[:, columns]).max()
                    # Until a sensor signal stands on the edge between two steps both are the same to rounding; then a
                    # step goes the other way, and what follows differs by the response to 15 nm.
                    early = np.abs(difference[:EXACT]).max() / size
                    ratio = np.sqrt((difference**2).mean() / (expected[:, columns] ** 2).mean())
                    worst = max(worst, ratio) if what == "displacement" else worst
                    print(f"{case}, {version}, {what}: up to {size:.3e}; first {EXACT} samples {early:.1e}, rms of all {100 * ratio:.4f} %")
                    assert early < 1e-9, (case, version, what, early)
                    # Currents answer to single steps of the sensors: their difference after a flip is printed, not bounded.
                    assert what == "current" or ratio < 0.01, (case, version, what, ratio)
        print(f"the displacements of both units are those of simulate within {100 * worst:.4f} % rms")
    finally:
        shutil.rmtree(folder, ignore_errors=True)


main()
