"""Certified robust control on numpy arrays and python-control systems, and spindles in magnetic bearings.

Systems are given as a python-control ``StateSpace``, a tuple ``(A, B, C, D)`` or ``(A, B, C, D, dt)``. Systems are returned as
``StateSpace`` where python-control is installed, else as :class:`System`. Arguments stand in the order of python-control
and MATLAB; results are named tuples that begin with what those functions return and go on with the certificate.

Feedback is positive: u = K y. A problem without a solution raises ``ValueError`` with the reason.
"""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native, _plots
from ._native import __version__

__all__ = [
    "BalredResult", "Batch", "CareResult", "Controlled", "DareResult", "H2synResult", "HinfnormResult", "HinfsynResult", "MussvResult", "MusynResult", "NcfsynResult", "REGULARISATION",
    "Learnt", "Regularisation", "Results", "Spindle", "System", "SystemLike",
    "augw", "balred", "c2d", "care", "dare", "diskmargin", "h2norm", "h2syn", "hinfnorm", "hinfsyn", "lqg", "mixsyn", "mussv", "musyn",
    "ncfsyn", "solve",
]


#: A python-control ``StateSpace``, a :class:`System`, or a tuple ``(A, B, C, D)`` or ``(A, B, C, D, dt)``.
SystemLike = Any
#: A path or the name of a shipped file.
Source = Union[str, "os.PathLike[str]"]
_Matrices = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


class System(NamedTuple):
    """State space y = C x + D u with the state equation in A and B; ``dt`` 0 is continuous time."""

    A: NDArray[Any]
    B: NDArray[Any]
    C: NDArray[Any]
    D: NDArray[Any]
    dt: float = 0.0


class Regularisation(NamedTuple):
    """What ``regularise`` added: an error ``d12[k] * u[k]`` for each control, a disturbance of size ``d21[k]`` at each measurement."""

    d12: tuple[float, ...]
    d21: tuple[float, ...]


class HinfsynResult(NamedTuple):
    """Result of :func:`hinfsyn`."""

    K: Any
    """Controller, u = K y."""
    CL: Any
    """Closed loop of the plant as given."""
    gam: float
    """Level of the delivered controller."""
    gam_opt: float
    """Optimal level."""
    norm: float
    """Verified norm of ``CL``."""
    peak_omega: float
    """Frequency of that norm, rad/s."""
    certificate: dict[str, float]
    """Residuals and margins of the Riccati solutions, growth rate of the loop (1/s)."""
    regularised: Regularisation
    """What was added to D12 and D21; empty tuples without a perturbation."""
    norm_regularised: float
    """Norm of the loop with the perturbation; not below ``norm``."""


class MusynResult(NamedTuple):
    """Result of :func:`musyn`."""

    K: Any
    mu: float
    """Upper bound of the peak, certified over all frequencies."""
    mu_lower: float
    """Lower bound at ``peak_omega``, rad/s."""
    peak_omega: float
    iterations: list[tuple[float, float, int]]
    """(gamma, mu, order of the controller) of each iteration."""
    CL: Any
    """Closed loop of the plant as given."""
    regularised: Regularisation
    """What was added to D12 and D21; ``mu`` holds for the plant as given as well."""


class MussvResult(NamedTuple):
    """Result of :func:`mussv`."""

    upper: Any
    lower: Any
    delta: NDArray[Any]
    """Perturbation that attains the lower bound."""


class HinfnormResult(NamedTuple):
    """Result of :func:`hinfnorm`."""

    norm: float
    """Attained at ``peak_omega``."""
    peak_omega: float
    upper: float
    """Level that no frequency reaches."""


class CareResult(NamedTuple):
    """Result of :func:`care`."""

    X: NDArray[Any]
    L: NDArray[Any]
    """Closed-loop poles."""
    G: NDArray[Any]
    """Gain."""
    residual: float
    """Relative residual, in doubled precision."""
    closed_loop_max_real: float


class BalredResult(NamedTuple):
    """Result of :func:`balred`."""

    sys: Any
    error: float
    """H-infinity norm of full minus reduced."""
    method: str
    hsv: NDArray[Any]


def _is_masked(value: Any) -> bool:
    """Whether an entry is masked, in an array or in a list of arrays; numpy drops such a mask without a word."""
    return bool(np.ma.is_masked(value)) or (isinstance(value, (list, tuple)) and any(map(_is_masked, value)))


def _array(value: ArrayLike, name: str, complex_values: bool = False) -> NDArray[Any]:
    if _is_masked(value):
        raise ValueError(f"{name} has masked entries: fill them or leave their rows and columns out")
    try:
        found: NDArray[Any] = np.array(value, ndmin=2, order="C")
        if np.iscomplexobj(found) and not complex_values:
            if np.any(found.imag != 0.0):
                raise ValueError("real numbers are expected, found an imaginary part that is not zero")
            found = found.real
        found = np.array(found, dtype=complex if complex_values else float, order="C")
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be a matrix of numbers: {error}") from error
    if found.ndim != 2:
        raise ValueError(f"{name} must be a matrix, found an array with {found.ndim} indices")
    return found


