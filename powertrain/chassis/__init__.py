"""Equations of motion: single track, double track, quarter car, and the machine that runs them."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
