"""Build backend of the package: maturin, after a look whether there is a Rust compiler that can build muspin."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import maturin
from maturin import *  # noqa: F403  The hooks of PEP 517 that are not replaced here.

ROOT = Path(__file__).resolve().parents[2]


def _numbers(version):
    return tuple(int(part) for part in version.split("."))


def _require_rust():
    needed = re.search(r'^rust-version = "([\d.]+)"', (ROOT / "Cargo.toml").read_text(encoding="utf-8"), re.M)[1]
    remedy = f"install Rust {needed} or later from https://rustup.rs, or give pip a wheel of muspin, which needs no compiler"
    if shutil.which("cargo") is None or shutil.which("rustc") is None:
        raise SystemExit(f"muspin is compiled from Rust, and there is no cargo on PATH: {remedy}")
    said = subprocess.run(["rustc", "--version"], capture_output=True, text=True, cwd=ROOT, check=False).stdout
    found = re.search(r"(\d+(?:\.\d+)+)", said)
    if found is None or _numbers(found[1]) < _numbers(needed):
        raise SystemExit(f"muspin needs Rust {needed}, found {said.strip() or 'a rustc that does not answer'}: {remedy}")


def get_requires_for_build_wheel(config_settings=None):
    _require_rust()
    # No compiler is fetched without a word.
    os.environ["MATURIN_NO_INSTALL_RUST"] = "1"
    return maturin.get_requires_for_build_wheel(config_settings)


def get_requires_for_build_editable(config_settings=None):
    return get_requires_for_build_wheel(config_settings)