def _matrices(sys: SystemLike) -> tuple[_Matrices, float]:
    """((A, B, C, D), dt) of anything that is a system."""
    if hasattr(sys, "num") and hasattr(sys, "den") and not hasattr(sys, "A"):
        from control import ss

        sys = ss(sys)
    e = getattr(sys, "E", None)
    if e is not None and not callable(e) and np.size(e) > 0:
        e = _array(e, "E")
        if e.shape[0] != e.shape[1] or not np.array_equal(e, np.eye(e.shape[0])):
            raise ValueError("a descriptor system (E is not the identity) is not taken: multiply A and B by the inverse of E")
    if hasattr(sys, "A") and hasattr(sys, "dt"):
        parts: Sequence[Any] = (sys.A, sys.B, sys.C, sys.D)
        dt = sys.dt
    elif isinstance(sys, (tuple, list)) and len(sys) in (4, 5):
        parts, dt = sys[:4], (sys[4] if len(sys) == 5 else 0)
    else:
        raise ValueError("a system is a StateSpace or a tuple (A, B, C, D) or (A, B, C, D, dt)")
    if dt is not None and np.ndim(dt) != 0:
        raise ValueError("the fifth entry of a system is its sample time in seconds, found a matrix")
    if dt is True:
        raise ValueError("the sample time of the system is not said; give dt in seconds")
    a, b, c, d = (_array(part, name) for part, name in zip(parts, "ABCD"))
    if a.size == 0:
        # A static gain: empty lists carry no shape.
        a, b, c = np.zeros((0, 0)), np.zeros((0, d.shape[1])), np.zeros((d.shape[0], 0))
    (n, k), (p, m) = a.shape, d.shape
    if n != k or b.shape != (n, m) or c.shape != (p, n):
        raise ValueError(
            f"A is {n} x {k}, B {b.shape[0]} x {b.shape[1]}, C {c.shape[0]} x {c.shape[1]}, D {p} x {m}: "
            "A must be n x n, B n x m, C p x n, D p x m"
        )
    return (a, b, c, d), float(dt or 0.0)


def _continuous(sys: SystemLike, what: str) -> _Matrices:
    parts, dt = _matrices(sys)
    if dt != 0.0:
        raise ValueError(f"{what} takes a system in continuous time, found dt = {dt}")
    return parts


def _in_plane(parts: _Matrices, dt: float) -> _Matrices:
    """The system in the plane of the solvers: s = (2/dt)(z - 1)/(z + 1) of a sampled one, where norms and mu are the same."""
    return parts if dt == 0.0 else _native.to_w_plane(parts, dt)


def _from_plane(parts: _Matrices, dt: float) -> _Matrices:
    return parts if dt == 0.0 else _native.from_w_plane(parts, dt)


def _true_frequency(omega: float, dt: float) -> float:
    return omega if dt == 0.0 else 2.0 / dt * float(np.arctan(0.5 * dt * omega))


def _system(parts: _Matrices, dt: float = 0.0, inputs: list[str] | None = None, outputs: list[str] | None = None) -> Any:
    try:
        from control import StateSpace  # type: ignore[import-untyped,import-not-found,unused-ignore]
    except ImportError:
        return System(*parts, dt)
    return StateSpace(*parts, dt, remove_useless_states=False, inputs=inputs, outputs=outputs)


def _closed(plant: _Matrices, controller: _Matrices, nmeas: int, ncon: int) -> _Matrices:
    """The loop of a generalized plant with u = K y."""
    a, b, c, d = plant
    ak, bk, ck, dk = controller
    m1, p1 = b.shape[1] - ncon, c.shape[0] - nmeas
    b1, b2, c1, c2 = b[:, :m1], b[:, m1:], c[:p1], c[p1:]
    d11, d12, d21, d22 = d[:p1, :m1], d[:p1, m1:], d[p1:, :m1], d[p1:, m1:]
    # u = E (Dk C2 x + Ck xk + Dk D21 w), E = (I - Dk D22)^-1
    e = np.linalg.inv(np.eye(ncon) - dk @ d22)
    ux, uk, uw = e @ dk @ c2, e @ ck, e @ dk @ d21
    yx, yk, yw = c2 + d22 @ ux, d22 @ uk, d21 + d22 @ uw
    return (
        np.block([[a + b2 @ ux, b2 @ uk], [bk @ yx, ak + bk @ yk]]),
        np.vstack([b1 + b2 @ uw, bk @ yw]),
        np.hstack([c1 + d12 @ ux, d12 @ uk]),
        d11 + d12 @ uw,
    )


#: Share of the gains that ``regularise=True`` adds.
REGULARISATION: float = _native.REGULARISATION


def _share(regularise: bool | float | None) -> float | None:
    """The share of the gains that a regularisation adds, or none."""
    if regularise is True:
        return REGULARISATION
    return None if regularise is False or regularise is None else float(regularise)


def _count(value: Any, name: str) -> int:
    """A whole number that is at least one."""
    if isinstance(value, bool) or int(value) != value or value < 1:
        raise ValueError(f"{name} = {value!r} must be a whole number of at least 1")
    return int(value)


