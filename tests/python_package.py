"""The Python package against python-control, SciPy, SLICOT and the cases of tests/data/control.

usage: pip install .[control,plot] scipy slycot && python3 tests/python_package.py
Exit 77 says that the package, control or scipy is missing; without slycot its comparisons are left out, without matplotlib the
pictures and the notebook of the guide.
"""

import copy
import glob
import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time

try:
    import control
    import numpy as np
    import scipy.linalg
    import scipy.signal

    import muspin
except ImportError as missing:
    print(f"missing: {missing}")
    sys.exit(77)
try:
    import slycot
except ImportError:
    slycot = None
try:
    import matplotlib

    matplotlib.use("Agg")
except ImportError:
    matplotlib = None

HERE = os.path.dirname(os.path.abspath(__file__))
CASES = os.path.join(HERE, "data", "control")
ran = 0
# A process in the background of a shell is born deaf to Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)


def cases(kind):
    for path in sorted(glob.glob(os.path.join(CASES, kind, "*.json"))):
        with open(path, encoding="utf-8") as file:
            yield json.load(file)


def check(good, what):
    global ran
    ran += 1
    if not good:
        print("FAIL", what)
        sys.exit(1)


def matrices(data, *names):
    return [np.array(data[name], dtype=float) for name in names]


# Riccati: against the multiple-precision solution of each case, and python-control's own where it is right.
for case in cases("care"):
    a, g, q = matrices(case["data"], "A", "G", "Q")
    x, residual, growth = muspin._native.care(a, g, q)
    reference = np.array(case["reference"]["X"])
    error = np.linalg.norm(x - reference) / np.linalg.norm(reference)
    check(error <= max(case["tolerance"]["X_rel_fro"], 1e-10), f"care {case['id']}: {error}")
    check(growth < 0, f"care {case['id']}: stable")
A, B, Q, R = np.array([[0.0, 1.0], [-2.0, 0.3]]), np.array([[0.0], [1.0]]), np.diag([2.0, 1.0]), np.array([[0.5]])
S = np.array([[0.1], [0.2]])
mine, theirs = muspin.care(A, B, Q, R, S), control.care(A, B, Q, R, S, np.eye(2))
for k, name in enumerate(["X", "L", "G"]):
    check(np.allclose(np.sort_complex(np.ravel(mine[k])), np.sort_complex(np.ravel(theirs[k])), atol=1e-9), f"care: {name}")

x = scipy.linalg.solve_continuous_are(A, B, Q, R, s=S)
check(np.allclose(muspin.care(A, B, Q, R, S).X, x, atol=1e-9), "care as SciPy")
E = np.array([[2.0, 0.3], [-0.4, 1.5]])
mine = muspin.care(A, B, Q, R, S, E)
check(np.allclose(mine.X, scipy.linalg.solve_continuous_are(A, B, Q, R, e=E, s=S), atol=1e-9), "care with E as SciPy")
check(np.all(mine.L.real < 0), "the loop of care with E is stable")
try:
    muspin.care(A, B, Q, R, S, np.ones((2, 2)))
    check(False, "care with a singular E")
except ValueError as error:
    check("singular" in str(error), "care with a singular E")

# H-infinity norm: the multiple-precision value of each case.
for case in cases("hinfnorm"):
    if "norm" not in case["reference"] or case["reference"]["norm"] is None:
        continue
    a, b, c, d = matrices(case["data"], "A", "B", "C", "D")
    found = muspin.hinfnorm((a, b, c, d))
    reference = case["reference"]["norm"]
    check(abs(found.norm / reference - 1) < 1e-6, f"hinfnorm {case['id']}: {found.norm} {reference}")
    check(found.norm <= found.upper, f"hinfnorm {case['id']}: upper bound")
    if slycot is not None:
        # SLICOT's answer is never above the certified bound; where it is right it is the same.
        theirs = control.linfnorm(control.ss(a, b, c, d, remove_useless_states=False))[0]
        check(theirs <= found.upper * (1 + 1e-6), f"hinfnorm {case['id']}: SLICOT {theirs}")
