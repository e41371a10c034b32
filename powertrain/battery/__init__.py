"""Battery: cells of three models, packs, power availability, and how parameters are got from tests."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