def hinfsyn(
    P: SystemLike, nmeas: int, ncon: int, gamma: float | None = None, regularise: bool | float = False
) -> HinfsynResult:
    """H-infinity synthesis for the generalized plant ``P`` with ``nmeas`` measurements and ``ncon`` controls last.

    Parameters
    ----------
    P : system in continuous time or sampled
    nmeas, ncon : int
    gamma : float, optional
        Level of the central controller; the optimum is searched for unless it is given.
    regularise : bool or float
        Where D12 (D21) lacks rank, gives each control an error (each measurement a disturbance) of this share of its largest
        gain over frequency; True is ``REGULARISATION``. A plant that meets the assumptions is left as it is.

    Returns
    -------
    HinfsynResult
        ``K, CL, gam, gam_opt, norm, peak_omega, certificate, regularised, norm_regularised``. ``gam`` is a level of the plant
        with what was added, ``norm`` the norm of the loop of the plant as given.

    Raises
    ------
    ValueError
        An assumption fails or no level is feasible; the message names it and says what to do.
    """
    plant, dt = _matrices(P)
    nmeas, ncon = _count(nmeas, "nmeas"), _count(ncon, "ncon")
    level = None if gamma is None else float(gamma)
    share, image = _share(regularise), _in_plane(plant, dt)
    k, gam, best, (norm, omega), posed, certificate, added = _native.hinfsyn(image, nmeas, ncon, level, share)
    k = _from_plane(k, dt)
    loop = _closed(plant, k, nmeas, ncon)
    if dt != 0.0:
        norm, omega, _ = _native.hinfnorm(loop, dt)
        gam = max(gam, norm)
    size = Regularisation(*map(tuple, added))
    return HinfsynResult(_system(k, dt), _system(loop, dt), gam, best, norm, omega, dict(certificate), size, posed)


def _blocks(structure: ArrayLike) -> list[tuple[str, int, int]]:
    """MATLAB's rows: [r, c] full complex r by c block of Delta, [-r, 0] real repeated, [r, 0] complex repeated."""
    rows = np.array(structure)
    if rows.ndim != 2 or rows.shape[1] != 2 or rows.shape[0] == 0 or not np.all(rows == np.floor(rows.astype(float))):
        raise ValueError("blocks must be rows of two whole numbers, one row for each block")
    found = []
    for row in rows:
        r, c = int(row[0]), int(row[1])
        if r < 0 and (c == 0 or (r, c) == (-1, 1)):
            found.append(("real_scalar", -r, -r))
        elif c == 0 and r > 0:
            found.append(("complex_scalar", r, r))
        elif r > 0 and c > 0:
            found.append(("complex_full", r, c))
        else:
            raise ValueError(f"block [{r}, {c}]: [r, c] full complex, [r, 0] repeated complex, [-r, 0] repeated real")
    return found


def musyn(
    P: SystemLike,
    nmeas: int,
    ncon: int,
    blocks: ArrayLike,
    max_iterations: int | None = None,
    regularise: bool | float = False,
) -> MusynResult:
    """D-K iteration for the generalized plant ``P``.

    ``blocks`` are rows as those of :func:`mussv`, the performance block last; together they have as many rows as ``P``
    has disturbances and as many columns as it has errors. ``regularise`` as in :func:`hinfsyn`; the performance block grows by
    what is added, and ``mu`` bounds the plant as given. Returns a :class:`MusynResult`; takes seconds to minutes.
    """
    plant, dt = _matrices(P)
    nmeas, ncon = _count(nmeas, "nmeas"), _count(ncon, "ncon")
    most = None if max_iterations is None else _count(max_iterations, "max_iterations")
    channels, share = (nmeas, ncon), _share(regularise)
    k, upper, lower, omega, steps, added = _native.musyn(_in_plane(plant, dt), channels, _blocks(blocks), most, share)
    k, omega = _from_plane(k, dt), _true_frequency(omega, dt)
    loop = _system(_closed(plant, k, nmeas, ncon), dt)
    return MusynResult(_system(k, dt), upper, lower, omega, steps, loop, Regularisation(*map(tuple, added)))


def mussv(M: ArrayLike, blocks: ArrayLike) -> MussvResult:
    """Bounds of the structured singular value of the complex matrix ``M``.

    ``blocks`` has a row for each block: ``[r, c]`` a full complex block that reads c rows of M and feeds r columns, ``[r, 0]``
    a repeated complex scalar, ``[-r, 0]`` a repeated real one. Returns a :class:`MussvResult`; of a stack of matrices
    (lines x rows x columns) its values are arrays over the lines.
    """
    if np.ndim(M) == 3:
        lines = [_native.mussv(_array(line, "M", complex_values=True), _blocks(blocks)) for line in np.asarray(M)]
        upper, lower, delta = (np.array(values) for values in zip(*lines))
        return MussvResult(upper, lower, delta)
    matrix = _array(M, "M", complex_values=True)
    return MussvResult(*_native.mussv(matrix, _blocks(blocks)))


def hinfnorm(sys: SystemLike) -> HinfnormResult:
    """H-infinity norm of a stable system, continuous or sampled: value, frequency in rad/s, certified upper bound."""
    parts, dt = _matrices(sys)
    return HinfnormResult(*_native.hinfnorm(parts, dt))


