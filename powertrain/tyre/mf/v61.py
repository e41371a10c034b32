"""MF-Tyre 6.1: Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, equations (4.E1) to (4.E78), in the book's own signs (ISO W).

Steady state, combined slip, inflation pressure, camber and all scaling factors; without turn slip (every zeta is 1) and without the decay of
friction with sliding speed (LMUV), which would need the speed. The digressive friction factor (4.E8) is left at A_mu = 1, as the makers' own tool
does. QBZ4, which files have and the book lost, is kept. Equation numbers stand beside the lines.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .coefficients import Coefficients
from .curve import Factors, cosine, length, sine
from .shared import State, kappa_induced, lateral_weight, longitudinal_factors, longitudinal_weight


def cornering_slope(p: Coefficients, s: State) -> Any:
    """Cornering stiffness K_y,alpha in the book's sign, negative for a real tyre (4.E25)."""
    nominal = p.LFZO * p.FNOMIN
    peak_load = (p.PKY2 + p.PKY5 * s.lean**2) * (1.0 + p.PPY2 * s.pressure) * nominal
    shape = np.sin(p.PKY4 * np.arctan(s.load / peak_load))
    return p.PKY1 * nominal * (1.0 + p.PPY1 * s.pressure) * (1.0 - p.PKY3 * abs(s.lean)) * shape * p.LKY


def lateral_factors(p: Coefficients, s: State) -> Factors:
    """Factors of the pure lateral force."""
    dfz, dpi, lean, friction = s.dfz(p), s.pressure, s.lean, p.LMUY * s.friction
    slope = cornering_slope(p, s)
    c = p.PCY1 * p.LCY  # (4.E21)
    mu = (p.PDY1 + p.PDY2 * dfz) * (1.0 + p.PPY3 * dpi + p.PPY4 * dpi**2) * (1.0 - p.PDY3 * lean**2) * friction  # (4.E23)
    d = mu * s.load  # (4.E22)
    thrust = s.load * (p.PVY3 + p.PVY4 * dfz) * lean * p.LKYC * friction  # (4.E28)
    camber_slope = s.load * (p.PKY6 + p.PKY7 * dfz) * (1.0 + p.PPY5 * dpi) * p.LKYC  # (4.E30)
    horizontal = (p.PHY1 + p.PHY2 * dfz) * p.LHY + (camber_slope * lean - thrust) / slope  # (4.E27)
    vertical = s.load * (p.PVY1 + p.PVY2 * dfz) * p.LVY * friction + thrust  # (4.E29)
    side = np.sign(s.slip + horizontal)
    e = (p.PEY1 + p.PEY2 * dfz) * (1.0 + p.PEY5 * lean**2 - (p.PEY3 + p.PEY4 * lean) * side) * p.LEY  # (4.E24)
    return Factors(slope / (c * d), c, d, np.minimum(e, 1.0), horizontal, vertical, slope, mu)  # B: (4.E26)


def trail_factors(p: Coefficients, s: State) -> Factors:
    """Factors of the pneumatic trail (4.E35), (4.E40) to (4.E44)."""
    dfz, lean, nominal = s.dfz(p), s.lean, p.LFZO * p.FNOMIN
    shift = p.QHZ1 + p.QHZ2 * dfz + (p.QHZ3 + p.QHZ4 * dfz) * lean
    b = (p.QBZ1 + p.QBZ2 * dfz + p.QBZ3 * dfz**2) * (1.0 + p.QBZ4 * lean + p.QBZ5 * abs(lean) + p.QBZ6 * lean**2)
    b = b * p.LKY / (p.LMUY * s.friction)
    d = s.load * p.UNLOADED_RADIUS / nominal * (p.QDZ1 + p.QDZ2 * dfz) * (1.0 - p.PPZ1 * s.pressure) * p.LTR
    d = d * (1.0 + p.QDZ3 * abs(lean) + p.QDZ4 * lean**2)
    turned = (p.QEZ4 + p.QEZ5 * lean) * (2.0 / np.pi) * np.arctan(b * p.QCZ1 * (s.slip + shift))
    e = (p.QEZ1 + p.QEZ2 * dfz + p.QEZ3 * dfz**2) * (1.0 + turned)
    return Factors(b, p.QCZ1, d, np.minimum(e, 1.0), shift)


def residual_factors(p: Coefficients, s: State, y: Factors) -> Factors:
    """Factors of the residual moment (4.E38), (4.E45) to (4.E47)."""
    dfz, lean, friction = s.dfz(p), s.lean, p.LMUY * s.friction
    leaning = (p.QDZ8 + p.QDZ9 * dfz) * (1.0 + p.PPZ2 * s.pressure) + (p.QDZ10 + p.QDZ11 * dfz) * abs(lean)
    d = (p.QDZ6 + p.QDZ7 * dfz) * p.LRES + leaning * lean * p.LKZC
    d = d * s.load * p.UNLOADED_RADIUS * friction * np.cos(s.alpha)
    return Factors(p.QBZ9 * p.LKY / friction + p.QBZ10 * y.b * y.c, 1.0, d, 0.0, y.horizontal + y.vertical / y.slope)


def forces(p: Coefficients, s: State) -> tuple[Any, Any, Any]:
    """Longitudinal and lateral force and aligning moment at combined slip, (4.E50), (4.E58), (4.E71)."""
    x, y = longitudinal_factors(p, s), lateral_factors(p, s)
    longitudinal = longitudinal_weight(p, s) * (sine(x, s.kappa + x.horizontal) + x.vertical)
    reduction = lateral_weight(p, s)
    lateral = reduction * (sine(y, s.slip + y.horizontal) + y.vertical) + kappa_induced(p, s, y.friction)
    upright = lateral_factors(p, s._replace(camber=0.0, lean=0.0))
    steering = reduction * (sine(upright, s.slip + upright.horizontal) + upright.vertical)  # (4.E74)
    trail, residual = trail_factors(p, s), residual_factors(p, s, y)
    other = x.slope / y.slope * s.kappa  # (4.E77), (4.E78)
    arm = p.SSZ1 + p.SSZ2 * lateral / (p.LFZO * p.FNOMIN) + (p.SSZ3 + p.SSZ4 * s.dfz(p)) * s.lean  # (4.E76)
    lever = cosine(trail, length(s.slip + trail.horizontal, other)) * np.cos(s.alpha)  # (4.E73)
    remains = cosine(residual, length(s.slip + residual.horizontal, other))  # (4.E75)
    return longitudinal, lateral, remains - lever * steering + p.UNLOADED_RADIUS * arm * p.LS * longitudinal
