# %% [markdown]
# Dynamic stiffness at the tool: the mu controller against two PIDs, computed from the committed reference run.
#
# usage: python3 tests/stiffness_picture.py [PICTURE.png]
# Needs the package (`pip install .`) and matplotlib; exit 77 says that one of them is missing.
#
# The curves are not read from the run but closed here with numpy, from the finite-element model with its exact delay and from the
# controllers as they run; the last cell compares them with the table that the run wrote.

# %%
import csv
import json
import os
import sys

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    import muspin
except ImportError as error:
    print(f"missing: {error}")
    sys.exit(77)

RUN = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "results", "reference")
spindle = muspin.Spindle.load(os.path.join(RUN, "spindle.yaml"), os.path.join(RUN, "tool.yaml"))

# %% [markdown]
# A sampled controller acts through its hold: magnitude sinc(f Ts). Its half sample is a part of the delay in the model.


# %%
def controller(name):
    """Response of a controller of the run at angular frequencies: lines x 4 x 4."""
    with open(os.path.join(RUN, "controller", name), encoding="utf-8") as file:
        k = json.load(file)
    a, b, c, d = (np.array(k[part]) for part in "ABCD")
    period = k["sample_time_s"]

    def response(omega):
        z = np.exp(1j * omega * period)
        inner = np.linalg.solve(z[:, None, None] * np.eye(len(a)) - a, np.broadcast_to(b, (len(omega), *b.shape)))
        return np.sinc(omega * period / (2 * np.pi))[:, None, None] * (c @ inner + d)

    return response


def stiffness(k, frequency_hz, rpm):
    """|F_t / x_t| in N/m along x with the loop u = K y closed."""
    omega = 2 * np.pi * frequency_hz
    h, gain = spindle.response(omega, rpm), k(omega)
    closed = np.linalg.solve(np.eye(4) - gain @ h[:, :4, :4], gain @ h[:, :4, 4:])
    compliance = h[:, 4:, 4:] + h[:, 4:, :4] @ closed
    return 1 / np.abs(compliance[:, 0, 0])


# %%
frequency_hz = np.geomspace(1, 4000, 1500)  # the band of the picture in the report
curves = {"µ": "discrete.json", "PID": "pid.json"}
figure, panels = plt.subplots(1, 2, figsize=(11, 4.2), sharey=True)
for panel, rpm in zip(panels, (0, spindle.max_rpm)):
    for name, file in curves.items():
        panel.loglog(frequency_hz, 1e-6 * stiffness(controller(file), frequency_hz, rpm), label=name)
    panel.set(title=f"{rpm:.0f} rpm", xlabel="frequency, Hz")
    panel.grid(True, which="both", alpha=0.3)
panels[0].set_ylabel("dynamic stiffness at the tool, N/µm")
panels[0].legend()
figure.tight_layout()
target = sys.argv[1] if len(sys.argv) > 1 else "stiffness.png"
figure.savefig(target, dpi=120)
print(f"{target} written")

# %% [markdown]
# The same against the table of the run, line by line.

# %%
with open(os.path.join(RUN, "plots", "stiffness.csv"), encoding="utf-8") as file:
    rows = list(csv.DictReader(file))
worst = 0.0
for series, file in (("mu", "discrete.json"), ("PID", "pid.json")):
    for panel in sorted({row["panel"] for row in rows}):
        own = [row for row in rows if (row["panel"], row["series"]) == (panel, series)]
        lines = np.array([float(row["frequency_hz"]) for row in own])
        written = np.array([float(row["dynamic_stiffness_n_per_um"]) for row in own])
        found = 1e-6 * stiffness(controller(file), lines, float(panel.split()[0]))
        error = np.max(np.abs(found / written - 1))
        worst = max(worst, error)
        print(f"{panel:>9} {series:>3}: smallest {written.min():.3f} N/µm, largest relative difference {error:.1e}")
# Two roads through one model: what differs is rounding, which the antiresonances enlarge.
if worst > 1e-6:
    sys.exit(f"the picture differs from the run by {worst:.1e}")
