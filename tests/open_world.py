"""Measurements of machines that another program computes, and what `muspin diagnose` says of them.

usage: python3 tests/open_world.py OUT [--muspin PROGRAM] [--only WORD] [--csv FILE] [--seed NUMBER]
Shafts and discs are ROSS's; magnets, amplifiers, sensors, controller, noise and the drawn errors are those of
`open_world_rig.py`. Every set is a folder OUT/NAME as `muspin diagnose` reads it, with what is hidden beside it in
OUT/NAME.truth.json; its seed is its number.
Records come from the frequency domain, or from a loop that runs at its sample time with quantised signals ("time"). Causes are
of the catalogue, at 1.2 to 5 times the size from which a healthy set of the same rig says that they have a name, or laws that the
catalogue lacks. Another --seed draws other rigs, errors, kinds and places. With --muspin every set is diagnosed and the table is
written. Needs numpy, scipy, PyYAML, ross-rotordynamics.
"""
import argparse
import csv
import json
import os
import subprocess
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")  # small matrices
import numpy as np
import yaml

try:
    from open_world_rig import AXES, SIDES, write_set
except ImportError as missing:
    print(f"missing: {missing}")
    sys.exit(77)

HERE = os.path.dirname(os.path.abspath(__file__))
STEEL = {"steel": {"youngs_modulus_pa": 2.06e11, "density_kg_m3": 7850, "poisson_ratio": 0.29}}


def cylinder(parts):
    """Elements of (length, diameter, pieces, region), mm."""
    return [dict(length_m=a * 1e-3 / n, outer_diameter_m=d * 1e-3, inner_diameter_m=0.0, material="steel", region=r)
            for a, d, n, r in parts for _ in range(n)]


def own_machine(name, parts, discs, planes, ki, ks, bias, rate_hz, delay_s, amplifier_hz, max_rpm):
    """A machine of this file: planes in mm, ki and ks of front and rear."""
    bearing = lambda i: dict(ki_n_per_a=ki[i], ks_n_per_m=ks[i], max_force_n=2.2 * ki[i] * bias, bias_current_a=bias,
                             max_current_a=2.7 * bias, gap_m=5e-4)
    keys = ("front_sensor_m", "front_actuator_m", "rear_actuator_m", "rear_sensor_m")
    disc = lambda z, m, ip, it: dict(position_m=z * 1e-3, mass_kg=m, polar_inertia_kg_m2=ip, diametral_inertia_kg_m2=it)
    return dict(
        name=name, rotor=dict(materials=STEEL, elements=cylinder(parts), discs=[disc(*d) for d in discs],
                              damping_ratio=[0.003, 0.004], flexible_modes=3),
        planes={k: z * 1e-3 for k, z in zip(keys, planes)}, bearings=dict(front=bearing(0), rear=bearing(1)),
        electronics=dict(amplifier_bandwidth_hz=amplifier_hz, sensor_bandwidth_hz=10000.0, sensor_noise_m=4e-8,
                         delay_s=delay_s, sample_rate_hz=rate_hz),
        speed=dict(max_rpm=max_rpm), backup_clearance_m=2.5e-4)


def machines():
    """Name to (spindle, tool, highest line of a sweep in Hz)."""
    shipped = lambda *path: yaml.safe_load(open(os.path.join(HERE, *path)))
    grinder = own_machine(
        "grinder", [(30, 32, 2, "nose"), (36, 40, 2, "front"), (24, 38, 2, "front"), (90, 42, 5, "motor"), (24, 36, 4, "rear"),
                    (36, 34, 4, "rear"), (22, 30, 2, "tail")],
        [(66, 0.12, 6e-5, 4e-5), (126, 0.35, 1.6e-4, 1.2e-4), (204, 0.1, 5e-5, 3e-5)], (46, 78, 192, 226), (150.0, 95.0),
        (6.5e5, 4.2e5), 2.5, 25000.0, 6e-5, 2500.0, 60000)
    mill = own_machine(
        "mill", [(50, 62, 2, "nose"), (60, 76, 3, "front"), (60, 70, 3, "front"), (180, 80, 8, "motor"), (50, 66, 3, "rear"),
                 (60, 60, 3, "rear"), (40, 52, 2, "tail")],
        [(130, 1.4, 2.2e-3, 1.5e-3), (260, 2.4, 3.4e-3, 3e-3), (420, 0.8, 1e-3, 8e-4)], (85, 135, 385, 432), (420.0, 260.0),
        (2.4e6, 1.5e6), 4.0, 16000.0, 9e-5, 1500.0, 24000)
    carbide = {"carbide": {"youngs_modulus_pa": 5.9e11, "density_kg_m3": 14400, "poisson_ratio": 0.22}}
    pin = dict(name="wheel-arbor", elements=[
        dict(e, region="arbor") for e in cylinder([(12, 26, 2, ""), (20, 16, 2, "")])], tool_plane_m=0.032)
    cutter = dict(name="cutter", materials=carbide, elements=[
        dict(length_m=0.02, outer_diameter_m=0.05, material="steel", region="holder"),
        dict(length_m=0.03, outer_diameter_m=0.036, material="steel", region="holder"),
        dict(length_m=0.035, outer_diameter_m=0.02, material="carbide")], tool_plane_m=0.085)
    return {
        "reference": (shipped("data", "spindles", "reference-updated.yaml"),
                      shipped("..", "spindles", "tools", "endmill-10.yaml"), 4000.0),
        "short": (shipped("data", "spindles", "s01-short-fast.yaml"), shipped("..", "spindles", "tools", "endmill-6.yaml"), 6000.0),
        "grinder": (grinder, pin, 5000.0), "mill": (mill, cutter, 2500.0)}


