"""Writes the rotor files of this folder as ROSS saves them, and frequencies.json with ROSS's own free-free whirl frequencies.

usage: python3 make.py    (in this folder; needs ross-rotordynamics, made with 2.3.0)
"""
import json
import os

import numpy as np
import ross as rs

STEEL = rs.Material(name="Steel", rho=7810, E=211e9, G_s=81.2e9)
ALLOY = rs.Material(name="Alloy_7075", rho=2810, E=71.7e9, Poisson=0.33)
SPEEDS_RPM = [0, 10000, 30000]
TO_HZ = 6000.0


def discs_and_bearings():
    """The two-disc rotor of the ROSS tutorial, on springs."""
    shaft = [rs.ShaftElement(L=0.25, idl=0, odl=0.05, material=STEEL) for _ in range(6)]
    discs = [rs.DiskElement.from_geometry(n=n, material=STEEL, width=0.07, i_d=0.05, o_d=0.28) for n in (2, 4)]
    bearings = [rs.BearingElement(n=n, kxx=1e6, kyy=1e6, cxx=1e2) for n in (0, 6)]
    return rs.Rotor(shaft, discs, bearings, tag="two discs")


def cones():
    """A hollow stepped shaft of two materials with two cones, Hutchinson's shear coefficient in one element."""
    sizes = [(0.02, 0.02, 0.012, 0.012), (0.02, 0.034, 0.012, 0.012), (0.034, 0.034, 0.012, 0.012),
             (0.05, 0.05, 0.012, 0.012), (0.05, 0.05, 0.012, 0.02), (0.044, 0.044, 0.02, 0.02), (0.03, 0.03, 0.01, 0.01)]
    shaft = [
        rs.ShaftElement(
            L=0.05, odl=a, odr=b, idl=c, idr=d, material=ALLOY if k == 6 else STEEL,
            shear_method_calc="hutchinson" if k == 3 else "cowper",
        )
        for k, (a, b, c, d) in enumerate(sizes)
    ]
    return rs.Rotor(shaft, [rs.DiskElement(n=3, m=0.4, Id=2e-4, Ip=3e-4)], tag="cones")


def magnets():
    """A spindle on two active magnetic bearings with a mass at a bearing."""
    shaft = [rs.ShaftElement(L=0.03, idl=0, odl=0.05 if 2 < k < 9 else 0.035, material=STEEL) for k in range(12)]
    magnet = dict(g0=5e-4, i0=3.0, nw=100, alpha=0.39269908, kp_pid=2e4, kd_pid=20.0)
    bearings = [rs.MagneticBearingElement(n=n, ag=ag, **magnet) for n, ag in ((3, 3e-4), (9, 1.5e-4))]
    discs = [rs.DiskElement(n=n, m=0.5, Id=2.8e-4, Ip=5.3e-4) for n in (3, 6, 9)]
    return rs.Rotor(shaft, discs, bearings, rated_w=4000.0, tag="magnets")


def beside_magnets():
    """Two magnets with integral action in a shaft with proportional damping, beside a seal, a ball bearing and a thrust pad."""
    from ross.bearings.thrust_pad import thrust_pad_example

    shaft = [rs.ShaftElement(L=0.06, idl=0, odl=0.05, material=STEEL, alpha=2.0, beta=1e-6) for _ in range(6)]
    magnet = dict(g0=5e-4, i0=3.0, nw=100, kp_pid=2e4, kd_pid=20.0, ki_pid=5e4, n_f=8e3, k_amp=0.5, k_sense=2.0, frequency=[1.0, 1e2, 1e3])
    pad = thrust_pad_example()
    pad.n = 3
    bearings = [
        rs.MagneticBearingElement(n=1, ag=3e-4, **magnet),
        rs.MagneticBearingElement(n=5, ag=1.5e-4, **magnet),
        rs.SealElement(n=4, kxx=1e5, cxx=10.0),
        rs.BallBearingElement(n=2, n_balls=8, d_balls=0.03, fs=500.0, alpha=0.5),
        pad,
    ]
    return rs.Rotor(shaft, [rs.DiskElement(n=3, m=1.0, Id=1e-3, Ip=2e-3)], bearings, tag="beside magnets")


def support_with_mass():
    """A bearing on a support with mass, and one on ground."""
    shaft = [rs.ShaftElement(L=0.1, idl=0, odl=0.05, material=STEEL) for _ in range(4)]
    bearings = [rs.BearingElement(n=0, kxx=1e6, cxx=0, n_link=5), rs.BearingElement(n=5, kxx=1e7, cxx=0), rs.BearingElement(n=4, kxx=1e6, cxx=0)]
    return rs.Rotor(shaft, [], bearings, [rs.PointMass(n=5, m=2.0)], tag="support with mass")


def frequencies(rotor, rpm):
    """Undamped whirl frequencies, Hz, of the shaft and its discs alone, with +1 forward and -1 backward, from ROSS's matrices."""
    free = rs.Rotor(rotor.shaft_elements, rotor.disk_elements)
    lateral = [6 * k + dof for k in range(len(free.nodes)) for dof in (0, 1, 3, 4)]
    pick = np.ix_(lateral, lateral)
    m, k, g = (np.asarray(x)[pick] for x in (free.M(0), free.K(0), free.G()))
    k = 0.5 * (k + k.T)
    n, speed = len(m), rpm * 2 * np.pi / 60
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(m, k), -np.linalg.solve(m, g * speed)]])
    values, vectors = np.linalg.eig(a)
    found = []
    for value, vector in zip(values, vectors.T):
        # Below a hertz: the rigid-body modes of the free rotor.
        if 2 * np.pi < value.imag < 2 * np.pi * TO_HZ:
            x, y = vector[0:n:4], vector[1:n:4]
            turn = np.sum((np.conj(x) * y).imag)
            found.append((value.imag / (2 * np.pi), 0 if rpm == 0 else int(-np.sign(turn))))
    return sorted(found)


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    answer = {"ross_version": rs.__version__, "to_hz": TO_HZ, "rotors": {}}
    for name, file, rotor in (
        ("two_discs", "two_discs.toml", discs_and_bearings()),
        ("cones", "cones.json", cones()),
        ("magnets", "magnets.toml", magnets()),
    ):
        path = os.path.join(here, file)
        if os.path.exists(path):
            os.remove(path)
        rotor.save(path)
        speeds = [{"rpm": rpm, "modes": frequencies(rotor, rpm)} for rpm in SPEEDS_RPM]
        answer["rotors"][name] = {"file": file, "mass_kg": float(rs.Rotor(rotor.shaft_elements, rotor.disk_elements).m), "speeds": speeds}
        # ROSS's modal analysis agrees with its own matrices.
        free = rs.Rotor(rotor.shaft_elements, rotor.disk_elements)
        modal = np.sort(free.run_modal(0, num_modes=400, sparse=False).wn) / (2 * np.pi)
        for hz, _ in speeds[0]["modes"]:
            assert np.min(np.abs(modal / hz - 1)) < 1e-5, (name, hz, modal)
    for file, rotor in (("beside_magnets.toml", beside_magnets()), ("support_with_mass.toml", support_with_mass())):
        path = os.path.join(here, file)
        if os.path.exists(path):
            os.remove(path)
        rotor.save(path)
    with open(os.path.join(here, "frequencies.json"), "w", encoding="utf-8") as out:
        json.dump(answer, out, indent=1)
        out.write("\n")


if __name__ == "__main__":
    main()
