"""Tyres to test."""

from pathlib import Path

import numpy as np

from powertrain.tyre import LinearTyre, MagicTyre, MfTyre, read_tir

HERE = Path(__file__).parent


def magic_tyre(**changed: float) -> MagicTyre:
    values = {"nominal_load_n": 2484.0, "relaxation_longitudinal_m": 0.2, "relaxation_lateral_m": 0.4, "rolling_radius_m": 0.3} | changed
    return MagicTyre(**values)


def linear_tyre(**changed: float) -> LinearTyre:
    values = {
        "nominal_load_n": 2484.0,
        "cornering_stiffness_nprad": 37.5e3,
        "slip_stiffness_n": 60e3,
        "relaxation_longitudinal_m": 0.2,
        "relaxation_lateral_m": 0.4,
        "rolling_radius_m": 0.3,
        "pneumatic_trail_m": 0.03,
        "camber_stiffness_nprad": 2e3,
    }
    return LinearTyre(**(values | changed))


BOOK, SAMPLE = read_tir("car205_60r15"), read_tir(HERE / "mf52_sample.tir")
TYRES: dict[str, LinearTyre | MagicTyre | MfTyre] = {
    "linear": linear_tyre(load_degression=0.3),
    "magic": magic_tyre(load_degression=0.3, camber_slip=0.05, longitudinal_peak_n=3000.0),
    "mf61": BOOK,
    "mf52": SAMPLE,
}


def table(name: str) -> np.ndarray:
    """Rows of a table of check values; what it leaves empty is NaN."""
    lines = [line for line in (HERE / name).read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return np.genfromtxt(lines[1:], delimiter=",")
