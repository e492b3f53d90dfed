"""Measurements of machines that another program computes, and what `muspin diagnose` says of them.

usage: python3 tests/open_world.py OUT [--muspin PROGRAM] [--only WORD] [--csv FILE]
Shafts and discs are ROSS's; magnets, amplifiers, sensors, controller, noise and the drawn errors are this file's own. Every set
is a folder OUT/NAME as `muspin diagnose` reads it, with what is hidden beside it in OUT/NAME.truth.json; its seed is its number.
Records come from the frequency domain, or from a loop that runs at its sample time with quantised signals ("time"). Causes are
of the catalogue, at 1.2 to 5 times the size from which the machine's healthy set says that they have a name, or laws that the
catalogue lacks. With --muspin every set is diagnosed and the table is written. Needs numpy, scipy, PyYAML, ross-rotordynamics.
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
from scipy.linalg import eigh, expm
from scipy.optimize import differential_evolution

try:
    import ross
except ImportError as missing:
    print(f"missing: {missing}")
    sys.exit(77)

HERE = os.path.dirname(os.path.abspath(__file__))
AXES = ["front_x", "front_y", "rear_x", "rear_y"]
SIDES = {"front": [0, 1], "rear": [2, 3], "both": [0, 1, 2, 3]}
STEEL = {"steel": {"youngs_modulus_pa": 2.06e11, "density_kg_m3": 7850, "poisson_ratio": 0.29}}
PIDS = {}


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


class Truth:
    """The machine as it is: drawn errors of `width` times careful work, and a hidden cause."""

    def __init__(self, spindle, tool, rng, width, cause):
        self.spindle, self.cause, e = spindle, cause, spindle["electronics"]
        self.tool_m = sum(x["length_m"] for x in tool["elements"])
        materials = dict(spindle["rotor"]["materials"], **tool.get("materials", {}))
        elements = tool["elements"][::-1] + spindle["rotor"]["elements"]
        draw = {r: rng.normal() for r in sorted({x.get("region") or "" for x in elements})}
        self.modulus = {r: 1 + 0.01 * width * (d if r else 0) for r, d in draw.items()}
        self.plane_x, self.z = self.shaft(elements, materials, tool, 0)
        self.plane_y = self.shaft(elements, materials, tool, 1)[0] if cause.get("effect") == "anisotropic_region" else self.plane_x
        m, k, _ = self.plane_x
        values, self.phi = eigh(k, m)  # all modes: the tip of a thin tool is soft by the highest ones
        self.modes = n = len(values)
        ratio = spindle["rotor"]["damping_ratio"]
        ratio = np.array([0, 0] + [ratio[min(i, len(ratio) - 1)] for i in range(n - 2)])
        ratio[2:] *= np.exp(0.15 * width * rng.normal(size=n - 2))
        if cause.get("effect") == "modal_damping":
            ratio[1 + cause["mode"]] *= cause["factor"]
        self.omega = np.sqrt(np.maximum(values, 0.0))
        self.omega[:2] = 0.0
        b, p = spindle["bearings"], spindle["planes"]
        each = lambda f: np.repeat([f("front"), f("rear")], 2).astype(float)
        self.ki = each(lambda s: b[s]["ki_n_per_a"] * (1 + 0.02 * width * rng.normal()))
        self.ks = each(lambda s: b[s]["ks_n_per_m"] * (1 + 0.04 * width * rng.normal()))
        self.gain = np.array([b[a[:-2]].get("sensor_gain", 1.0) for a in AXES]) 
        self.gain *= 1 + 0.01 * width * np.repeat(rng.normal(size=2), 2) + 0.002 * rng.normal(size=4)
        self.act_m, self.sen_m = (each(lambda s: p[f"{s}_{what}_m"]) for what in ("actuator", "sensor"))
        self.currents, self.signals = np.eye(4), np.eye(4)
        size = cause.get("size", 0.0)
        on = np.isin(np.arange(4), self.axes_of(cause))
        kind = cause.get("effect")
        if kind in ("force_constant", "negative_stiffness", "sensor_gain"):
            target = {"force_constant": self.ki, "negative_stiffness": self.ks, "sensor_gain": self.gain}[kind]
            nominal = [b[a[:-2]][{"force_constant": "ki_n_per_a", "negative_stiffness": "ks_n_per_m"}.get(kind, "")]
                       if kind != "sensor_gain" else b[a[:-2]].get("sensor_gain", 1.0) for a in AXES]
            target[on] = size * np.array(nominal)[on]  # the size says how far the number is off in all
        self.off = dict(force_constant=self.ki / each(lambda s: b[s]["ki_n_per_a"]), sensor_gain=self.gain,
                        negative_stiffness=self.ks / each(lambda s: b[s]["ks_n_per_m"]))
        if kind in ("sensor_offset", "actuator_offset"):
            (self.sen_m if kind == "sensor_offset" else self.act_m)[on] += size
        elif kind == "axis_misalignment":
            c, s = np.cos(np.radians(size)), np.sin(np.radians(size))
            for at in (i for i in (slice(0, 2), slice(2, 4)) if on[i].any()):
                self.signals[at, at] = [[c, s], [-s, c]]
        elif kind == "bearing_coupling":
            for x in (i for i in (0, 2) if on[i]):
                self.currents[x, x + 1] = self.currents[x + 1, x] = size
        elif kind == "sensor_crosstalk":
            self.signals[AXES.index(cause["to"]), AXES.index(cause["from"])] += size
        nodes = lambda z, slope=0: self.phi.T @ self.shape(z, slope)
        self.act = np.array([nodes(z) for z in self.act_m])
        self.sen = np.array([nodes(z) for z in self.sen_m])
        self.tip = nodes(-tool["tool_plane_m"])
        two = lambda a, b: np.block([[a, np.zeros((n, n))], [np.zeros((n, n)), b]])
        self.m = np.eye(2 * n)
        self.k = two(np.diag(self.omega**2), self.phi.T @ self.plane_y[1] @ self.phi)
        self.c = two(*[np.diag(2 * ratio * self.omega)] * 2)
        self.d = np.zeros((2 * n, 2 * n))  # a part of the stiffness in phase with the velocity
        g = self.phi.T @ self.plane_x[2] @ self.phi
        for a in range(4):
            part = slice(a % 2 * n, a % 2 * n + n)
            self.k[part, part] -= self.ks[a] * np.outer(self.act[a], self.act[a])
        if "position_m" in cause:
            v, w = nodes(cause["position_m"]), nodes(cause["position_m"], 1)
            sides = {"x": (1, 0), "y": (0, 1)}.get(cause.get("axis"), (1, 1))
            put = lambda r: two(*[s * np.outer(r, r) for s in sides])
            if kind == "added_stiffness":
                self.k += size * put(v)
            elif kind == "added_damper":
                self.c += size * put(v)
            elif kind == "tilting_stiffness":
                self.k += size * put(w)
            elif kind in ("added_mass", "added_disc"):
                self.m += size * put(v) + cause.get("diametral", 0.0) * put(w)
                g += cause.get("polar", 0.0) * np.outer(w, w)
            elif kind == "cross_coupling":
                self.k += size * np.block([[np.zeros((n, n)), np.outer(v, v)], [-np.outer(v, v), np.zeros((n, n))]])
            elif kind == "hysteretic_place":
                self.d += size * put(v)
        if kind == "tool_mass":
            self.m += size * two(*[np.outer(nodes(-self.tool_m), nodes(-self.tool_m))] * 2)
        self.g = np.block([[np.zeros((n, n)), g], [-g, np.zeros((n, n))]])
        self.forces, self.reads = np.zeros((2 * n, 4)), np.zeros((4, 2 * n))
        for a in range(4):
            self.forces[a % 2 * n:a % 2 * n + n, a] = self.act[a]
            self.reads[a, a % 2 * n:a % 2 * n + n] = self.sen[a]
        self.delay_s, self.period_s = e["delay_s"], 1 / e["sample_rate_hz"]

    def axes_of(self, cause):
        return SIDES[cause["bearing"]] if "bearing" in cause else [AXES.index(cause["axis"])] if cause.get("axis") in AXES else \
            [0, 1, 2, 3]

    def shaft(self, elements, materials, tool, plane):
        """ROSS's mass, stiffness and gyroscopic matrix of one plane (displacement, slope), two elements for one; node positions."""
        pieces, at, made = [], [-self.tool_m], {}
        for e in elements:
            region = e.get("region") or ""
            factor = self.modulus[region] * e.get("modulus_scale", 1.0)
            if self.cause.get("region") == region and region:
                factor *= self.cause["factors"][plane]
            key = (e["material"], factor)
            if key not in made:
                t = materials[e["material"]]
                made[key] = ross.Material(name=f"m{len(made)}", rho=t["density_kg_m3"], E=t["youngs_modulus_pa"] * factor,
                                          Poisson=t["poisson_ratio"])
            half = dict(L=e["length_m"] / 2, idl=e.get("inner_diameter_m", 0.0), odl=e["outer_diameter_m"], material=made[key])
            pieces += [ross.ShaftElement(shear_method_calc="cowper", **half) for _ in range(2)]
            at += [at[-1] + e["length_m"] / 2, at[-1] + e["length_m"]]
        at, discs = np.array(at), []
        for sign, owner in ((1, self.spindle["rotor"]), (-1, tool)):
            for d in owner.get("discs") or []:
                n = int(np.argmin(abs(at - sign * d["position_m"])))
                discs.append(ross.DiskElement(n=n, m=d["mass_kg"], Id=d["diametral_inertia_kg_m2"], Ip=d["polar_inertia_kg_m2"]))
        rotor = ross.Rotor(pieces, discs)
        dof = rotor.number_dof
        x, y = ([dof * i + j for i in range(len(at)) for j in pair] for pair in ((0, 4), (1, 3)))
        turn = np.tile([1.0, -1.0], len(at))  # ROSS's second angle is minus the slope of y
        m, k, g = (np.asarray(v) for v in (rotor.M(0), rotor.K(0), rotor.G()))
        sym = lambda a: 0.5 * (a + a.T)
        return (sym(m[np.ix_(x, x)]), sym(k[np.ix_(x, x)]), g[np.ix_(x, y)] * turn), at

    def shape(self, z, slope):
        i = int(np.clip(np.searchsorted(self.z, z) - 1, 0, len(self.z) - 2))
        h = self.z[i + 1] - self.z[i]
        t = (z - self.z[i]) / h
        v = [(6 * t * t - 6 * t) / h, 1 - 4 * t + 3 * t * t, (6 * t - 6 * t * t) / h, 3 * t * t - 2 * t] if slope else \
            [1 - 3 * t * t + 2 * t**3, h * (t - 2 * t * t + t**3), 3 * t * t - 2 * t**3, h * (t**3 - t * t)]
        row = np.zeros(2 * len(self.z))
        row[2 * i:2 * i + 4] = v
        return row

    def lags(self, s):
        """Currents to forces over ki, and displacements to signals over gain, both 4x4 at s."""
        e, c, w = self.spindle["electronics"], self.cause, lambda hz: 2 * np.pi * hz
        force, signal = [], []
        kind = c.get("effect")
        for a in range(4):
            f = 1 / (1 + s / w(e["amplifier_bandwidth_hz"]))
            y = 1 / (1 + s / w(e["sensor_bandwidth_hz"]))
            if a in self.axes_of(c) and kind:
                hz = w(c.get("size", 1.0))
                if kind == "loop_delay":
                    f *= np.exp(-s * c["size"])
                elif kind == "amplifier_bandwidth":
                    f = 1 / (1 + s / hz)
                elif kind == "amplifier_second_order":
                    f = hz**2 / (s * s + 2 * c["damping"] * hz * s + hz**2)
                elif kind == "proportional_integral_amplifier":
                    f = (2 * c["damping"] * hz * s + hz**2) / (s * s + 2 * c["damping"] * hz * s + hz**2)
                elif kind == "eddy_currents":
                    f /= 1 + np.sqrt(s / hz)
                elif kind == "laminated_core":
                    f *= np.tanh(np.sqrt(s / hz)) / np.sqrt(s / hz)
                elif kind == "leaky_iron":
                    f *= c["share"] + (1 - c["share"]) * np.tanh(np.sqrt(s / hz)) / np.sqrt(s / hz)
                elif kind == "cole_iron":
                    f /= 1 + (s / hz) ** c["exponent"]
                elif kind == "sensor_lowpass":
                    y /= s * s / hz**2 + 2 * 0.707 * s / hz + 1
                elif kind == "fractional_sensor":
                    y /= (1 + s / hz) ** c["exponent"]
                elif kind == "sensor_notch":
                    y *= (s * s + 2 * c["zero"] * hz * s + hz**2) / (s * s + 2 * c["pole"] * hz * s + hz**2)
            force.append(f * np.exp(-s * self.delay_s))
            signal.append(y)
        cross = np.zeros((4, 4), complex)
        if kind == "filtered_crosstalk":
            cross[AXES.index(c["to"]), AXES.index(c["from"])] = c["size"] * s / (s + w(c["hz"]))
        return np.diag(self.ki) @ self.currents @ np.diag(force), (self.signals + cross) @ np.diag(self.gain) @ np.diag(signal)

    def receptance(self, hz, rpm, inputs, outputs):
        s = 2j * np.pi * hz
        absorber = self.cause.get("effect") == "absorber"
        z = self.m * s * s + (self.c + self.g * rpm * np.pi / 30) * s + self.k + 1j * self.d
        if absorber:
            c = self.cause
            v, wa = self.phi.T @ self.shape(c["place_m"], 0), 2 * np.pi * c["hz"]
            r = 2 * c["ratio"] * wa * s + wa**2
            dynamic = c["size"] * s * s * r / (s * s + r)
            z = z + np.kron(np.eye(2), np.outer(v, v)) * dynamic
        return outputs @ np.linalg.solve(z, inputs)

    def plant(self, hz, rpm):
        force, signal = self.lags(2j * np.pi * hz)
        return signal @ self.receptance(hz, rpm, self.forces, self.reads) @ force

    def compliance(self, hz, rpm, control, axis):
        tip = np.kron(np.eye(2)[axis], self.tip)[:, None]
        inputs = np.hstack([self.forces, tip])
        h = self.receptance(hz, rpm, inputs, np.vstack([self.reads, tip.T]))
        force, signal = self.lags(2j * np.pi * hz)
        back = force @ control @ signal
        return h[4, 4] + h[4, :4] @ back @ np.linalg.solve(np.eye(4) - h[:4, :4] @ back, h[:4, 4])

    def sampled(self, modes):
        """(A, B early, B late, C, whole samples of delay): mechanics, amplifiers and sensors over a sample."""
        e = self.spindle["electronics"]
        pick = np.r_[0:modes, self.modes:self.modes + modes]
        m, k, c = (x[np.ix_(pick, pick)] for x in (self.m, self.k, self.c))
        n, wa, ws = len(pick), 2 * np.pi * e["amplifier_bandwidth_hz"], 2 * np.pi * e["sensor_bandwidth_hz"]
        # Laws without a rational form are a delay of their lag at 200 Hz here, for the choice of the controller only.
        lag = [np.angle(np.diag(x)) for x in self.lags(2j * np.pi * 200.0)]
        usual = np.angle(np.exp(-2j * np.pi * 200 * self.delay_s) / (1 + 400j * np.pi / wa)), np.angle(1 / (1 + 400j * np.pi / ws))
        extra = max(0.0, np.max(usual[0] - lag[0]) + np.max(usual[1] - lag[1])) / (400 * np.pi)
        size = 2 * n + 8
        a, b, y = np.zeros((size, size)), np.zeros((size, 4)), np.zeros((4, size))
        a[:n, n:2 * n] = np.eye(n)
        a[n:2 * n, :n], a[n:2 * n, n:2 * n] = -np.linalg.solve(m, k), -np.linalg.solve(m, c)
        a[n:2 * n, 2 * n:2 * n + 4] = np.linalg.solve(m, self.forces[pick]) @ np.diag(self.ki) @ self.currents
        a[2 * n:2 * n + 4, 2 * n:2 * n + 4], b[2 * n:2 * n + 4] = -wa * np.eye(4), wa * np.eye(4)
        a[2 * n + 4:, :n], a[2 * n + 4:, 2 * n + 4:] = ws * np.diag(self.gain) @ self.reads[:, pick], -ws * np.eye(4)
        y[:, 2 * n + 4:] = self.signals
        rest = max(self.delay_s + extra - self.period_s / 2, 0.0)
        whole, part = divmod(rest + 1e-12, self.period_s)
        step = lambda t: expm(np.block([[a, b], [np.zeros((4, size + 4))]]) * t)
        late, all_of_it = step(self.period_s - part), step(self.period_s)
        newer = late[:size, size:]
        return all_of_it[:size, :size], all_of_it[:size, size:] - newer, newer, y, int(whole)


