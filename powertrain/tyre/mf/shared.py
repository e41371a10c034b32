"""What MF-Tyre 5.2 and 6.1 have in common: the longitudinal force and the weights of combined slip.

Equation numbers are those of Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012; terms that 5.2 does not know have coefficients that are zero there.
Signs are the books' (ISO W): positive side slip pushes to the right.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .coefficients import Coefficients
from .curve import Factors, weight


class State(NamedTuple):
    """What all equations share, in the books' signs.

    Attributes:
        kappa: longitudinal slip.
        alpha: side slip angle, rad.
        slip: what enters the lateral equations for it: `tan(alpha)` in 6.1 (4.E3), `alpha` in 5.2.
        load: wheel load, N, positive.
        camber: inclination, rad.
        lean: what enters the equations for it: `sin(camber)` in 6.1 (4.E4), `camber` in 5.2.
        friction: of the road, relative.
        pressure: increment of the inflation pressure over the nominal one (4.E2b).
    """

    kappa: Any
    alpha: Any
    slip: Any
    load: Any
    camber: Any
    lean: Any
    friction: Any = 1.0
    pressure: Any = 0.0

    def dfz(self, p: Coefficients) -> Any:
        """Increment of the load over the nominal one (4.E2a)."""
        nominal = p.LFZO * p.FNOMIN
        return (self.load - nominal) / nominal


def longitudinal_factors(p: Coefficients, s: State) -> Factors:
    """Factors of the pure longitudinal force."""
    dfz, dpi, friction = s.dfz(p), s.pressure, p.LMUX * s.friction
    c = p.PCX1 * p.LCX  # (4.E11)
    mu = (p.PDX1 + p.PDX2 * dfz) * (1.0 + p.PPX3 * dpi + p.PPX4 * dpi**2) * (1.0 - p.PDX3 * (s.camber * p.LGAX) ** 2) * friction  # (4.E13)
    d = mu * s.load  # (4.E12)
    slope = s.load * (p.PKX1 + p.PKX2 * dfz) * np.exp(p.PKX3 * dfz) * (1.0 + p.PPX1 * dpi + p.PPX2 * dpi**2) * p.LKX  # (4.E15)
    horizontal = (p.PHX1 + p.PHX2 * dfz) * p.LHX  # (4.E17)
    vertical = s.load * (p.PVX1 + p.PVX2 * dfz) * p.LVX * friction  # (4.E18)
    side = np.sign(s.kappa + horizontal)
    e = np.minimum((p.PEX1 + p.PEX2 * dfz + p.PEX3 * dfz**2) * (1.0 - p.PEX4 * side) * p.LEX, 1.0)  # (4.E14)
    return Factors(slope / (c * d), c, d, e, horizontal, vertical, slope, mu)  # B: (4.E16)


def longitudinal_weight(p: Coefficients, s: State) -> Any:
    """Reduction of the longitudinal force by side slip (4.E51) to (4.E57)."""
    b = (p.RBX1 + p.RBX3 * s.lean**2) * np.cos(np.arctan(p.RBX2 * s.kappa)) * p.LXAL
    return weight(b, p.RCX1, np.minimum(p.REX1 + p.REX2 * s.dfz(p), 1.0), s.slip, p.RHX1)


def lateral_weight(p: Coefficients, s: State) -> Any:
    """Reduction of the lateral force by longitudinal slip (4.E59) to (4.E65)."""
    dfz = s.dfz(p)
    b = (p.RBY1 + p.RBY4 * s.lean**2) * np.cos(np.arctan(p.RBY2 * (s.slip - p.RBY3))) * p.LYKA
    return weight(b, p.RCY1, np.minimum(p.REY1 + p.REY2 * dfz, 1.0), s.kappa, p.RHY1 + p.RHY2 * dfz)


def kappa_induced(p: Coefficients, s: State, mu: Any) -> Any:
    """Lateral force that longitudinal slip brings about (4.E66), (4.E67)."""
    d = mu * s.load * (p.RVY1 + p.RVY2 * s.dfz(p) + p.RVY3 * s.lean) * np.cos(np.arctan(p.RVY4 * s.slip))
    return d * np.sin(p.RVY5 * np.arctan(p.RVY6 * s.kappa)) * p.LVYKA
