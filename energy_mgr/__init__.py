"""Plan, follow and allocate: energy management and trajectory optimisation for electric cars."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