class Loop:
    """A PID with roll-off and a biquad for each bearing, sampled by Tustin's rule, chosen for damping of the machine given."""

    BOUNDS = [(0.2, 1.6), (-0.5, 1.2), (0.5, 3.0), (0.2, 3.0), (-2.0, 1.5), (-1.0, 1.0), (0.2, 1.2)] * 2

    def __init__(self, truth):
        self.truth, self.t = truth, truth.period_s
        b = [truth.spindle["bearings"][s] for s in ("front", "rear")]
        self.least = [x["ks_n_per_m"] / x["ki_n_per_a"] for x in b]
        mass = 1 / (truth.act[0, :2] @ truth.act[0, :2]), 1 / (truth.act[2, :2] @ truth.act[2, :2])
        self.lead = [np.sqrt(m / x["ks_n_per_m"]) for m, x in zip(mass, b)]
        self.fold = max(x for x in truth.omega[2:5] if x < 0.8 * np.pi / self.t) / (2 * np.pi)

    def axis(self, side, p):
        """State space of one axis, from sections in series."""
        kp, td = self.least[side] * 2 ** p[0], self.lead[side] * 2 ** p[1]
        wd, wl, wb = (2 * np.pi * self.fold * 2 ** x for x in (p[2] - 1.5, p[3], p[4]))
        sections = [([1, 2 * np.pi], [1, 0]), ([td + 1 / wd, 1], [1 / wd, 1]), ([wl**2], [1, 1.4 * wl, wl**2]),
                    ([1 / wb**2, 2 * p[6] * 2 ** p[5] / wb, 1], [1 / wb**2, 2 * p[6] / wb, 1])]
        a, b, c, d = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.array([[-kp]])
        for num, den in sections:
            a2, b2, c2, d2 = tustin(num, den, self.t)
            a = np.block([[a, np.zeros((len(a), len(a2)))], [b2 @ c, a2]])
            b, c, d = np.vstack([b, b2 @ d]), np.hstack([d2 @ c, c2]), d2 @ d
        return a, b, c, d

    def law(self, p):
        sides = [self.axis(i, p[7 * i:7 * i + 7]) for i in (0, 0, 1, 1)]
        n = len(sides[0][0])
        a, b, c, d = np.zeros((4 * n, 4 * n)), np.zeros((4 * n, 4)), np.zeros((4, 4 * n)), np.zeros((4, 4))
        for i, (x, y, z, w) in enumerate(sides):
            s = slice(n * i, n * i + n)
            a[s, s], b[s, i:i + 1], c[i:i + 1, s], d[i, i] = x, y, z, w[0, 0]
        return a, b, c, d

    def growth(self, model, law, axes, gain=1.0):
        """Largest growth rate, 1/s, of the axes given."""
        a, b1, b2, y, whole = model
        n, ka, kb, kc, kd = len(axes), *law
        pick = np.concatenate([np.arange(4 * len(ka) // 4).reshape(4, -1)[i] for i in axes])
        ka, kb, kc, kd = ka[np.ix_(pick, pick)], kb[np.ix_(pick, axes)], gain * kc[np.ix_(axes, pick)], gain * kd[np.ix_(axes, axes)]
        size, states = len(a), len(a) + n * (whole + 1)
        top, store = np.zeros((size, states)), np.zeros((n * (whole + 1), states + len(ka)))
        top[:, :size], y = a, y[axes]
        command = np.zeros((n, states + len(ka)))
        command[:, :size], command[:, states:] = kd @ y, kc
        plant = np.hstack([top, np.zeros((size, len(ka)))])
        plant[:, size + n * whole:size + n * whole + n] += b1[:, axes]
        if whole:
            plant[:, size + n * (whole - 1):size + n * whole] += b2[:, axes]
        else:
            plant += b2[:, axes] @ command
        store[:n] = command
        store[n:, size:size + n * whole] = np.eye(n * whole)
        own = np.zeros((len(ka), states + len(ka)))
        own[:, :size], own[:, states:] = kb @ y, ka
        return np.log(np.max(np.abs(np.linalg.eigvals(np.vstack([plant, store, own]))))) / self.t

    def choose(self, seed):
        modes = 8
        a, b1, b2, y, whole = self.truth.sampled(modes)
        n = 2 * modes
        x = np.r_[0:modes, n:n + modes, 2 * n, 2 * n + 2, 2 * n + 4, 2 * n + 6]
        model = a[np.ix_(x, x)], b1[x], b2[x], y[:, x], whole
        cost = lambda p: max(self.growth(model, self.law(p), [0, 2], g) for g in (0.8, 1.0, 1.25))
        best = differential_evolution(cost, self.BOUNDS, seed=seed, maxiter=45, popsize=3, polish=False, tol=1e-3)
        return self.law(best.x), best.fun


def tustin(num, den, t):
    n = len(den) - 1
    num, den = np.r_[np.zeros(n + 1 - len(num)), num] / den[0], np.array(den) / den[0]
    a, b, c, d = np.vstack([-den[1:], np.eye(n)[:-1]]), np.eye(n)[:, :1], (num[1:] - den[1:] * num[0])[None], np.array([[num[0]]])
    scale = np.diag(np.abs(1 / t) ** np.arange(n))  # states of one size
    a, b, c = np.linalg.solve(scale, a) @ scale if n < 2 else scale @ a @ np.linalg.inv(scale), scale @ b, c @ np.linalg.inv(scale)
    h = np.linalg.inv(np.eye(n) - a * t / 2)
    return h @ (np.eye(n) + a * t / 2), h @ b * t, c @ h, d + c @ h @ b * t / 2


def control_at(law, hz, t, held=True):
    a, b, c, d = law
    k = c @ np.linalg.solve(np.exp(2j * np.pi * hz * t) * np.eye(len(a)) - a, b) + d
    return k * np.sinc(hz * t) if held else k


def smooth(rng, hz, size):
    """Complex relative errors of 4 channels, smooth over about a third of the band's logarithm, rms `size`."""
    t = np.log(hz / hz[0]) / np.log(hz[-1] / hz[0])
    knots = np.linspace(-0.2, 1.2, 9)
    basis = np.exp(-((t[:, None] - knots) / 0.22) ** 2)
    basis /= np.sqrt(np.sum(basis**2, axis=1, keepdims=True))
    draw = rng.normal(size=(9, 4)) + 1j * rng.normal(size=(9, 4))
    return 1 + size / np.sqrt(2) * basis @ draw


def frequency_sweep(truth, law, hz, rpm, rig, rng):
    """Coefficients (line, experiment, repeat, u then y)."""
    e, n = truth.spindle["electronics"], rig["repeats"]
    out = np.zeros((len(hz), 4, n, 8), complex)
    drive = 0.05 * truth.spindle["bearings"]["front"]["bias_current_a"]
    noise = rig["noise"] * e["sensor_noise_m"] / np.sqrt(0.25 / truth.period_s)
    cy, cu = smooth(rng, hz, rig["smooth"]), smooth(rng, hz, rig["smooth"] / 3)
    rand = lambda: (rng.normal(size=(4, n, 4)) + 1j * rng.normal(size=(4, n, 4))) / np.sqrt(2)
    for i, f in enumerate(hz):
        g = truth.plant(f, rpm)
        u = np.linalg.solve(np.eye(4) - control_at(law, f, truth.period_s) @ g, drive * np.eye(4))
        y = g @ u
        out[i, :, :, :4] = (u.T * cu[i])[:, None] + 2e-5 * drive * rig["noise"] * rand()
        out[i, :, :, 4:] = (y.T * cy[i])[:, None] + noise * rand()
        for base, size in rig.get("hum", []):
            order = max(1, round(f / base))
            leak = abs(np.sinc((f - order * base) * 0.5)) / order
            if order <= 9 and leak > 0.01:
                phase = np.exp(2j * np.pi * rng.random((4, n, 1)))
                out[i, :, :, 4:] += size * leak * phase
    return out


def time_sweep(truth, law, hz, rig, rng):
    """The loop as firmware runs it: sampled, quantised, limited, with hum and run-out; every column an experiment."""
    a, b1, b2, y, whole = truth.sampled(36)
    ka, kb, kc, kd = law
    bearing, t, c = truth.spindle["bearings"]["front"], truth.period_s, truth.cause
    steps, n = round(1 / t), rig["repeats"]
    clock = np.arange(steps) * t
    chirp = rig.get("excitation") == "chirp"
    if chirp:
        k = (hz[-1] * 1.02 - hz[0] * 0.9) / 0.96
        taper = np.clip(np.minimum(clock, 0.97 - clock) / 0.03, 0, 1)
        wave = 0.3 * np.sin(2 * np.pi * (hz[0] * 0.9 * clock + k * clock**2 / 2)) * np.sin(np.pi / 2 * taper) ** 2
    else:
        phase = rng.random(len(hz)) * 2 * np.pi
        wave = np.sum(np.cos(2 * np.pi * hz[:, None] * clock + phase[:, None]), axis=0) / np.sqrt(len(hz) / 2) * 0.12
    wave *= bearing["bias_current_a"]
    x, k, past = np.zeros((len(a), 4)), np.zeros((len(ka), 4)), [np.zeros((4, 4))] * (whole + 2)
    quantum_u, quantum_y, limit = 2 * bearing["max_current_a"] / 65536, 5e-4 / 65536, bearing["bias_current_a"]
    us, ys = np.zeros((n + 1, steps, 4, 4)), np.zeros((n + 1, steps, 4, 4))
    offset, last = rng.random((2, 4)), np.zeros((4, 4))
    for period in range(n + 1):
        noise = rig["noise"] * truth.spindle["electronics"]["sensor_noise_m"] * rng.normal(size=(steps, 4, 4))
        for base, size in rig.get("hum", []):
            for order in range(1, 6):
                w = np.sin(2 * np.pi * order * base * ((clock + period)[:, None] + offset[0] * 7)) * size / order
                noise += w[:, None, :]
        for i in range(steps):
            signal = np.round((y @ x + noise[i].T) / quantum_y) * quantum_y
            u = kc @ k + kd @ signal + np.eye(4) * wave[i]
            k = ka @ k + kb @ signal
            u = np.clip(np.round(u / quantum_u) * quantum_u, -limit, limit)
            us[period, i], ys[period, i] = u.T, signal.T
            given = u
            if c.get("effect") == "slew_limit":
                given = last + np.clip(u - last, -c["size"] * t, c["size"] * t)
            elif c.get("effect") == "current_play":
                given = last + np.sign(u - last) * np.maximum(np.abs(u - last) - c["size"], 0)
            last = given
            past = [given] + past[:-1]
            x = a @ x + b1 @ past[whole + 1] + b2 @ past[whole]
    bins = np.round(hz).astype(int)
    coefficients = [np.fft.fft(z[1:], axis=1)[:, bins] * 2 / steps for z in (us, ys)]
    return np.concatenate(coefficients, axis=3).transpose(1, 2, 0, 3)


def write_set(folder, machine, rpm, rig, cause, seed):
    """A measurement folder; gives what is hidden, or None where no controller levitates the machine."""
    spindle, tool, highest = machine
    rng = np.random.default_rng(seed)
    truth = Truth(spindle, tool, rng, rig.get("width", 1.0), cause)
    loop = Loop(truth)
    if spindle["name"] not in PIDS:
        nominal = Truth(spindle, tool, np.random.default_rng(0), 0.0, {})
        PIDS[spindle["name"]] = Loop(nominal).choose(0)[0]
    law = PIDS[spindle["name"]]
    full = loop.growth(truth.sampled(20), law, [0, 1, 2, 3])
    if full > -1.0:  # who builds the machine tunes until it flies
        law = loop.choose(seed)[0]
        full = loop.growth(truth.sampled(20), law, [0, 1, 2, 3])
    if full > -1.0:
        return None
    os.makedirs(folder, exist_ok=True)
    hz = np.unique(np.round(np.geomspace(40, highest, rig["lines"])))
    rows, records = rig.get("rows", ""), []
    for i, speed in enumerate(dict.fromkeys([0, rpm])):
        timed = rig["domain"] == "time" and speed == 0
        data = time_sweep(truth, law, hz, rig, rng) if timed else frequency_sweep(truth, law, hz, speed, rig, rng)
        header = "frequency_hz,experiment,repeat," + ",".join(f"{s}{a}_{p}" for s in "uy" for a in (1, 2, 3, 4) for p in ("re", "im"))
        with open(os.path.join(folder, f"sweep-{i}.csv"), "w") as out:
            out.write(header + "\n")
            for l, e, r in np.ndindex(data.shape[:3]):
                if (rows == "missing" and rng.random() < 0.03) or (rows == "unequal" and e and r > 0) or \
                        (rows == "half" and e % 2 and l % 2):
                    continue
                numbers = [v for z in data[l, e, r] for v in (z.real, z.imag)]
                out.write(f"{hz[l]:.4f},{e + 1},{r + 1}," + ",".join(f"{v:.8e}" for v in numbers) + "\n")
        records.append(dict(kind="sweep", file=f"sweep-{i}.csv", speed_rpm=speed, controller="k.json", **({"hold": True} if timed else {})))
    if rig.get("hammer", True):
        taps = np.unique(np.round(np.geomspace(50, highest, 70), 2))
        h = np.array([truth.compliance(f, 0, control_at(law, f, truth.period_s), 0) for f in taps])
        sd = rig["noise"] * 0.003 * np.sqrt(np.abs(h) * np.median(np.abs(h)))
        averages = 8
        coherence = 1 / (1 + averages * sd**2 / np.abs(h) ** 2)
        h = h * smooth(rng, taps, rig["smooth"])[:, 0] + sd / np.sqrt(2) * (rng.normal(size=len(h)) + 1j * rng.normal(size=len(h)))
        with open(os.path.join(folder, "hammer-0.csv"), "w") as out:
            out.write("frequency_hz,h_re,h_im,coherence,averages\n")
            for f, v, g in zip(taps, h, coherence):
                out.write(f"{f:.4f},{v.real:.8e},{v.imag:.8e},{g:.6f},{averages}\n")
        records.append(dict(kind="hammer", file="hammer-0.csv", speed_rpm=0, controller="k.json", axis="x"))
    a, b, c, d = (m.tolist() for m in law)
    json.dump(dict(name="pid", inputs=AXES, outputs=AXES, sample_time_s=truth.period_s, A=a, B=b, C=c, D=d), open(os.path.join(folder, "k.json"), "w"))
    for name, content in (("spindle", spindle), ("tool", tool), ("measurement", dict(spindle="spindle.yaml", tool="tool.yaml", records=records))):
        with open(os.path.join(folder, f"{name}.yaml"), "w") as out:
            out.write(yaml.safe_dump(content, sort_keys=False))
    hidden = dict(machine=spindle["name"], seed=seed, speed_rpm=rpm, rig=rig, cause=cause, growth_rate_per_s=round(float(full), 2),
                  off={k: np.round(v - 1, 4).tolist() for k, v in truth.off.items()})
    json.dump(hidden, open(folder + ".truth.json", "w"), indent=1)
    return hidden


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


def plan(places, detectable):
    """(name, machine, speed, rig, cause, seed, class) of every set."""
    sets, names = [], list(places)
    usual = lambda rng, **more: dict(dict(domain="frequency", repeats=int(rng.integers(1, 4)), noise=float(rng.choice([0.5, 1.0, 2.0])),
                                          smooth=float(rng.choice([0.0005, 0.001, 0.002])), lines=110), **more)
    for i, rig in enumerate(HEALTHY + [{}, {}]):
        rng = np.random.default_rng(1000 + i)
        cause = SMALL[i - len(HEALTHY)] if i >= len(HEALTHY) else {}
        sets.append((f"healthy-{i:02}", names[i % 4], 0, usual(rng, **rig), cause, 1000 + i, "nothing"))
    for i in range(24):
        rng = np.random.default_rng(2000 + i)
        machine = names[i % 4]
        entries = [larger(e, (1.2, 1.2, 2.0, 5.0)[i // 4 % 4], places[machine][0]) for e in detectable[machine]]
        by_kind = {}
        for c in filter(None, entries):
            by_kind.setdefault(c.get("named", c["effect"]), []).append(c)
        # Every kind comes about equally often; the place is drawn.
        kind = sorted(by_kind)[(5 * i + int(rng.integers(5))) % len(by_kind)]
        cause = by_kind[kind][int(rng.integers(len(by_kind[kind])))]
        domain = "time" if i % 6 == 5 else "frequency"
        wide = {16: 2.5, 17: 2.5, 18: 4.0, 19: 4.0, 20: 2.5, 21: 4.0}.get(i, 1.0)
        sets.append((f"catalogue-{i:02}", machine, 0, usual(rng, domain=domain, width=wide), cause, 2000 + i, "cause"))
    for i, law in enumerate(OUTSIDE):
        rng = np.random.default_rng(3000 + i)
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
        sets.append((f"outside-{i:02}", machine, 0, usual(rng, domain=domain), cause, 3000 + i, "outside"))
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
        return None, run.stderr.strip().splitlines()[:1], seconds
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
    arguments = parser.parse_args()
    if not os.path.exists(arguments.muspin):
        print(f"missing: {arguments.muspin}")
        sys.exit(77)
    places, detectable, rows = machines(), {}, []
    os.makedirs(arguments.out, exist_ok=True)
    for i, name in enumerate(places):
        folder = os.path.join(arguments.out, f"plain-{name}")
        if not os.path.exists(folder + ".json"):
            rig = dict(domain="frequency", repeats=2, noise=1.0, smooth=0.001, lines=110)
            write_set(folder, places[name], 0, rig, {}, 100 + i)
            diagnose(arguments.muspin, folder)
        detectable[name] = json.load(open(folder + ".json"))["diagnosis"]["detectable"]
    for name, machine, rpm, rig, cause, seed, kind in plan(places, detectable):
        if arguments.only not in name:
            continue
        folder = os.path.join(arguments.out, name)
        spindle = places[machine][0]
        if not os.path.exists(folder + ".truth.json") and write_set(folder, places[machine], rpm, rig, cause, seed) is None:
            print(name, machine, "does not levitate", flush=True)
            continue
        d, error, seconds = diagnose(arguments.muspin, folder)
        length = sum(e["length_m"] for e in spindle["rotor"]["elements"])
        off = json.load(open(folder + ".truth.json"))["off"]
        result = score(kind, cause, d, length, off) if d else "error"
        said = words(d["effects"]) if d else error
        hidden = " ".join(f"{v:.5g}" if isinstance(v, float) else str(v) for k, v in cause.items()) or "nothing"
        faults = "; ".join(f["fault"] for f in d["record_faults"]) if d else ""
        gaps = [d["gap_before"], d["gap_after"]] if d else ["", ""]
        rows.append([name, seed, machine, rig["domain"], rig.get("width", 1.0), hidden, d["verdict"] if d else "", result, said, faults,
                     *[f"{g:.2f}" if isinstance(g, float) else g for g in gaps], f"{seconds:.1f}"])
        print(*rows[-1], sep=" | ", flush=True)
    if arguments.csv:
        with open(arguments.csv, "w", newline="") as out:
            table = csv.writer(out, lineterminator="\n")
            table.writerow("set,seed,machine,domain,width,hidden,verdict,result,found,record_faults,gap_before,gap_after,seconds".split(","))
            table.writerows(rows)


if __name__ == "__main__":
    main()
