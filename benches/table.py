"""Times of the program and of its solvers beside other programs, and how they grow: writes results/bench/.

    pip install . control slycot scipy matplotlib          # the Python package; slycot is the peer of the solvers
    python benches/table.py [--out results/bench] [--program target/release/muspin] [--only NAME ...]

`table.csv` has a row for each piece of work: seconds (median), ratio to a fixed task timed beside it (eigenvalues of a 300 x 300
matrix, ten times, one thread), the same work by another program, and the ratio of the two. `growth.csv` has times over size with
the power fitted to the upper half of the sizes; `growth.svg` is its picture. Exit 77: a package is missing.
"""

from __future__ import annotations

import argparse
import csv
import datetime
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ.setdefault(variable, "1" if variable != "RAYON_NUM_THREADS" else "2")

try:
    import control
    import numpy as np
    import scipy.linalg
    import slycot

    import muspin
except ImportError as missing:
    print(f"left out: {missing}")
    sys.exit(77)

ROOT = Path(__file__).resolve().parent.parent
REPEATS = 5


def fixed_task() -> float:
    """Seconds of the task that ratios refer to."""
    matrix = np.random.default_rng(0).standard_normal((300, 300))
    start = time.perf_counter()
    for _ in range(10):
        np.linalg.eigvals(matrix)
    return time.perf_counter() - start


def seconds(work, at_least=0.05) -> float:
    """Median time of one call; short calls are repeated inside a measurement."""
    start = time.perf_counter()
    work()
    once = time.perf_counter() - start
    if once > 5:
        return once
    inside = max(1, int(at_least / max(once, 1e-9)))
    found = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        for _ in range(inside):
            work()
        found.append((time.perf_counter() - start) / inside)
    return statistics.median(found)


