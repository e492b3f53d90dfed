"""Opens an exported controller.mat with SciPy and compares it with discrete.json beside it.

    pip install scipy
    muspin export --controller K.json --out results/export
    python tests/check_mat.py results/export
"""

import json
import pathlib
import sys

import numpy
from scipy.io import loadmat

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "results/export")
mat = loadmat(folder / "controller.mat")
expected = json.loads((folder / "discrete.json").read_text())
for name in "ABCD":
    assert numpy.array_equal(mat[name], numpy.array(expected[name])), name
assert mat["Ts"].shape == (1, 1) and mat["Ts"][0, 0] == expected["sample_time_s"]
print("controller.mat agrees with discrete.json:", {k: mat[k].shape for k in "ABCD"}, "Ts", mat["Ts"][0, 0])