sampled = muspin.c2d(control.ss([[-1.0]], [[1.0]], [[1.0]], [[0.0]]), 0.1)
check(abs(muspin.hinfnorm(sampled).norm - 1.0) < 1e-8, "hinfnorm of a sampled lag is its gain at zero")

# mu: SLICOT's upper bound is not below mu, ours lies between the lower bound and it.
for case in cases("mu"):
    m = np.array(case["data"]["M"]["re"]) + 1j * np.array(case["data"]["M"]["im"])
    rows = {"complex_scalar": lambda b: [b["n"], 0], "real_scalar": lambda b: [-b["n"], 0]}
    blocks = [rows[b["type"]](b) if b["type"] in rows else [b["rows"], b["cols"]] for b in case["data"]["blocks"]]
    found = muspin.mussv(m, blocks)
    reference = case["reference"]
    limit = reference["upper_bound"] * (1 + case["tolerance"]["upper_rel"]) + case["tolerance"].get("upper_abs", 0)
    check(reference["lower_bound"] * (1 - 1e-9) <= found.upper <= limit, f"mussv {case['id']}: {found.upper}")
    check(found.lower <= found.upper * (1 + 1e-9), f"mussv {case['id']}: bounds")

# H-infinity synthesis: the norm of the returned loop, computed by python-control, is the certified one.
for case in cases("hinfsyn"):
    if "gamma_opt" not in case["reference"]:
        continue
    data = case["data"]
    plant = control.ss(*matrices(data, "A", "B", "C", "D"), remove_useless_states=False)
    found = muspin.hinfsyn(plant, data["p2"], data["m2"])
    check(np.all(found.CL.poles().real < 0), f"hinfsyn {case['id']}: stable")
    check(found.norm <= found.gam * (1 + 1e-6), f"hinfsyn {case['id']}: {found.norm} above {found.gam}")
    check(abs(muspin.hinfnorm(found.CL).norm / found.norm - 1) < 1e-6, f"hinfsyn {case['id']}: norm of CL")

# Assumptions that fail by a hair: x' = x + w + u, z = x, y = x + n/10 without a cost of u is refused, and met with a stated
# perturbation. No controller brings the gain from n to z below 1/10, and a high gain comes as close as one likes.
plant = (np.array([[1.0]]), np.array([[1.0, 0.0, 1.0]]), np.array([[1.0], [1.0]]), np.array([[0, 0, 0], [0, 0.1, 0]]))
try:
    muspin.hinfsyn(plant, 1, 1)
    check(False, "a plant without D12 is refused")
except ValueError as error:
    check("D12" in str(error), f"the reason is named: {error}")
found = muspin.hinfsyn(plant, 1, 1, regularise=True)
check(len(found.regularised.d12) == 1 and found.regularised.d12[0] > 0, f"what is added to D12 is told: {found.regularised}")
check(found.regularised.d21 == (), "D21 is left alone")
check(np.all(found.CL.poles().real < 0), "the loop of the plant as given is stable")
check(found.norm <= found.norm_regularised * (1 + 1e-8), "the added channel cannot lower the norm")
check(found.norm_regularised <= found.gam * (1 + 1e-6), "level of the regularised plant")
check(abs(muspin.hinfnorm(found.CL).norm / found.norm - 1) < 1e-6, "the norm is that of the plant as given")
check(0.1 <= found.norm < 0.1 * 1.002, f"regularised synthesis comes close to the infimum 0.1: {found.norm}")
smaller, larger = (muspin.hinfsyn(plant, 1, 1, regularise=share) for share in (1e-6, 1e-2))
check(0.1 <= smaller.gam < found.gam < larger.gam, f"the level grows with the perturbation: {smaller.gam} {found.gam} {larger.gam}")
# The size does not depend on units: a control in mA and a measurement in um.
a, b, c, d = plant
inputs, outputs = np.diag([1.0, 1.0, 1e-3]), np.diag([1.0, 1e6])
scaled = muspin.hinfsyn((a, b @ inputs, outputs @ c, outputs @ d @ inputs), 1, 1, regularise=True)
check(abs(scaled.gam / found.gam - 1) < 1e-3, f"regularisation and units: {scaled.gam} {found.gam}")
# A plant that meets the assumptions is left as it is.
regular = (np.array([[-1.0]]), np.array([[1.0, 0.0, 1.0]]), np.array([[1.0], [0.0], [1.0]]), np.array([[0, 0, 0], [0, 0, 1.0], [0, 1.0, 0]]))
plain, asked = muspin.hinfsyn(regular, 1, 1), muspin.hinfsyn(regular, 1, 1, regularise=True)
check(asked.regularised == ((), ()) and plain.gam == asked.gam and np.array_equal(plain.K.A, asked.K.A), "nothing is added without need")
for share in (0.0, -1.0, 2.0, float("nan")):
    try:
        muspin.hinfsyn(plant, 1, 1, regularise=share)
        check(False, f"regularise={share}")
    except ValueError as error:
        check("regularise" in str(error), f"regularise={share}: {error}")