def care(
    A: ArrayLike,
    B: ArrayLike,
    Q: ArrayLike,
    R: ArrayLike | None = None,
    S: ArrayLike | None = None,
    E: ArrayLike | None = None,
) -> CareResult:
    """Stabilising solution of A'XE + E'XA - (E'XB + S) R^-1 (B'XE + S') + Q = 0, arguments as python-control has them.

    ``E`` has an inverse; without it the identity.

    Returns a :class:`CareResult`; raises ValueError where there is no stabilising solution, with the reason.
    """
    a, b, q = _array(A, "A"), _array(B, "B"), _array(Q, "Q")
    n, m = b.shape
    r = np.eye(m) if R is None else _array(R, "R")
    s = np.zeros_like(b) if S is None else _array(S, "S")
    e = np.eye(n) if E is None else _array(E, "E")
    shapes = (("A", a, (n, n)), ("Q", q, (n, n)), ("R", r, (m, m)), ("S", s, (n, m)), ("E", e, (n, n)))
    for name, found, shape in shapes:
        if found.shape != shape:
            raise ValueError(f"{name} is {found.shape}, but B has the shape {b.shape}: expected {shape}")
        if not np.all(np.isfinite(found)):
            raise ValueError(f"{name} holds NaN or infinity")
    for name, found in (("Q", q), ("R", r)):
        if not np.allclose(found, found.T, rtol=1e-10, atol=0.0):
            raise ValueError(f"{name} is not symmetric")
    if E is not None:
        if np.linalg.cond(e) > 1e8:
            raise ValueError("E is singular or nearly so: half the digits of the answer would be lost")
        # With E^-1 A and E^-1 B the solution is E'XE.
        a, b = np.linalg.solve(e, a), np.linalg.solve(e, b)
    try:
        inner = np.linalg.solve(r, np.hstack([b.T, s.T]))
    except np.linalg.LinAlgError as error:
        raise ValueError("R is singular") from error
    rb, rs = inner[:, :n], inner[:, n:]
    g = b @ rb
    shifted = q - s @ rs
    x, residual, growth = _native.care(a - b @ rs, 0.5 * (g + g.T), 0.5 * (shifted + shifted.T))
    gain = rb @ x + rs
    poles = np.linalg.eigvals(a - b @ gain)
    if E is not None:
        x = np.linalg.solve(e.T, np.linalg.solve(e.T, x).T)
    return CareResult(x, poles, gain, residual, growth)


_METHODS = {None: None, "truncate": "balanced_truncation", "matchdc": "singular_perturbation"}


def balred(
    sys: SystemLike, orders: int | Sequence[int], method: str | None = None
) -> BalredResult | list[BalredResult]:
    """Reduction to ``orders`` states by balancing; poles that are not stable are kept.

    ``method`` is ``"truncate"`` or ``"matchdc"``; without it the one with the smaller H-infinity error. A list of orders gives
    a list of :class:`BalredResult`.
    """
    if method not in _METHODS:
        raise ValueError(f"method {method!r}: 'truncate' or 'matchdc'")
    given, dt = _matrices(sys)
    plant = _in_plane(given, dt)

    def one(order: Any) -> BalredResult:
        if int(order) != order or order < 0:
            raise ValueError(f"orders: {order!r} must be a whole number of at least 0")
        parts, error, used, hsv = _native.balred(plant, int(order), _METHODS[method])
        return BalredResult(_system(_from_plane(parts, dt), dt), error, used, np.array(hsv))

    return [one(order) for order in orders] if isinstance(orders, (list, tuple, np.ndarray)) else one(orders)


_RULES = ("zoh", "foh", "tustin", "impulse", "matched")


def c2d(
    sys: SystemLike, Ts: float, method: str = "zoh", prewarp_frequency: float | None = None, input_delay: float = 0.0
) -> Any:
    """Sampled system for the sample time ``Ts`` in seconds.

    ``method`` is 'zoh', 'foh' (input straight from sample to sample), 'tustin' or 'bilinear' (the same), 'impulse' (no
    feedthrough) or 'matched' (one input and output). With ``prewarp_frequency`` in rad/s Tustin's rule keeps the response there
    exactly. ``input_delay`` in seconds is exact for 'zoh'; other rules take whole samples.
    """
    plant = _continuous(sys, "c2d")
    rule = "tustin" if method == "bilinear" else method
    if rule not in _RULES:
        raise ValueError(f"method {method!r}: {', '.join(_RULES)} or bilinear")
    given: dict[str, Any] = {"Ts": float(Ts), "input_delay_s": float(input_delay)}
    if prewarp_frequency is not None:
        if rule != "tustin":
            raise ValueError("prewarp_frequency belongs to the method 'tustin'")
        rule, given["w_prewarp"] = "tustin_prewarp", float(prewarp_frequency)
    found = solve("discretise", **_data(plant), **given)
    if rule not in found:
        raise ValueError("; ".join(note for note in found["notes"] if rule in note or "input_delay_s" in note))
    return _found(found[rule], float(Ts))


def solve(kind: str, **data: Any) -> dict[str, Any]:
    """The answer of ``muspin solve kind`` to the fields ``data``: numbers, arrays, and dictionaries of them.

    ``muspin schema solve-KIND`` lists the fields. Raises ValueError with the reason where there is no answer.
    """

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: plain(part) for key, part in value.items()}
        if isinstance(value, (list, tuple)):
            return [plain(part) for part in value]
        return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value

    given = {key: plain(value) for key, value in data.items() if value is not None}
    answer: dict[str, Any] = json.loads(_native.solve(str(kind), json.dumps(given)))
    return answer


def _data(parts: _Matrices) -> dict[str, Any]:
    return dict(zip("ABCD", parts))


def _found(answer: dict[str, Any], dt: float = 0.0) -> Any:
    """A system of an answer."""
    d = np.array(answer["D"], dtype=float)
    n = len(answer["A"])
    a, b, c = (np.array(answer[key], dtype=float) for key in "ABC")
    return _system((a.reshape(n, n), b.reshape(n, d.shape[1]), c.reshape(d.shape[0], n), d), dt)


