"""Tyres: linear, magic formula, MF-Tyre 5.2 and 6.1 from `.tir` files. Signs are described in `powertrain.tyre.force`."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
