"""Fixtures shared by all tests."""

import os
from pathlib import Path

# one thread for BLAS in each of pytest's processes and in those that tests start: several take turns waiting for each other, which tripled the time
for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
# a fault of a command shows where it comes from; its exit code fails the test
os.environ.setdefault("ENERGY_MGR_TRACEBACK", "1")

import numpy as np
import pytest
from hypothesis import settings

import powertrain.symbolic  # noqa: F401  tells CasADi how NumPy functions treat its symbols
from powertrain import Vehicle, load_vehicle

from .figures import figure, pytest_terminal_summary  # noqa: F401  a fixture, and the section of the summary that it fills

# the same examples in every run and on every machine: what fails here fails for who looks into it
settings.register_profile("same", derandomize=True)
settings.load_profile("same")

#: Real roads to try the code on; not part of the project. ENERGY_MGR_DATA names the folder, else it is looked for beside the checkout.
DATA = Path(os.environ.get("ENERGY_MGR_DATA", Path(__file__).parents[2] / "shared" / "data"))


@pytest.fixture(scope="session")
def romo() -> Vehicle:
    return load_vehicle("romo")


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20261122)


@pytest.fixture
def straight_rows() -> list[tuple[float, ...]]:
    """Rows of a good track CSV: 295 m straight, 7 m wide."""
    return [(5.0 * i, 0.0, 3.5, 3.5) for i in range(60)]