# Reduction: the certified error against python-control's response, the bound 2 sum hsv.
draw = np.random.default_rng(3)
turned = np.linalg.qr(draw.normal(size=(8, 8)))[0]
modes = scipy.linalg.block_diag(*[[[-0.1 * w, w], [-w, -0.1 * w]] for w in (0.5, 1.5, 4.0, 9.0)])
full = control.ss(turned @ modes @ turned.T, draw.normal(size=(8, 2)), draw.normal(size=(2, 8)), np.zeros((2, 2)))
reduced = muspin.balred(full, 4, method="truncate")
omega = np.logspace(-3, 3, 400)
gap = max(np.linalg.norm(full(1j * w) - reduced.sys(1j * w), 2) for w in omega)
check(gap <= reduced.error * (1 + 1e-6) and reduced.error <= 2 * reduced.hsv[4:].sum() * (1 + 1e-6), "balred")
theirs = control.balred(full, 4, method="truncate")
check(max(np.linalg.norm(theirs(1j * w) - reduced.sys(1j * w), 2) for w in omega) < 1e-6, "balred as python-control")

# Sampling as python-control does it.
for method, prewarp in (("zoh", None), ("tustin", None), ("bilinear", 3.0)):
    mine = muspin.c2d(full, 0.05, method, prewarp_frequency=prewarp)
    theirs = control.c2d(full, 0.05, method, prewarp_frequency=prewarp)
    z = np.exp(1j * np.linspace(0.01, 3.0, 50))
    check(max(np.linalg.norm(mine(p) - theirs(p), 2) for p in z) < 1e-9, f"c2d {method} {prewarp}")

lag = control.tf([1.0, 3.0], [1.0, 0.4, 2.0, 1.0])
for method, theirs in (("foh", "foh"), ("impulse", "impulse"), ("matched", None)):
    mine = muspin.c2d(control.ss(lag), 0.05, method)
    if theirs:
        s = control.ss(lag)
        a, b, c, d, _ = scipy.signal.cont2discrete((s.A, s.B, s.C, s.D), 0.05, theirs)
        gaps = [abs((mine(p) - c @ np.linalg.solve(p * np.eye(3) - a, b) - d).item()) for p in np.exp(1j * np.linspace(0.01, 3.0, 50))]
        check(max(gaps) < 1e-9, f"c2d {method}")
    else:
        check(np.allclose(np.sort_complex(mine.poles()), np.sort_complex(np.exp(0.05 * lag.poles()))), "c2d matched: poles")
late = muspin.c2d(control.ss(lag), 0.05, "foh", input_delay=0.1)
check(abs(late(1j) - muspin.c2d(control.ss(lag), 0.05, "foh")(1j) / 1j**2) < 1e-12, "c2d with a delay of two samples")
try:
    muspin.c2d(control.ss([[-1.0]], [[1.0]], [[1.0]], [[1.0]]), 0.1, "impulse")
    check(False, "impulse invariance of a feedthrough")
except ValueError as error:
    check("feedthrough" in str(error), f"impulse: {error}")