class DareResult(NamedTuple):
    """Result of :func:`dare`."""

    X: NDArray[Any]
    L: NDArray[Any]
    """Closed-loop poles."""
    G: NDArray[Any]
    """Gain."""
    residual: float
    """Relative residual, in doubled precision."""


def dare(
    A: ArrayLike, B: ArrayLike, Q: ArrayLike, R: ArrayLike | None = None, S: ArrayLike | None = None, E: ArrayLike | None = None
) -> DareResult:
    """Stabilising solution of A'XA - E'XE - (A'XB + S)(R + B'XB)^-1(B'XA + S') + Q = 0, arguments as python-control has them."""
    given = {name: _array(value, name) for name, value in zip("ABQRSE", (A, B, Q, R, S, E)) if value is not None}
    found = solve("dare", **given)
    poles = np.array(found["closed_loop_poles"]["re"]) + 1j * np.array(found["closed_loop_poles"]["im"])
    return DareResult(np.array(found["X"]), poles, np.array(found["F"]), found["residual"])


def h2norm(sys: SystemLike) -> float:
    """H2 norm of a stable system, continuous (without feedthrough) or sampled."""
    parts, dt = _matrices(sys)
    return float(solve("h2norm", **_data(parts), Ts=dt)["norm"])


class H2synResult(NamedTuple):
    """Result of :func:`h2syn` and :func:`lqg`."""

    K: Any
    """Controller, u = K y."""
    norm: float
    """H2 norm of the loop, by its gramian."""
    norm_opt: float
    """The same by the Riccati equations."""
    F: NDArray[Any]
    """u = -F x of the measured state."""
    L: NDArray[Any]
    """Gain of the predicting observer."""


def _h2(found: dict[str, Any], dt: float) -> H2synResult:
    gains = (np.array(found[key], dtype=float) for key in "FL")
    return H2synResult(_found(found["controller"], dt), found["norm"], found["norm_opt"], *gains)


def h2syn(P: SystemLike, nmeas: int, ncon: int) -> H2synResult:
    """H2 synthesis for the generalized plant ``P`` with ``nmeas`` measurements and ``ncon`` controls last; also sampled."""
    parts, dt = _matrices(P)
    p2, m2 = _count(nmeas, "nmeas"), _count(ncon, "ncon")
    sizes = {"m1": parts[3].shape[1] - m2, "m2": m2, "p1": parts[3].shape[0] - p2, "p2": p2}
    if min(sizes.values()) < 1:
        raise ValueError("nmeas and ncon leave no errors or no disturbances of the plant")
    return _h2(solve("h2syn", **_data(parts), **sizes, Ts=dt), dt)


def lqg(
    sys: SystemLike, Q: ArrayLike, R: ArrayLike, W: ArrayLike, V: ArrayLike, S: ArrayLike | None = None, WV: ArrayLike | None = None
) -> H2synResult:
    """LQG: cost x'Qx + 2x'Su + u'Ru, noise of covariance W on the states, V on the measurements, WV across; also sampled."""
    parts, dt = _matrices(sys)
    weights = {name: _array(value, name) for name, value in zip(("Q", "R", "W", "V"), (Q, R, W, V))}
    cross = {name: _array(value, name) for name, value in (("S", S), ("WV", WV)) if value is not None}
    return _h2(solve("lqg", **_data(parts), **weights, **cross, Ts=dt), dt)


class NcfsynResult(NamedTuple):
    """Result of :func:`ncfsyn`."""

    K: Any
    """Controller W1 Kinf W2, u = K y."""
    gam: float
    """Level of the controller."""
    emax: float
    """Margin of the shaped plant, 1/gam of the optimum."""
    norm: float
    """Verified norm of the loop."""


def _weights(plant: SystemLike, **weights: SystemLike | None) -> tuple[dict[str, Any], float]:
    """G and weights as fields of a problem, and their sample time; a number or a matrix is a gain."""
    parts, dt = _matrices(plant)
    given: dict[str, Any] = {"G": _data(parts)}
    for name, weight in weights.items():
        if weight is None:
            continue
        if hasattr(weight, "A") or isinstance(weight, (tuple, list)):
            own, base = _matrices(weight)
            if base != dt and own[0].size > 0:
                raise ValueError(f"{name} has dt = {base}, the plant {dt}")
            given[name] = _data(own)
        else:
            given[name] = _array(weight, name)
    return given, dt


def ncfsyn(G: SystemLike, W1: SystemLike | None = None, W2: SystemLike | None = None) -> NcfsynResult:
    """Loop shaping by normalised coprime factors (Glover-McFarlane) of W2 G W1; positive feedback, u = K y; also sampled."""
    given, dt = _weights(G, W1=W1, W2=W2)
    found = solve("ncfsyn", **given, Ts=dt)
    return NcfsynResult(_found(found["controller"], dt), found["gamma"], found["margin"], found["closed_loop_norm"])


def diskmargin(L: SystemLike, skew: float | Sequence[float] = 0.0, sign: int = -1) -> dict[str, Any]:
    """Disc margins of the loop ``L`` in negative feedback (``sign`` 1: positive), per channel and of all at once; also sampled.

    Returns ``channels`` (for each a list over the skews) and ``multiloop``, dictionaries with alpha, gain_margin, phase_margin_deg.
    """
    parts, dt = _matrices(L)
    return solve("diskmargin", **_data(parts), Ts=dt, skew=[float(s) for s in np.atleast_1d(skew)], sign=int(sign))


