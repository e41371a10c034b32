"""What a set of MF-Tyre coefficients should not do: every rule with the load at which it is broken."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from . import v52, v61
from .coefficients import Coefficients
from .shared import State, longitudinal_factors


def findings(version: Literal["5.2", "6.1"], p: Coefficients, unused: tuple[str, ...] = ()) -> list[str]:
    """What is out of physics, one line each, over the file's range of loads (or 0.1 to 2 times the nominal load), upright, at zero slip.

    The books' conditions on the factors: C and D positive, E at most 1 (evaluation cuts it there), stiffness of the right sign.
    """
    most = p.FZMAX if p.FZMAX < 1e8 else 2.0 * p.FNOMIN
    loads = np.linspace(max(p.FZMIN, 0.1 * p.FNOMIN), most, 21)
    found: list[str] = []
    for name, values, sound, expected in _rules(version, p, loads):
        bad = ~np.broadcast_to(sound, loads.shape)
        if np.any(bad):
            at = int(np.argmax(bad))
            found.append(f"{name} is {np.broadcast_to(values, loads.shape)[at]:.4g} at a load of {loads[at]:.0f} N, expected {expected}")
    if p.LMUV != 0.0:
        found.append(f"LMUV is {p.LMUV:g}: the decay of friction with sliding speed is not modelled")
    if p.RCX1 == 0.0 or p.RCY1 == 0.0:
        found.append("RCX1 or RCY1 is zero: forces are not reduced at combined slip and the friction circle is not kept")
    if p.QCZ1 == 0.0:
        found.append("QCZ1 is zero: the pneumatic trail does not fall with slip")
    if p.VERTICAL_STIFFNESS <= 0.0:
        found.append("VERTICAL_STIFFNESS is missing: the rolling radius is taken as the unloaded radius")
    if unused:
        found.append(f"keys that no equation here uses: {', '.join(unused)}")
    return found


def _rules(version: Literal["5.2", "6.1"], p: Coefficients, loads: Any) -> list[tuple[str, Any, Any, str]]:
    """Name, values over the loads, where they are sound, and what is expected."""
    equations = v61 if version == "6.1" else v52
    state = State(0.0, 0.0, 0.0, loads, 0.0, 0.0)
    x, y, t = longitudinal_factors(p, state), equations.lateral_factors(p, state), equations.trail_factors(p, state)
    dfz = state.dfz(p)
    raw_x, raw_y = p.PEX1 + p.PEX2 * dfz + p.PEX3 * dfz**2, p.PEY1 + p.PEY2 * dfz
    raw_t, ex, ey = p.QEZ1 + p.QEZ2 * dfz + p.QEZ3 * dfz**2, p.REX1 + p.REX2 * dfz, p.REY1 + p.REY2 * dfz
    return [
        ("longitudinal shape factor C_x", x.c, np.asarray(x.c) > 0.0, "more than 0"),
        ("longitudinal peak D_x", x.d, x.d > 0.0, "more than 0"),
        ("longitudinal slip stiffness K_x", x.slope, x.slope > 0.0, "more than 0"),
        ("longitudinal curvature E_x", raw_x * p.LEX, raw_x * p.LEX * (1.0 + abs(p.PEX4)) <= 1.0, "at most 1 on both sides"),
        ("lateral shape factor C_y", y.c, np.asarray(y.c) > 0.0, "more than 0"),
        ("lateral peak |D_y|", abs(y.d), abs(y.d) > 0.0, "more than 0"),
        ("lateral friction", abs(y.friction), abs(y.friction) < 5.0, "less than 5"),
        ("longitudinal friction", x.friction, abs(x.friction) < 5.0, "less than 5"),
        ("cornering stiffness K_y", y.slope, y.slope < 0.0, "negative in the file's signs (ISO W)"),
        ("lateral curvature E_y", raw_y * p.LEY, raw_y * p.LEY * (1.0 + np.sign(raw_y) * abs(p.PEY3)) <= 1.0, "at most 1 on both sides"),
        ("trail slope B_t", t.b, t.b >= 0.0, "not negative"),
        ("trail peak D_t", t.d, t.d >= 0.0, "not negative"),
        ("trail shape factor C_t", p.QCZ1, np.asarray(p.QCZ1) >= 0.0, "not negative"),
        ("trail curvature E_t", raw_t, raw_t * (1.0 + np.sign(raw_t) * abs(p.QEZ4)) <= 1.0, "at most 1 on both sides"),
        ("combined curvature E_x,alpha", ex, ex <= 1.0, "at most 1"),
        ("combined curvature E_y,kappa", ey, ey <= 1.0, "at most 1"),
    ]