# Sampled problems, and what python-control solves with SLICOT.
A, B, Q, R = np.array([[1.1, 0.3], [0.0, 0.8]]), np.array([[0.0], [1.0]]), np.diag([1.0, 2.0]), np.array([[0.5]])
mine, theirs = muspin.dare(A, B, Q, R), control.dare(A, B, Q, R)
for k, name in enumerate("XLG"):
    check(np.allclose(np.sort_complex(np.ravel(mine[k])), np.sort_complex(np.ravel(theirs[k])), atol=1e-9), f"dare: {name}")
plain = (np.array([[0.0, 200.0], [200.0, 0.0]]), np.array([[0.0, 0.0, 0.0], [200.0, 0.0, 200.0]]),
         np.array([[1.0, 0.0], [0.0, 0.0], [1.0, 0.0]]), np.array([[0, 0, 0], [0, 0, 0.1], [0, 0.01, 0]]))
found = muspin.h2syn(plain, 1, 1)
check(abs(found.norm / found.norm_opt - 1) < 1e-8, "h2syn")
if slycot is not None:
    loop = control.ss(*plain).lft(control.h2syn(control.ss(*plain), 1, 1))
    check(abs(muspin.h2norm((loop.A, loop.B, loop.C, 0 * loop.D)) / found.norm - 1) < 1e-8, "h2syn as SLICOT")
    g, w1 = control.ss(control.tf([200.0], [0.025, 1.0025, 10.1, 1.0])), control.ss(control.tf([0.667, 10.0], [1.0, 0.001]))
    check(abs(muspin.mixsyn(g, w1, 1.0).gam_opt / control.mixsyn(g, w1, control.ss([], [], [], [[1.0]]))[2][0] - 1) < 1e-4, "mixsyn")
    dm = control.disk_margins(g, np.logspace(-3, 4, 2000), skew=0.0)[0]
    try:
        check(abs(muspin.diskmargin(g)["multiloop"][0]["alpha"] / dm - 1) < 2e-3, "diskmargin")
    except ValueError as error:
        check("unstable" in str(error), f"diskmargin: {error}")
cost = muspin.lqg((A, B, np.array([[1.0, 0.0]]), np.zeros((1, 1)), 0.1), Q, R, np.eye(2), np.eye(1))
check(cost.K.dt == 0.1 and abs(cost.norm / cost.norm_opt - 1) < 1e-8, "lqg")
check(abs(muspin.ncfsyn(control.ss([[0.0]], [[1.0]], [[1.0]], [[0.0]])).emax - 0.5**0.5) < 1e-9, "ncfsyn of an integrator")
sampled = control.c2d(control.ss(*plain), 1e-3, "tustin")
one, other = muspin.hinfsyn(plain, 1, 1), muspin.hinfsyn(sampled, 1, 1)
check(abs(one.gam_opt / other.gam_opt - 1) < 1e-5 and other.K.dt == 1e-3 and other.norm <= other.gam, "hinfsyn of a sampled plant")
check(np.all(np.abs(other.CL.poles()) < 1), "hinfsyn of a sampled plant: stable")
check(abs(muspin.h2norm(control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], 1.0)) - (4 / 3) ** 0.5) < 1e-12, "h2norm of a sampled lag")

# D-K iteration: the bound is that of the loop, and not above the norm without structure.
omega0 = 200.0
plant = (
    np.array([[0, omega0], [omega0, 0]]), np.array([[0, 0, 0, 0], [0.2 * omega0, omega0, 0, omega0]]),
    np.array([[1, 0], [1, 0], [0, 0], [1, 0]]), np.array([[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0.1], [0, 0, 0.01, 0]]),
)
single, robust = muspin.hinfsyn(plant, 1, 1), muspin.musyn(plant, 1, 1, [[1, 1], [2, 2]])
check(robust.mu_lower <= robust.mu < single.gam, f"musyn: {robust.mu} {single.gam}")
check(np.all(robust.CL.poles().real < 0), "musyn: stable")
for w in np.geomspace(1.0, 1e5, 60):
    bound = muspin.mussv(robust.CL(1j * w), [[1, 1], [2, 2]])
    check(bound.lower <= robust.mu * (1 + 1e-6), f"musyn: mu at {w} is below the certified peak")
