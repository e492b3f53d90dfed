"""A spindle in magnetic bearings as it is, and what a rig records of it: shaft and discs by ROSS, the rest in this file.

Magnets, amplifiers, sensors, delay, drawn errors and hidden causes make the machine (`Truth`); a PID that is chosen for it (`Loop`)
levitates it; sweeps come from the frequency domain or from firmware that runs at its sample time. Used by `open_world.py`.
"""
import json
import os

import numpy as np
import ross
import yaml
from scipy.linalg import eigh, expm
from scipy.optimize import differential_evolution

AXES = ["front_x", "front_y", "rear_x", "rear_y"]
SIDES = {"front": [0, 1], "rear": [2, 3], "both": [0, 1, 2, 3]}
PIDS = {}


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
            # Of a bearing the size says how far the number is off in all, of one axis how far beside the other axis.
            target[on] = size * (target if "axis" in cause else np.array(nominal))[on]
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
        if not np.isfinite(data).all():  # a loop that a nonlinear law drives away does not levitate
            return None
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
