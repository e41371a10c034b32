"""A quick start for a short process."""

from __future__ import annotations

import gc
import os
import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

#: Parts of NumPy that nobody asks for here: a reader of Fortran and a test framework.
_UNUSED = ("f2py", "testing")


@contextmanager
def lean_scipy() -> Iterator[None]:
    """Within the block the first import of SciPy does not load `numpy.f2py` and `numpy.testing`.

    SciPy copies NumPy's whole namespace when it is first imported, and NumPy loads those two when they are looked at: a twentieth of a second,
    a tenth of what `energy-mgr plan` takes. For the block the names stand for nothing; afterwards they load as ever. For the command's own process.
    """
    import numpy as np

    hidden = [name for name in _UNUSED if name not in vars(np) and f"numpy.{name}" not in sys.modules]
    for name in hidden:
        setattr(np, name, None)
    try:
        yield
    finally:
        for name in hidden:
            if vars(np).get(name, np) is None:
                delattr(np, name)


def start_quickly() -> None:
    """Set this process up for one command: collect garbage seldom, and one thread for BLAS unless the environment says otherwise.

    A short process that imports much loses a tenth of its time to collecting garbage at the usual pace. The matrices here are bands or small: more
    threads have nothing to do but wait for each other on the core that the figure is drawn on.
    """
    gc.set_threshold(100_000, 50, 50)
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def end_quickly() -> None:
    """Leave what there is to the operating system: looking through it for garbage once more would take a tenth of a second."""
    gc.freeze()