singular = tuple(np.array(x) for x in plant)
singular[3][2, 3] = 0.0
try:
    muspin.musyn(singular, 1, 1, [[1, 1], [2, 2]])
    check(False, "musyn refuses a plant without D12")
except ValueError as error:
    check("D12" in str(error) and "regularise=True" in str(error), f"musyn names the remedy: {error}")
met = muspin.musyn(singular, 1, 1, [[1, 1], [2, 2]], regularise=True)
check(len(met.regularised.d12) == 1 and np.all(met.CL.poles().real < 0), "musyn regularised")
for w in np.geomspace(1.0, 1e5, 60):
    check(muspin.mussv(met.CL(1j * w), [[1, 1], [2, 2]]).lower <= met.mu * (1 + 1e-6), "mu of the plant as given is below the bound")

# A spindle: response of the model, update from a measurement.
spindle = muspin.Spindle.load()
check(spindle.name == "reference" and spindle.response([100.0], 0).shape == (1, 6, 6), "Spindle")
design = spindle.plant(0)
exact, model = spindle.response([2 * np.pi * 300.0])[0], design(2j * np.pi * 300.0)
check(np.linalg.norm(exact[:4, :4] - model[:4, :4]) < 0.02 * np.linalg.norm(exact[:4, :4]), "design model at 300 Hz")
diagnosis = os.path.join(HERE, "data", "diagnosis", "c03")
measured = muspin.Spindle.load(os.path.join(diagnosis, "spindle.yaml"), os.path.join(diagnosis, "tool.yaml"))
updated, figures = measured.update(diagnosis)
check("updating" in figures and updated.name == measured.name, "update")
updating = measured.update(diagnosis)
check(updating.spindle == updated and "errors" in updating.tables and len(updating.sentence) > 10, "update: typed results")
diagnosed = measured.diagnose(diagnosis)
corrected, found = diagnosed
check(found["diagnosis"]["verdict"] in ("adequate", "named", "tie", "unexplained"), "diagnose")
check("gap" in diagnosed.tables and corrected.name == measured.name, "diagnose: tables")

# Signals have names, and the loop is closed by them.
check(design.input_labels[:5] == ["current_front_x", "current_front_y", "current_rear_x", "current_rear_y", "force_tool_x"], "names of inputs")
check(design.output_labels[3:5] == ["sensor_rear_y", "displacement_tool_x"], "names of outputs")
labelled = spindle.response([100.0, 200.0])
if hasattr(labelled, "sel"):
    one = labelled.sel(omega=200.0, output="displacement_tool_x", input="force_tool_x")
    check(one.item() == spindle.response([200.0])[0, 4, 4].item(), "labelled response")

# Copies and pickles are the same machine.
for twin in (copy.copy(spindle), copy.deepcopy(spindle), pickle.loads(pickle.dumps(spindle))):
    check(twin == spindle and np.array_equal(twin.response([500.0]), spindle.response([500.0])), "a copy is the same machine")
check(pickle.loads(pickle.dumps(corrected)) == corrected, "effects are copied too")
# A machine without a tool as well; its file says where stiffness counts, so that it needs no tool to be read again.
bare = muspin.Spindle.load("reference", "none")
check(pickle.loads(pickle.dumps(bare)) == bare and bare != spindle, "a machine without a tool is copied")
with tempfile.TemporaryDirectory() as folder:
    bare.save(os.path.join(folder, "bare.yaml"))
    check(os.listdir(folder) == ["bare.yaml"], "no tool file is written of no tool")
    check(muspin.Spindle.load(os.path.join(folder, "bare.yaml")) == bare, "a machine without a tool is read again")
check(spindle.with_tool("none") == bare, "the tool is taken out")
check(spindle.with_tool("drill-8") != spindle and spindle.with_tool("drill-8").tool == "drill-8", "another tool")
try:
    muspin.Spindle.load("reference", {"nonsense": 1})
    check(False, "a dictionary that is no tool")