def augw(
    G: SystemLike, W1: SystemLike | None = None, W2: SystemLike | None = None, W3: SystemLike | None = None
) -> Any:
    """Generalized plant of mixed sensitivity, (w, u) to (W1 e, W2 u, W3 G u, e) with e = w - G u; also sampled."""
    given, dt = _weights(G, W1=W1, W2=W2, W3=W3)
    return _found(solve("augw", **given, Ts=dt), dt)


def mixsyn(
    G: SystemLike, W1: SystemLike | None = None, W2: SystemLike | None = None, W3: SystemLike | None = None
) -> HinfsynResult:
    """H-infinity synthesis of mixed sensitivity: :func:`hinfsyn` of :func:`augw`."""
    plant = augw(G, W1, W2, W3)
    (_, _, _, d), _ = _matrices(G)
    return hinfsyn(plant, d.shape[0], d.shape[1])


#: Axes of sensors and magnets, and of the places of forces and displacements, in the order of the plant's signals.
_AXES = ("front_x", "front_y", "rear_x", "rear_y")
_PLACES = ("tool_x", "tool_y", "front_actuator_x", "front_actuator_y", "rear_actuator_x", "rear_actuator_y")
_CURRENTS = [f"current_{axis}" for axis in _AXES]
_SENSORS = [f"sensor_{axis}" for axis in _AXES]
_PLANT_INPUTS = _CURRENTS + [f"force_{place}" for place in _PLACES]
_PLANT_OUTPUTS = _SENSORS + [f"displacement_{place}" for place in _PLACES]


def _table(text: str) -> dict[str, Any]:
    """Columns of a CSV text: arrays of numbers, lists of words where a column holds words."""
    rows = list(csv.reader(io.StringIO(text)))
    columns: dict[str, Any] = {}
    for name, *cells in zip(*rows):
        try:
            columns[name] = np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            columns[name] = cells
    return columns


@dataclass(frozen=True)
class Results:
    """What a stage of a spindle found. Its first two values, the answer and the figures, can be unpacked."""

    figures: dict[str, Any]
    """The figures of ``summary.json``."""
    _native: Any = field(repr=False)

    @property
    def met(self) -> bool | None:
        """Whether every target is met; None where the stage has none."""
        return self.figures.get("verdict", {}).get("met")

    @property
    def sentence(self) -> str:
        """The verdict in a sentence."""
        return str(self.figures.get("verdict", {}).get("sentence", ""))

    @property
    def files(self) -> list[str]:
        """Paths of the files that :meth:`write` writes."""
        return list(self._native.names())

    def read(self, file: str) -> bytes:
        """The bytes of one of :attr:`files`."""
        found = self._native.file(file)
        if found is None:
            raise ValueError(f"{file!r} is none of {', '.join(self.files)}")
        return bytes(found)

    @property
    def tables(self) -> dict[str, dict[str, Any]]:
        """Every table by its path without ``.csv``, as columns: ``pandas.DataFrame(results.tables[name])``."""
        names = [name for name in self.files if name.endswith(".csv")]
        return {name[:-4]: _table(self.read(name).decode()) for name in names}

    @property
    def pictures(self) -> list[str]:
        """Names of what :meth:`plot` draws: the pictures of the page that have a table and axes."""
        drawn = [file[6:-4] for file in self.files if file.startswith("plots/") and file.endswith(".svg")]
        return [name for name in drawn if f"plots/{name}.csv" in self.files and b"<metadata>" in self.read(f"plots/{name}.svg")]

    def plot(self, picture: str) -> Any:
        """A picture of the page as a matplotlib ``Figure``: the same numbers, axes and colours; ImportError without matplotlib."""
        if picture not in self.pictures:
            raise ValueError(f"picture {picture!r} is none of {', '.join(self.pictures) or 'those of this stage, which has none'}")
        table, drawn = (self.read(f"plots/{picture}.{ending}").decode() for ending in ("csv", "svg"))
        return _plots.draw(table, drawn)

    def write(self, folder: Source) -> None:
        """Writes tables, pictures and ``report.html`` as the command does, whole or not at all; nothing foreign is replaced."""
        self._native.write(os.fspath(folder))


@dataclass(frozen=True)
class Controlled(Results):
    """A controller with its figures."""

    K: Any = None
    """Sampled, u = K y; positive feedback, sensors (m) to currents (A)."""

    def __iter__(self) -> Iterator[Any]:
        return iter((self.K, self.figures))


@dataclass(frozen=True)
class Learnt(Results):
    """A machine that was learnt from a measurement, with the figures."""

    spindle: Any = None
    """The updated or corrected :class:`Spindle`."""

    def __iter__(self) -> Iterator[Any]:
        return iter((self.spindle, self.figures))


@dataclass(frozen=True)
class Batch:
    """A run for each tool."""

    rows: list[dict[str, Any]]
    """One row a tool, nested as in ``row.json``; ``failure`` says why a tool has no figures."""
    results: dict[str, Results]
    """Pages, controllers and figures by the name of the tool."""

    @property
    def table(self) -> dict[str, list[Any]]:
        """The plain figures of the rows as columns, for pandas."""
        plain = {key for row in self.rows for key, value in row.items() if not isinstance(value, (dict, list))}
        names = [key for row in self.rows for key in row if key in plain]
        return {name: [row.get(name) for row in self.rows] for name in dict.fromkeys(names)}