# Laws that the catalogue lacks, with the share of their size that is drawn.
OUTSIDE = [
    dict(effect="anisotropic_region", factors=[0.85, 1.0]), dict(effect="fractional_sensor", size=9000.0, exponent=0.6, bearing="front"),
    dict(effect="proportional_integral_amplifier", size=1300.0, damping=0.9), dict(effect="cole_iron", size=6000.0, exponent=0.35),
    dict(effect="leaky_iron", size=500.0, share=0.5, bearing="rear"), dict(effect="sensor_notch", size=700.0, zero=0.3, pole=0.45, axis="rear_x"),
    dict(effect="filtered_crosstalk", **{"from": "front_x", "to": "rear_x"}, size=0.05, hz=900.0),
    dict(effect="absorber", size=0.08, hz=420.0, ratio=0.06), dict(effect="hysteretic_place", size=8e5),
    dict(effect="slew_limit", size=900.0), dict(effect="current_play", size=0.02)]

# Rigs of healthy machines: what a rig adds that is no cause.
HEALTHY = [
    dict(domain="time", repeats=2, hum=[(50.02, 1e-7)]), dict(domain="time", repeats=3, excitation="chirp"),
    dict(domain="frequency", repeats=3, hum=[(50.02, 1e-7)]), dict(domain="frequency", repeats=2, hum=[(200.06, 4e-6)]),
    dict(domain="frequency", repeats=3, rows="missing"), dict(domain="frequency", repeats=4, rows="unequal"),
    dict(domain="frequency", repeats=2, rows="half"), dict(domain="frequency", repeats=2, width=2.5), dict(domain="time", repeats=2)]
SMALL = [dict(effect="axis_misalignment", bearing="front", size=0.05), dict(effect="actuator_offset", bearing="rear", size=1.6e-4)]


def larger(entry, factor, spindle):
    """The cause of an entry of `detectable`, `factor` times as large as named_from; None where this file has no such law."""
    kind, (key, size) = entry["effect"], next(iter(entry["named_from"].items()))
    cause = dict(effect=kind, **entry["where"])
    lag = lambda hz, nominal: 1 / ((1 / hz - nominal) * factor + nominal)
    if kind == "modal_damping":
        return dict(cause, factor=size**factor)
    if kind == "region_stiffness":
        return dict(effect="anisotropic_region", region=cause["region"], factors=[1 + (size - 1) * factor] * 2, named=kind)
    if kind == "amplifier_bandwidth":
        return dict(cause, size=lag(size, 1 / spindle["electronics"]["amplifier_bandwidth_hz"]))
    if kind == "eddy_currents":
        return dict(cause, size=size / factor**2)
    if kind in ("laminated_core", "sensor_lowpass"):
        return dict(cause, size=lag(size, 0.0))
    if key == "factor":
        return dict(cause, size=1 + (size - 1) * factor)
    known = ("loop_delay", "sensor_offset", "actuator_offset", "bearing_coupling", "axis_misalignment", "sensor_crosstalk", "added_mass",
             "cross_coupling", "tool_mass", "added_stiffness", "added_damper")
    return dict(cause, size=size * factor) if kind in known else None


