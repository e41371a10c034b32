"""Where a car may drive: curves, roads, road files. Knows nothing of cars."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
