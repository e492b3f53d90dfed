"""Noise through a mode of 180 Hz, with noise on force and response, and its spectra by SciPy; the record as CSV, WAV, MATLAB
and universal file (pip install scipy pyuff)."""

import json
from pathlib import Path

import numpy as np
import pyuff
from scipy import io, signal
from scipy.io import wavfile

HERE = Path(__file__).parent
RATE, SAMPLES, SEGMENT = 1000, 1200, 240

rng = np.random.default_rng(1)
force = rng.standard_normal(SAMPLES)
w, z = 2 * np.pi * 180, 0.03
b, a, _ = signal.cont2discrete(([w * w], [1, 2 * z * w, w * w]), 1 / RATE, "zoh")
response = signal.lfilter(b.ravel(), a, force) + 0.3 * rng.standard_normal(SAMPLES)
force = force + 0.2 * rng.standard_normal(SAMPLES)
force, response = np.round(force, 6), np.round(response, 6)

reference = {}
for name, window, segment in [("hann", "hann", SEGMENT), ("rectangular", "boxcar", SEGMENT), ("short", "hann", 100)]:
    options = {"fs": RATE, "window": window, "nperseg": segment, "noverlap": segment // 2}
    f, xx = signal.welch(force, **options)
    _, yy = signal.welch(response, **options)
    _, xy = signal.csd(force, response, **options)
    _, coherence = signal.coherence(force, response, **options)
    estimates = {"h1": xy / xx, "h2": yy / xy.conj(), "hv": xy / abs(xy) * np.sqrt(yy / xx)}
    reference[name] = {"segment": segment, "frequency_hz": f[1:].tolist(), "coherence": coherence[1:].tolist()}
    for key, h in estimates.items():
        reference[name][key] = [[value.real, value.imag] for value in h[1:]]
(HERE / "scipy.json").write_text(json.dumps(reference))

time = np.arange(SAMPLES) / RATE
rows = [f"{t:.3f},{x:.6f},{y:.6f}" for t, x, y in zip(time, force, response)]
(HERE / "record.csv").write_text("time_s,force_n,response_m\n" + "\n".join(rows) + "\n")
wavfile.write(HERE / "record.wav", RATE, np.stack([force, response], axis=1))
io.savemat(HERE / "record.mat", {"fs": float(RATE), "force": force, "response": response}, do_compression=True)
(HERE / "record.uff").unlink(missing_ok=True)
file = pyuff.UFF(str(HERE / "record.uff"))
for node, kind, label, samples in [(1, 13, "N", force), (2, 8, "mm", 1e3 * response)]:
    file.write_sets(
        pyuff.prepare_58(
            binary=1, func_type=1, rsp_node=node, rsp_dir=1, ref_node=0, ref_dir=0, data=samples, x=time, id1="record",
            abscissa_spec_data_type=17, abscissa_axis_units_lab="s", ordinate_spec_data_type=kind,
            ordinate_axis_units_lab=label, orddenom_spec_data_type=0, z_axis_spec_data_type=0, abscissa_spacing=1, abscissa_inc=1 / RATE, abscissa_min=0.0, ord_data_type=4,
        ),
        "add",
    )
