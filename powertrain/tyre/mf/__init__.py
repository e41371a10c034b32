"""MF-Tyre: the full magic formula, versions 5.2 and 6.1."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