def plan(places, claims, first):
    """(name, machine, speed, rig, cause, seed, class) of every set; `claims(machine, rig, seed)` are those of healthy records."""
    sets, names = [], list(places)
    usual = lambda rng, **more: dict(dict(domain="frequency", repeats=int(rng.integers(1, 4)), noise=float(rng.choice([0.5, 1.0, 2.0])),
                                          smooth=float(rng.choice([0.0005, 0.001, 0.002])), lines=110), **more)
    for i, rig in enumerate(HEALTHY + [{}, {}]):
        rng = np.random.default_rng(first + i)
        cause = SMALL[i - len(HEALTHY)] if i >= len(HEALTHY) else {}
        sets.append((f"healthy-{i:02}", names[i % 4], 0, usual(rng, **rig), cause, first + i, "nothing"))
    for i in range(24):
        seed = first + 1000 + i
        rng = np.random.default_rng(seed)
        machine = names[i % 4]
        wide = {16: 2.5, 17: 2.5, 18: 4.0, 19: 4.0, 20: 2.5, 21: 4.0}.get(i, 1.0)
        rig = usual(rng, width=wide)
        # What a wide machine does not say, that of a careful one does.
        claimed = claims(machine, rig, seed) or claims(machine, dict(rig, width=1.0), seed)
        entries = [larger(e, (1.2, 1.2, 2.0, 5.0)[i // 4 % 4], places[machine][0]) for e in claimed]
        by_kind = {}
        for c in filter(None, entries):
            by_kind.setdefault(c.get("named", c["effect"]), []).append(c)
        if not by_kind:  # no healthy records that say a size
            continue
        # Every kind comes about equally often; the place is drawn.
        kind = sorted(by_kind)[(5 * i + int(rng.integers(5))) % len(by_kind)]
        cause = by_kind[kind][int(rng.integers(len(by_kind[kind])))]
        # The loop in time has no lags of its own: laws of s stay in the frequency domain.
        lags = ("loop_delay", "amplifier_bandwidth", "eddy_currents", "laminated_core", "sensor_lowpass")
        domain = "time" if i % 6 == 5 and cause["effect"] not in lags else "frequency"
        sets.append((f"catalogue-{i:02}", machine, 0, dict(rig, domain=domain), cause, seed, "cause"))
    for i, law in enumerate(OUTSIDE):
        rng = np.random.default_rng(first + 2000 + i)
        machine = names[(i + 1) % 4]
        regions = sorted({e.get("region") for e in places[machine][0]["rotor"]["elements"]} - {None})
        length = sum(e["length_m"] for e in places[machine][0]["rotor"]["elements"])
        cause = dict(law)
        if law["effect"] == "anisotropic_region":
            cause["region"] = regions[int(rng.integers(len(regions)))]
        for key, laws in (("position_m", ["hysteretic_place"]), ("place_m", ["absorber"])):
            if law["effect"] in laws:
                cause[key] = round(float(rng.uniform(0.1, 0.9) * length), 4)
        domain = "time" if law["effect"] in ("slew_limit", "current_play") else "frequency"
        sets.append((f"outside-{i:02}", machine, 0, usual(rng, domain=domain), cause, first + 2000 + i, "outside"))
    return sets


def same(found, cause, length):
    """Whether a found effect is the hidden one: kind, where, and a position within 5 % of the shaft."""
    if found["effect"] != cause.get("named", cause.get("effect")):
        return False
    where = found.get("where", {})
    if "position_m" in cause:
        return abs(where.get("position_m", 9e9) - cause["position_m"]) < 0.05 * length and where.get("axis") == cause.get("axis")
    return all(where.get(k) == cause.get(k) for k in ("bearing", "axis", "region", "from", "to", "mode"))


def is_off(found, off):
    """Whether a found factor is one that was drawn: a number of the machine that is off, within 3 %."""
    axes = SIDES.get(found["where"].get("bearing"), [AXES.index(a) for a in found["where"].values() if a in AXES])
    factor = found["parameters"].get("factor", 1.0) - 1
    drawn = [off.get(found["effect"], [9.0] * 4)[a] for a in axes]
    return bool(drawn) and abs(np.mean(drawn) - factor) < 0.03 and abs(factor) > 0.03


def score(kind, cause, d, length, off):
    """right, wrong (a confident name that is not so), tie, refused or missed."""
    verdict, effects = d["verdict"], d.get("effects", [])
    tied = [e for t in d.get("tie") or [] for e in (t if isinstance(t, list) else t.get("effects", [t]))]
    if kind == "nothing":
        if effects and all(same(e, cause, length) if cause else is_off(e, off) for e in effects):
            return "right" if verdict != "tie" else "tie"  # what is there was named, though it need not be
        if verdict == "tie" and any(same(e, cause, length) if cause else is_off(e, off) for e in tied):
            return "tie"
        return {"adequate": "right", "unexplained": "refused"}.get(verdict, "wrong")
    if kind == "outside":
        return {"unexplained": "right", "adequate": "missed"}.get(verdict, "wrong")
    if verdict in ("unexplained", "adequate"):
        return "refused" if verdict == "unexplained" else "missed"
    if verdict != "tie" and effects and all(same(e, cause, length) or is_off(e, off) for e in effects):
        return "right"
    return "tie" if any(same(e, cause, length) or is_off(e, off) for e in tied) else "wrong"


def diagnose(program, folder):
    start = time.time()
    run = subprocess.run([program, "diagnose", "--measurement", folder, "--out", folder + ".found", "--json"], capture_output=True, text=True)
    seconds = time.time() - start
    if run.returncode not in (0, 1) or not run.stdout:
        return None, "; ".join(run.stderr.strip().splitlines()[:1]), seconds
    with open(folder + ".json", "w") as out:
        out.write(run.stdout)
    return json.loads(run.stdout)["diagnosis"], None, seconds


def words(effects):
    return "; ".join(f"{e['effect']} " + " ".join(f"{v:.4g}" if isinstance(v, float) else str(v)
                     for k, v in list(e.get("where", {}).items()) + list(e.get("parameters", {}).items())) for e in effects)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("out")
    parser.add_argument("--muspin", default=os.path.join(HERE, "..", "target", "release", "muspin"))
    parser.add_argument("--only", default="")
    parser.add_argument("--csv")
    parser.add_argument("--seed", type=int, default=1000)
    arguments = parser.parse_args()
    if not os.path.exists(arguments.muspin):
        print(f"missing: {arguments.muspin}")
        sys.exit(77)
    places = machines()
    columns = "set,seed,machine,domain,width,hidden,verdict,result,found,record_faults,gap_before,gap_after,seconds".split(",")
    table = csv.writer(open(arguments.csv, "w", newline="", buffering=1) if arguments.csv else sys.stdout, lineterminator="\n")
    table.writerow(columns)
    os.makedirs(arguments.out, exist_ok=True)

    def claims(machine, rig, seed):
        """What healthy records of a machine say of the least sizes; nothing where something is found missing."""
        folder = os.path.join(arguments.out, f"healthy-of-{seed}-{rig['width']:.1f}")
        if not os.path.exists(folder + ".json"):
            if write_set(folder, places[machine], 0, rig, {}, seed + 500) is None:
                return []
            diagnose(arguments.muspin, folder)
        found = json.load(open(folder + ".json"))["diagnosis"]
        return found["detectable"] if found["verdict"] == "adequate" else []

    for name, machine, rpm, rig, cause, seed, kind in plan(places, claims, arguments.seed):
        if arguments.only not in name:
            continue
        folder = os.path.join(arguments.out, name)
        spindle = places[machine][0]
        if not os.path.exists(folder + ".truth.json") and write_set(folder, places[machine], rpm, rig, cause, seed) is None:
            table.writerow([name, seed, machine, "", "", "does not levitate"])
            continue
        d, error, seconds = diagnose(arguments.muspin, folder)
        length = sum(e["length_m"] for e in spindle["rotor"]["elements"])
        off = json.load(open(folder + ".truth.json"))["off"]
        result = score(kind, cause, d, length, off) if d else "error"
        said = words(d["effects"]) if d else error
        hidden = " ".join(f"{v:.5g}" if isinstance(v, float) else str(v) for k, v in cause.items()) or "nothing"
        faults = "; ".join(f["fault"] for f in d["record_faults"]) if d else ""
        gaps = [d["gap_before"], d["gap_after"]] if d else ["", ""]
        table.writerow([name, seed, machine, rig["domain"], rig.get("width", 1.0), hidden, d["verdict"] if d else "", result, said, faults,
                        *[f"{g:.2f}" if isinstance(g, float) else g for g in gaps], f"{seconds:.1f}"])
        sys.stdout.flush()


if __name__ == "__main__":
    main()
