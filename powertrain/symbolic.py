"""CasADi, set up once: import `ca` from here so that NumPy functions keep their shape and type on its symbols.

`ca` has no static type: the package's own stubs refuse arrays where the functions take them.
"""

from __future__ import annotations

from typing import Any

import casadi

ca: Any = casadi

# older CasADi knows only one way and has no such switch
if hasattr(casadi.GlobalOptions, "setNumpyMode"):
    casadi.GlobalOptions.setNumpyMode(1)