def _figures(native: Any) -> tuple[dict[str, Any], Any]:
    return json.loads(native.figures()), native


def _source(given: Any) -> str:
    """A path or a name as it is; a mapping as JSON, which every reader of YAML takes."""
    return json.dumps(given) if isinstance(given, Mapping) else os.fspath(given)


def _controller(given: Any) -> str:
    """A controller as a path or as the JSON of its file."""
    if isinstance(given, Controlled):
        given = given.K
    if isinstance(given, (str, os.PathLike, Mapping)):
        return _source(given)
    (a, b, c, d), dt = _matrices(given)
    parts = {name: part.tolist() for name, part in zip("ABCD", (a, b, c, d))}
    name = str(getattr(given, "name", None) or "controller")
    return json.dumps({"name": name, "inputs": _AXES, "outputs": _AXES, "sample_time_s": dt, **parts})


def _sampled(text: str) -> Any:
    found = json.loads(text)
    parts = tuple(np.array(found[key], dtype=float) for key in "ABCD")
    return _system(parts, found["sample_time_s"], _SENSORS, _CURRENTS)  # type: ignore[arg-type]


def _speeds(rpm: Any) -> list[float] | None:
    return None if rpm is None else [float(speed) for speed in np.atleast_1d(rpm)]


class Spindle:
    """A spindle with its tool. It can be copied and pickled; its stages return :class:`Results`."""

    def __init__(self, machine: _native.Machine) -> None:
        self._machine = machine

    @classmethod
    def load(cls, spindle: Source | Mapping[str, Any] = "reference", tool: Source | Mapping[str, Any] | None = None) -> Spindle:
        """Reads a spindle and a tool: paths, names of shipped files, or dictionaries with the keys of the files; ``"none"`` is
        no tool. Without ``tool`` that is what a spindle with ``output_m`` has, others have the paper's."""
        if not isinstance(spindle, Mapping) and not isinstance(tool, Mapping):
            return cls(_native.Machine.load(os.fspath(spindle), None if tool is None else os.fspath(tool)))
        if tool is None:
            tool = "none" if isinstance(spindle, Mapping) and spindle.get("output_m") is not None else "paper-tool"
        text = [
            json.dumps(given) if isinstance(given, Mapping) else _native.Machine.text(kind, os.fspath(given))
            for kind, given in (("spindle", spindle), ("tool", tool))
        ]
        return cls(_native.Machine.read(*text))

    def __reduce__(self) -> tuple[Any, ...]:
        return (_restored, self._machine.files())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Spindle) and self._machine.files() == other._machine.files()

    def __hash__(self) -> int:
        return hash(self._machine.files())

    def __repr__(self) -> str:
        return "<Spindle {} with {}>".format(*self._machine.names())

    @property
    def name(self) -> str:
        """Name of the spindle."""
        return self._machine.names()[0]

    @property
    def tool(self) -> str:
        """Name of the tool."""
        return self._machine.names()[1]

    @property
    def max_rpm(self) -> float:
        """Top speed, 1/min."""
        return self._machine.max_rpm()

    def with_tool(self, tool: Source | Mapping[str, Any]) -> Spindle:
        """The same spindle with another tool."""
        text = json.dumps(tool) if isinstance(tool, Mapping) else _native.Machine.text("tool", os.fspath(tool))
        return Spindle(_native.Machine.read(self._machine.files()[0], text))

    def plant(self, rpm: float = 0.0, pade_order: int = 2) -> Any:
        """The design model: currents of front_x, front_y, rear_x, rear_y (A) and forces at the tool in x, y (N), then four loads
        at the bearings, to displacements in the same order (m); the delay as a Padé approximant. Its signals have names:
        ``current_front_x``, ``force_tool_x`` to ``sensor_front_x``, ``displacement_tool_x``."""
        if int(pade_order) != pade_order or pade_order < 0:
            raise ValueError(f"pade_order = {pade_order!r} must be a whole number of at least 0")
        return _system(self._machine.plant(float(rpm), int(pade_order)), 0.0, _PLANT_INPUTS, _PLANT_OUTPUTS)

    def response(self, omega: ArrayLike, rpm: float = 0.0) -> Any:
        """Response of the full finite-element model with exact delay at ``omega`` in rad/s: lines x 6 outputs x 6 inputs, four
        axes and the two directions of the tool plane. A ``xarray.DataArray`` with named signals where xarray is installed."""
        lines = [float(w) for w in np.atleast_1d(omega)]
        found = self._machine.response(lines, float(rpm))
        try:
            from xarray import DataArray  # type: ignore[import-untyped,import-not-found,unused-ignore]
        except ImportError:
            return found
        labels = {"omega": lines, "output": _PLANT_OUTPUTS[:6], "input": _PLANT_INPUTS[:6]}
        return DataArray(found, coords=labels, dims=list(labels), name="response", attrs={"rpm": float(rpm)})

    def modes(self, rpm: ArrayLike = 0.0) -> dict[str, Any]:
        """Inertia and natural frequencies of the free rotor at speeds, as ``muspin modes --json`` has them."""
        return dict(json.loads(self._machine.modes(_speeds(rpm) or [])))

    def identify(self, measurement: Source) -> Results:
        """Plausibility, resonances and antiresonances of a measurement folder; the responses are tables."""
        return Results(*_figures(self._machine.identify(os.fspath(measurement))))

    def update(self, measurement: Source) -> Learnt:
        """The spindle whose moduli have the frequencies of a measurement folder."""
        machine, native = self._machine.update(os.fspath(measurement))
        return Learnt(*_figures(native), spindle=Spindle(machine))

    def design(
        self,
        weights: Source | Mapping[str, Any] = "benchmark",
        polish: bool = True,
        progress: Callable[[str], Any] | None = None,
    ) -> Controlled:
        """The sampled controller that meets weights (a file, a shipped name, a dictionary); minutes.

        ``progress`` is called with a few words whenever a step or a stage has ended; an exception in it ends the design."""
        controller, native = self._machine.design(_source(weights), bool(polish), progress)
        return Controlled(*_figures(native), K=_sampled(controller))

    def pid(self, numbers: Source | Mapping[str, Any] | None = None, rpm: ArrayLike | None = None, seed: int = 1) -> Controlled:
        """A PID: tuned within the usual amplifier limits, or with the ``numbers`` of a file or dictionary."""
        given = None if numbers is None else _source(numbers)
        controller, native = self._machine.pid(given, _speeds(rpm), int(seed))
        return Controlled(*_figures(native), K=_sampled(controller))

    def compare(
        self, *controllers: Any, weights: Source | Mapping[str, Any] = "benchmark", rpm: ArrayLike | None = None
    ) -> Results:
        """Stiffness, sensitivity, stability over speed and worst cases of controllers (systems, files, results of
        :meth:`design` and :meth:`pid`) side by side; without any, the design for the weights and its PIDs."""
        given = [_controller(one) for one in controllers]
        return Results(*_figures(self._machine.compare(given, _source(weights), _speeds(rpm))))

    def simulate(
        self,
        controller: Any,
        case: str = "impulse",
        *,
        rpm: float | None = None,
        force: float | None = None,
        push: float | None = None,
        grade: float | None = None,
        duration: float | None = None,
        ramp: float | None = None,
        bus_voltage: float | None = None,
        noise_seed: int | None = None,
    ) -> Results:
        """Time response with force law, limits and clearance; ``case`` is impulse, step, unbalance, lift-off or contact.

        1/min, N, s, m/s, V; what is not given is as in ``muspin simulate``. The table ``response`` has every sample."""
        named = {"rpm": rpm, "force": force, "push": push, "grade": grade, "duration": duration, "ramp": ramp, "bus_voltage": bus_voltage}
        options = {name: float(value) for name, value in named.items() if value is not None}
        return Results(*_figures(self._machine.simulate(_controller(controller), case, options, noise_seed)))

    def export(self, controller: Any, folder: Source | None = None, prefix: str | None = None) -> Results:
        """Firmware files of a controller, verified first on the sampled loop; written where a folder is given.

        Raises ValueError where the loop is not proven stable with the rounded coefficients."""
        stability, native = self._machine.export(_controller(controller), prefix)
        found = Results({"verdict": {"met": True, "sentence": stability}}, native)
        if folder is not None:
            found.write(folder)
        return found

    def rehearse(
        self,
        folder: Source,
        truth: Spindle | None = None,
        *,
        controller: Any = None,
        rpm: ArrayLike = 0.0,
        repeats: int = 3,
        seed: int = 1,
    ) -> Results:
        """Writes a measurement folder as a rig would give it: records of ``truth`` (default: this spindle) with sensor noise,
        under a controller that floats it, and this spindle as the model."""
        given = None if controller is None else _controller(controller)
        machine = None if truth is None else truth._machine
        native = self._machine.rehearse(machine, given, _speeds(rpm) or [], int(repeats), int(seed))
        found = Results({}, native)
        found.write(folder)
        return found

    def batch(
        self,
        tools: Iterable[Source | Mapping[str, Any]],
        weights: Source | Mapping[str, Any] = "benchmark",
        polish: bool = True,
        quick: bool = False,
    ) -> Batch:
        """A run for each tool in this spindle; ``quick`` leaves PIDs and pictures out. A tool that fails leaves the others alone."""
        rows, results = [], {}
        for spindle in [self.with_tool(tool) for tool in tools]:
            try:
                row, native = spindle._machine.run_tool(_source(weights), bool(polish), bool(quick))
            except ValueError as error:
                rows.append({"tool": spindle.tool, "failure": str(error)})
                continue
            rows.append(json.loads(row))
            results[spindle.tool] = Results(*_figures(native))
        return Batch(rows, results)

    def diagnose(self, measurement: Source) -> Learnt:
        """The corrected spindle; verdict, effects and gaps are the figures."""
        machine, native = self._machine.diagnose(os.fspath(measurement))
        return Learnt(*_figures(native), spindle=Spindle(machine))

    def save(self, spindle_file: Source, tool_file: Source | None = None) -> None:
        """Writes the spindle and, where there is one, the tool as YAML."""
        files = [(path, text) for path, text in zip((spindle_file, tool_file), self._machine.files()) if text != "none"]
        if any(path is None for path, _ in files):
            raise ValueError("tool_file: the machine has a tool, and no file for it is given")
        for path, text in files:
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)


def _restored(spindle: str, tool: str) -> Spindle:
    return Spindle(_native.Machine.read(spindle, tool))
