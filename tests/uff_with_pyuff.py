"""Reads universal files that muspin wrote with pyuff and compares them with the CSV beside them. Not part of CI.

    cargo build --release
    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install numpy pyuff
    target/release/muspin identify --measurement tests/data/identify/c03 --out /tmp/identified
    /tmp/venv/bin/python tests/uff_with_pyuff.py /tmp/identified/hammer-0
"""
import sys

import numpy
import pyuff

stem = sys.argv[1]
table = numpy.genfromtxt(stem + ".csv", delimiter=",", names=True)
data = pyuff.UFF(stem + ".uff").read_sets()
assert data["type"] == 58 and data["func_type"] == 4, data["func_type"]
assert data["ordinate_spec_data_type"] == 8 and data["orddenom_spec_data_type"] == 13
expected = table["h_re"] + 1j * table["h_im"]
worst_x = numpy.abs(data["x"] / table["frequency_hz"] - 1).max()
worst_y = numpy.abs(data["data"] / expected - 1).max()
print(f"{len(expected)} lines, largest relative difference: frequency {worst_x:.1e}, compliance {worst_y:.1e}")
# Five and eleven decimals are what the format prints.
assert worst_x < 1e-5 and worst_y < 1e-10
