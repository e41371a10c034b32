"""From tests of a cell, real or virtual, to its parameters: slow tests, dynamic tests, and a report of what was met how well."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