def stable(n: int, inputs: int, outputs: int, seed: int):
    """A lightly damped modal system of order n (even), as mechanical plants are."""
    random = np.random.default_rng(seed)
    a = np.zeros((n, n))
    for k in range(n // 2):
        w, zeta = 10.0 ** random.uniform(0, 3), 0.01
        a[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = [[0, w], [-w, -2 * zeta * w]]
    b, c = random.standard_normal((n, inputs)), random.standard_normal((outputs, n))
    return a, b, c, np.zeros((outputs, inputs))


def generalized(n: int, seed: int):
    """A mixed-sensitivity problem: disturbance and noise in, weighted output and control out, 2 controls, 2 signals."""
    a, b, c, _ = stable(n, 2, 2, seed)
    b1 = np.hstack([b, np.zeros((n, 2))])
    c1 = np.vstack([c, np.zeros((2, n))])
    d11, d12 = np.zeros((4, 4)), np.vstack([np.zeros((2, 2)), np.eye(2)])
    d21 = np.hstack([np.zeros((2, 2)), np.eye(2)])
    d = np.block([[d11, d12], [d21, np.zeros((2, 2))]])
    return control.ss(a, np.hstack([b1, b]), np.vstack([c1, c]), d)


def peer_hinfsyn(plant):
    """Optimal synthesis by SLICOT."""
    # Positive feedback and negative feedback differ in the sign of K only.
    return control.hinfsyn(plant, 2, 2)


def solvers():
    """Name, work, the same work by a peer, name of the peer."""
    for n in (14, 36, 60):
        a, b, c, d = stable(n, 3, 3, n)
        q, r = c.T @ c, np.eye(3)
        yield f"care n={n}", (lambda a=a, b=b, q=q, r=r: muspin.care(a, b, q, r)), (
            lambda a=a, b=b, q=q, r=r: scipy.linalg.solve_continuous_are(a, b, q, r)), "scipy"
        system = control.ss(a, b, c, d)
        yield f"hinfnorm n={n}", (lambda s=system: muspin.hinfnorm(s)), (lambda s=system: control.linfnorm(s)), "SLICOT AB13DD"
        plant = generalized(n, n)
        yield f"hinfsyn n={n}", (lambda p=plant: muspin.hinfsyn(p, 2, 2)), (lambda p=plant: peer_hinfsyn(p)), "SLICOT SB10AD"
    for n in (4, 8, 16):
        random = np.random.default_rng(n)
        m = random.standard_normal((n, n)) + 1j * random.standard_normal((n, n))
        blocks = [[1, 1]] * n
        yield f"mu {n}x{n}, scalar blocks", (lambda m=m, s=blocks: muspin.mussv(m, s)), (
            lambda m=m, n=n: slycot.ab13md(m, np.ones(n, dtype=int), 2 * np.ones(n, dtype=int))), "SLICOT AB13MD, upper bound only"


def programs(program: str, folder: str):
    """Whole processes: name and arguments."""
    data = ROOT / "tests/data/diagnosis"
    yield "design, reference spindle", ["design", "--spindle", str(ROOT / "results/reference/spindle.yaml"), "--out", f"{folder}/design"]
    yield "design --from, the same", ["design", "--spindle", str(ROOT / "results/reference/spindle.yaml"),
                                      "--from", str(ROOT / "results/reference"), "--out", f"{folder}/from"]
    yield "run", ["run", "--out", f"{folder}/run"]
    case = data / "c01"
    if case.is_dir():
        machine = ["--spindle", str(case / "spindle.yaml"), "--tool", str(case / "tool.yaml")]
        yield "run --quick with a measurement", ["run", "--quick", "--measurement", str(case), *machine, "--out", f"{folder}/quick"]
        yield "diagnose, one effect", ["diagnose", "--measurement", str(case), *machine, "--out", f"{folder}/diagnose"]


def growth(program: str, folder: str, with_tools: bool):
    """Name, power that theory expects, (size, work) pairs."""
    sizes = (10, 20, 40, 80, 140, 200)
    systems = {n: stable(n, 3, 3, n) for n in sizes}
    yield "care over the order", 3, [(n, lambda s=systems[n]: muspin.care(s[0], s[1], s[2].T @ s[2], np.eye(3))) for n in sizes]
    yield "hinfnorm over the order", 3, [(n, lambda s=control.ss(*systems[n]): muspin.hinfnorm(s)) for n in sizes]
    yield "hinfsyn over the order", 3, [(n, lambda p=generalized(n, n): muspin.hinfsyn(p, 2, 2)) for n in sizes[:5]]

    def frf(points: int):
        command = [program, "frf", "--from", "1", "--to", "5000", "--points", str(points)]
        return lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

    yield "frf over the lines", 1, [(n, frf(n)) for n in (100, 300, 1000, 3000, 10000)]

    def batch(tools: int):
        shipped = sorted(p.stem for p in (ROOT / "spindles/tools").glob("*.yaml"))[:tools]
        out = tempfile.mkdtemp(dir=folder)
        command = [program, "batch", "--quick", "--again", "--from", str(ROOT / "results/reference"), "--tools", ",".join(shipped),
                   "--spindle", str(ROOT / "results/reference/spindle.yaml"), "--out", out]
        return lambda: subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    if with_tools:
        yield "batch --quick --from over the tools", 1, [(n, batch(n)) for n in (1, 2, 4)]


def power(points) -> float:
    """Slope of the upper half of the sizes in double logarithms."""
    upper = points[len(points) // 2 - 1 :]
    x, y = np.log([p[0] for p in upper]), np.log([p[1] for p in upper])
    return float(np.polyfit(x, y, 1)[0])


def picture(curves, path: Path) -> None:
    """Times over size with their fitted powers."""
    try:
        import matplotlib

        matplotlib.use("svg")
        import matplotlib.pyplot as plt
    except ImportError:
        print("left out: the picture needs matplotlib")
        return
    plt.rcParams["svg.hashsalt"] = "muspin"
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for name, expected, points in curves:
        sizes, times = zip(*points)
        axes.loglog(sizes, times, "o-", label=f"{name}: power {power(points):.1f} (theory {expected})")
    axes.set_xlabel("Size")
    axes.set_ylabel("Time (s)")
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3, which="both")
    figure.savefig(path, metadata={"Date": None})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", default=str(ROOT / "results/bench"))
    parser.add_argument("--program", default=str(ROOT / "target/release/muspin"))
    parser.add_argument("--only", nargs="*", choices=["solvers", "programs", "growth"], default=["solvers", "programs", "growth"])
    parser.add_argument("--tools", action="store_true", help="growth over the number of tools as well: some minutes")
    given = parser.parse_args()
    out = Path(given.out)
    out.mkdir(parents=True, exist_ok=True)
    commit = subprocess.run(["git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    head = [f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores", datetime.date.today().isoformat(), commit]
    with tempfile.TemporaryDirectory() as folder:
        rows = []
        if "solvers" in given.only:
            for name, own, other, peer in solvers():
                unit = fixed_task()
                mine = seconds(own)
                try:
                    theirs = seconds(other)
                except Exception as failure:  # noqa: BLE001 - a peer that gives up is a result
                    theirs, peer = float("nan"), f"{peer}: {type(failure).__name__}"
                rows.append([name, mine, mine / unit, peer, theirs, mine / theirs])
                print(*rows[-1], sep="\t", flush=True)
        if "programs" in given.only:
            for name, arguments in programs(given.program, folder):
                found = []
                for _ in range(3):
                    unit, start = fixed_task(), time.perf_counter()
                    subprocess.run([given.program, *arguments], check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                    found.append((time.perf_counter() - start, unit))
                wall, unit = sorted(found)[1]
                rows.append([name, wall, wall / unit, "", "", ""])
                print(*rows[-1], sep="\t", flush=True)
        if rows:
            with open(out / "table.csv", "w", newline="") as file:
                table = csv.writer(file, lineterminator="\n")
                table.writerow(["machine", "date", "commit", "work", "seconds", "ratio_to_fixed_task", "peer", "peer_seconds", "ratio_to_peer"])
                table.writerows([[*head, *(f"{v:.3g}" if isinstance(v, float) else v for v in row)] for row in rows])
        if "growth" in given.only:
            curves = []
            for name, expected, works in growth(given.program, folder, given.tools):
                curves.append((name, expected, [(size, seconds(work)) for size, work in works]))
                print(name, curves[-1][2], f"power {power(curves[-1][2]):.2f}", flush=True)
            with open(out / "growth.csv", "w", newline="") as file:
                table = csv.writer(file, lineterminator="\n")
                table.writerow(["machine", "date", "commit", "work", "size", "seconds", "fitted_power", "power_in_theory"])
                for name, expected, points in curves:
                    for size, time_s in points:
                        table.writerow([*head, name, size, f"{time_s:.3g}", f"{power(points):.2f}", expected])
            picture(curves, out / "growth.svg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
