"""A wheel in an environment of its own, as a user without a compiler has it.

usage: python3 tests/wheel.py WHEEL    (made by `pip wheel --no-deps .` or `maturin build --release`)
Builds nothing; installs the wheel with numpy from the package index.
"""

import os
import subprocess
import sys
import tempfile
import venv
import zipfile

CHECK = """
import muspin, numpy
found = muspin.hinfnorm(([[-2.0]], [[1.0]], [[3.0]], [[0.0]]))
assert abs(found.norm - 1.5) < 1e-9 and found.peak_omega == 0.0, found
spindle = muspin.Spindle.load()
assert spindle.response([100.0]).shape == (1, 6, 6), spindle
assert isinstance(spindle.plant(), muspin.System), "systems without python-control"
try:
    spindle.compare("results").plot
except ValueError as error:
    assert "results" in str(error), error
print(muspin.__version__)
"""


def main():
    wheel = os.path.abspath(sys.argv[1])
    name = os.path.basename(wheel).removesuffix(".whl").split("-")
    assert name[0] == "muspin" and name[2:4] == ["cp310", "abi3"], f"one wheel for every Python from 3.10 on: {name}"
    with zipfile.ZipFile(wheel) as archive:
        assert archive.testzip() is None
        files = archive.namelist()
    for needed in ("muspin/__init__.py", "muspin/_plots.py", "muspin/_native.pyi", "muspin/py.typed"):
        assert needed in files, f"{needed} is missing: {files}"
    native = [file for file in files if file.startswith("muspin/_native") and file.endswith((".so", ".pyd"))]
    assert len(native) == 1 and "build_backend" not in " ".join(files), files
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        programs = os.path.join(folder, "Scripts" if os.name == "nt" else "bin")
        python = os.path.join(programs, "python")
        # No cargo on PATH: nothing may be compiled.
        environment = {**os.environ, "PATH": os.pathsep.join([programs, "/usr/bin", "/bin"])}
        run = lambda *command: subprocess.run(command, check=True, capture_output=True, text=True, env=environment, cwd=folder).stdout
        run(python, "-m", "pip", "install", "--quiet", "--only-binary", ":all:", wheel)
        version = run(python, "-c", CHECK).strip()
        for command in ([os.path.join(programs, "muspin")], [python, "-m", "muspin"]):
            assert version in run(*command, "--version"), command
        modes = run(os.path.join(programs, "muspin"), "modes", "--json")
        assert "natural_frequencies_hz" in modes, modes
    print(f"{os.path.basename(wheel)}: installed and used in a fresh environment")


main()