except ValueError as error:
    check("nonsense" in str(error), f"a dictionary that is no tool: {error}")

# Backward and forward whirl coincide at rest and part at speed.
modes = spindle.modes([0.0, spindle.max_rpm])
rest, fast = (at["natural_frequencies_hz"] for at in modes["speeds"])
check(np.allclose(rest[0::2], rest[1::2], rtol=1e-6) and not np.allclose(fast[4], fast[5], rtol=1e-4), "modes: whirl pairs")

# A PID, its loop closed by names, compared, simulated, exported.
pid = spindle.pid()
K, figures = pid
check(K.dt == 5e-5 and K.input_labels[0] == "sensor_front_x" and K.output_labels[3] == "current_rear_y", "pid")
sampled_plant = control.c2d(spindle.plant(0, 4), K.dt)
sampled_plant = sampled_plant[["sensor_front_x", "sensor_front_y", "sensor_rear_x", "sensor_rear_y", "displacement_tool_x"],
                              ["current_front_x", "current_front_y", "current_rear_x", "current_rear_y", "force_tool_x"]]
loop = control.interconnect(
    [sampled_plant, K], inputs=["force_tool_x"], outputs=["displacement_tool_x"])
check(np.all(np.abs(loop.poles()) < 1.0), "the loop is closed by names and stable")
step = spindle.simulate(pid, "step", force=20.0, duration=0.2)
response = step.tables["response"]
check(response["time_s"].shape == response["displacement_tool_x_m"].shape and step.met, "simulate: table")
late = slice(-len(response["time_s"]) // 4, None)
linear = control.forced_response(loop, U=np.full(len(response["time_s"]), 20.0)).outputs
settled, expected = response["displacement_tool_x_m"][late].mean(), linear[late].mean()
check(abs(settled / expected - 1) < 0.05, f"the step is that of the loop closed by names: {settled} {expected}")
compared = spindle.compare(pid, rpm=[0.0])
smallest = compared.figures["stiffness"][next(iter(compared.figures["stiffness"]))]
check(compared.met is not None and smallest["minimum_n_per_m"] > 0, "compare")
with tempfile.TemporaryDirectory() as folder:
    exported = spindle.export(pid, os.path.join(folder, "firmware"))
    check("controller.c" in exported.files and os.path.exists(os.path.join(folder, "firmware", "controller.c")), "export")
    check("proven stable" in exported.sentence, f"export: {exported.sentence}")
    spindle.rehearse(os.path.join(folder, "rig"), rpm=0.0, repeats=2)
    identified = muspin.Spindle.load().identify(os.path.join(folder, "rig"))
    first = identified.figures["identification"]["resonances_hz"][0]
    expected = rest[0]
    check(identified.met and abs(first / expected - 1) < 2e-3, f"what is rehearsed is identified: {first} {expected}")
    compared.write(os.path.join(folder, "compared"))
    check(os.path.exists(os.path.join(folder, "compared", "report.html")), "a page is written")
try:
    import pandas

    frame = pandas.DataFrame(step.tables["response"])
    check(len(frame) > 1000 and "sensor_front_x_m" in frame.columns, "pandas takes the table")
except ImportError:
    pass
if matplotlib is not None:
    # Every number of a table stands in a curve, on an axis as the page has it.
    figure = compared.plot("stiffness")
    axes = [axes for axes in figure.axes if axes.get_visible()]
    table = compared.tables["plots/stiffness"]
    drawn = sum(len(line.get_xdata()) for panel in axes for line in panel.lines)
    columns = [name for name in table if name != "frequency_hz"]
    expected = sum(np.count_nonzero(~np.isnan(table[name])) for name in columns)
    check(drawn == expected > 100, f"plot: {drawn} points of {expected}")
    check(axes[0].get_xscale() == "log" and "(N/µm)" in axes[0].get_ylabel(), "plot: axes")
    for results in (compared, step, pid, updating, diagnosed):
        for name in results.pictures:
            panels = [axes for axes in results.plot(name).axes if axes.get_visible()]
            check(panels and all(p.lines or p.collections or p.patches for p in panels), f"plot: {name}")
            matplotlib.pyplot.close("all")
try:
    step.plot("nothing")
    check(False, "a picture that there is not")
except ValueError as error:
    check("response" in str(error), f"plot: {error}")

# A batch: the controllers are those of a design each, what fails is told in its row.
batch = spindle.batch(["paper-tool", "drill-8"], polish=False, quick=True)
check(batch.table["tool"] == ["paper-tool", "drill-8"], f"batch: {batch.table}")
made = json.loads(batch.results["paper-tool"].read("discrete.json"))
alone, figures = spindle.design("benchmark", polish=False)
check(np.array_equal(np.array(made["A"]), alone.A) and np.array_equal(np.array(made["D"]), alone.D), "batch: the design's controller")
check(batch.rows[0]["figures"]["largest_mu"] == figures["design"]["largest_mu"], "batch: figures")
failed = spindle.batch(["paper-tool"], weights="no such weights")
check("no such weights" in failed.rows[0]["failure"] and not failed.results, f"batch: {failed.rows}")

for call in (lambda: spindle.simulate(pid, "jump"), lambda: spindle.simulate(pid, force=-1.0), lambda: spindle.compare("no such file")):
    try:
        call()
        check(False, "malformed call is taken")
    except ValueError as error:
        check(len(str(error)) > 10, "words")

# mussv of a stack is mussv of its lines; transfer functions are systems.
stack = np.random.default_rng(2).normal(size=(3, 2, 2)) + 0j
check(np.allclose(muspin.mussv(stack, [[1, 1], [1, 1]]).upper, [muspin.mussv(m, [[1, 1], [1, 1]]).upper for m in stack]), "mussv of a stack")
check(abs(muspin.hinfnorm(control.tf([2.0], [1.0, 1.0])).norm - 2.0) < 1e-8, "hinfnorm of a transfer function")


class Enough(Exception):
    """Ends a design from its progress."""


told = []


def tell(words):
    told.append(words)
    if len(told) == 2:
        raise Enough(words)


try:
    spindle.design("benchmark", progress=tell)
    check(False, "an exception in progress ends the design")
except Enough:
    check(len(told) == 2 and all(isinstance(words, str) for words in told), f"progress: {told}")

# Numbers that numpy would drop without a word are refused.
stable = np.array([[-1.0, 0.5], [0.0, -2.0]])
masked = np.ma.masked_array(stable, mask=[[True, False], [False, False]])
for matrix, words in ((stable + 0.5j, "imaginary"), (masked, "masked"), ([masked[0], masked[1]], "masked")):
    try:
        muspin.hinfnorm((matrix, np.eye(2), np.eye(2), np.zeros((2, 2))))
        check(False, f"{words}: taken")
    except ValueError as error:
        check("A " in str(error) and words in str(error), f"{error}")
for matrix in (stable + 0j, np.ma.masked_array(stable, mask=False)):
    check(muspin.hinfnorm((matrix, np.eye(2), np.eye(2), np.zeros((2, 2)))).norm > 1.0, "nothing is lost: taken")

# What is wrong ends in ValueError or TypeError with words, never in a panic.
random = np.random.default_rng(1)
LIMIT = 300


def anything():
    """A matrix, or something that is none."""
    kind = random.integers(12)
    if kind == 0:
        return np.full((2, 2), np.nan)
    if kind == 1:
        return [[1, 2], [3]]
    if kind == 2:
        return "matrix"
    if kind == 3:
        return np.zeros((0, 0))
    if kind == 4:
        return np.zeros((2, 2, 2))
    if kind == 5:
        return np.full((3, 3), 1e308)
    if kind == 6:
        return None
    return random.normal(size=(random.integers(4), random.integers(4)))


def number():
    return [0, 1, 2, -1, 10**9, 1.5, float("nan"), float("inf"), 1e-300, None][random.integers(10)]


def system():
    if random.integers(3):
        n, m, p = random.integers(1, 4, size=3)
        return tuple(random.normal(size=shape) for shape in ((n, n), (n, m), (p, n), (p, m)))
    return tuple(anything() for _ in range(4))


calls = [
    lambda: muspin.care(anything(), anything(), anything(), anything()),
    lambda: muspin.hinfnorm(system()),
    lambda: muspin.hinfnorm((*system(), number())),
    lambda: muspin.hinfsyn(system(), number(), number(), number(), bool(random.integers(2))),
    lambda: muspin.musyn(system(), 1, 1, [[number(), number()]], 1),
    lambda: muspin.mussv(anything(), [[number(), number()], [1, 1]]),
    lambda: muspin.balred(system(), number()),
    lambda: muspin.c2d(system(), number(), ["zoh", "tustin", "spline"][random.integers(3)], number()),
    lambda: muspin.Spindle.load(["reference", "nobody", ""][random.integers(3)], ["paper-tool", "none"][random.integers(2)]).plant(number()),
    lambda: spindle.response([number()], number()),
    lambda: spindle.update("no such folder"),
    lambda: spindle.design("no such weights"),
    lambda: spindle.diagnose("no such folder"),
]
refused = 0
for trial in range(LIMIT):
    try:
        calls[trial % len(calls)]()
    except (ValueError, TypeError, OverflowError) as error:
        refused += 1
        check(len(str(error)) > 5, "an error has words")
check(refused > LIMIT / 3, f"{refused} of {LIMIT} malformed calls are refused")

# A long call lets other threads run, and Ctrl-C ends it at once.
counted = 0
ended = threading.Event()


def count():
    global counted
    while not ended.is_set():
        counted += 1
        time.sleep(0.01)


threading.Thread(target=count, daemon=True).start()
# Early in the design, which has ended within a second and a half.
threading.Timer(0.4, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
began = time.monotonic()
try:
    spindle.design("benchmark")
    check(False, "the design was not interrupted")
except KeyboardInterrupt:
    took = time.monotonic() - began
    check(took < 4, f"Ctrl-C took {took} s")
ended.set()
# It asks to run every 10 ms; a third of that is left where the machine is loaded.
check(counted > took / 0.01 / 3, f"another thread ran {counted} times in {took} s beside the design")

# Ctrl-C ends the computing thread as well: soon after it the process computes no more.
with tempfile.TemporaryDirectory() as folder:
    rig = os.path.join(folder, "rig")
    spindle.rehearse(rig, rpm=np.linspace(0.0, 20000.0, 9), repeats=40)
    for name, work in (
        ("rehearse", lambda: spindle.rehearse(os.path.join(folder, "long"), rpm=np.linspace(0.0, 20000.0, 41), repeats=40)),
        ("identify", lambda: spindle.identify(rig)),
    ):
        threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        try:
            work()
            check(False, f"{name} was not interrupted")
        except KeyboardInterrupt:
            pass
        time.sleep(2.0)
        before = time.process_time()
        time.sleep(1.0)
        check(time.process_time() - before < 0.3, f"{name} computes on after Ctrl-C")

# The command line of the package.
version = subprocess.run([sys.executable, "-m", "muspin", "--version"], capture_output=True, text=True, check=True).stdout
check(muspin.__version__ in version, version)

# The notebook of the guide runs as it is.
if matplotlib is not None:
    with open(os.path.join(os.path.dirname(HERE), "src", "guide", "first_loop.ipynb"), encoding="utf-8") as file:
        notebook = json.load(file)
    names = {}
    for number, cell in enumerate(cell for cell in notebook["cells"] if cell["cell_type"] == "code"):
        exec(compile("".join(cell["source"]), f"first_loop.ipynb, code cell {number + 1}", "exec"), names)
    check("firmware" in names and "controller.c" in names["firmware"].files, "the notebook comes to its end")

# A design within the limits of the specification, with the figures of `muspin design`.
if "--design" in sys.argv:
    K, figures = spindle.design("benchmark", polish=False)
    check(figures["design"]["largest_mu"] <= 1.0 and K.dt == 5e-5, "design")
print(f"{ran} checks hold" + ("" if slycot else "; slycot is missing, its comparisons were left out"))
