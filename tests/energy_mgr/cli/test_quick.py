"""The quick start leaves libraries and environment as a user expects them."""

import os
import subprocess
import sys

import pytest

from energy_mgr.cli.quick import lean_scipy


def python(code: str, **environment: str) -> str:
    clean = {key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")}
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120, env=clean | environment).stdout


def test_scipy_comes_without_the_reader_of_fortran_and_both_load_afterwards():
    code = """
import sys
from energy_mgr.cli.quick import lean_scipy
with lean_scipy():
    import scipy.linalg
print("numpy.f2py" in sys.modules, "numpy.testing" in sys.modules)
import numpy
print(callable(numpy.f2py.run_main), callable(numpy.testing.assert_allclose))
print(abs(scipy.linalg.det(numpy.diag([2.0, 3.0])) - 6.0) < 1e-12)
"""
    assert python(code).split() == ["False", "False", "True", "True", "True"]


def test_what_is_loaded_already_stays(monkeypatch: pytest.MonkeyPatch):
    import numpy as np
    import numpy.testing

    before = np.testing
    with lean_scipy():
        assert np.testing is before
    assert np.testing is before


def test_an_error_within_the_block_leaves_no_name_hidden():
    code = """
import numpy
from energy_mgr.cli.quick import lean_scipy
try:
    with lean_scipy():
        raise KeyError
except KeyError:
    print(numpy.f2py is not None)
"""
    assert python(code).split() == ["True"]


@pytest.mark.parametrize(("given", "expected"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "7"}, "7")])
def test_one_thread_for_blas_unless_the_environment_says_otherwise(given: dict[str, str], expected: str):
    code = "import os; from energy_mgr.cli.quick import start_quickly; start_quickly(); print(os.environ['OPENBLAS_NUM_THREADS'])"
    assert python(code, **given).strip() == expected
