"""Where the interior-point method for chains starts from: speeds, or the solution of a neighbouring programme."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..fastest.forward_backward import friction_braking
from .iterate import Iterate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .chain import Chain

    Floats = NDArray[np.float64]

#: Slacks start at least this large, bounds are kept away from by this share.
_APART, _INSIDE = 1e-3, 1e-2


def about(chain: Chain, x: Floats, *, price: float, barrier: float) -> Iterate:
    """A first iterate about speeds: inside the bounds, slacks where the rows are, multipliers for complementarity `barrier`."""
    x = np.where(chain.fixed, chain.bound, np.clip(x, _INSIDE * 1e-2 * chain.bound, (1.0 - _INSIDE) * chain.bound))
    local = np.zeros((chain.model.count, 2))
    if chain.model.braking:
        # what the motors may not recuperate at these speeds, or a battery that takes little, is violated by far without
        needed = friction_braking(chain.model.limits, np.sqrt(2.0 * chain.model.energy_scale * x))
        local[:, 1] = 1e-2 + (0.0 if needed is None else needed / chain.model.force_scale)
    rows = chain.model.values(chain.unknown(x, local)).rows
    local[:, 0] = np.maximum(rows[:, 2], rows[:, 3]) + 1e-2
    values = chain.model.values(chain.unknown(x, local))
    slack = np.maximum(-values.rows, _APART)
    jerk_slack = np.maximum(-chain.jerks(x), _APART)
    late = np.maximum(-chain.excess(values.time), _APART)
    scale = barrier / chain.model.count
    room = chain.room(x)
    return Iterate(
        x,
        local,
        slack,
        scale / slack,
        np.where(chain.free, scale / np.maximum(x, 1e-12), 0.0),
        np.where(chain.free, scale / room, 0.0),
        late,
        np.full(len(late), price),
        0.0,
        jerk_slack,
        scale / jerk_slack,
    )


def again(chain: Chain, found: Iterate, barrier: float) -> Iterate:
    """A first iterate from the solution of a neighbouring programme: its unknowns drawn in from their bounds, its multipliers kept from zero."""
    x = np.where(chain.fixed, chain.bound, np.clip(found.x, 1e-6 * chain.bound, (1.0 - 1e-4) * chain.bound))
    values = chain.model.values(chain.unknown(x, found.local))
    slack = np.maximum(-values.rows, 1e-4)
    scale = barrier / chain.model.count
    late = np.maximum(-chain.excess(values.time), 1e-4)
    jerk_slack = np.maximum(-chain.jerks(x), 1e-4)
    room = chain.room(x)
    price = found.price if len(found.price) == len(late) else np.full(len(late), 1e-3)
    return Iterate(
        x,
        found.local,
        slack,
        np.maximum(found.dual, scale / slack),
        np.where(chain.free, np.maximum(found.low, scale / np.maximum(x, 1e-12)), 0.0),
        np.where(chain.free, np.maximum(found.high, scale / room), 0.0),
        late,
        np.maximum(price, 1e-6),
        found.ring,
        jerk_slack,
        np.maximum(found.jerk_dual, scale / jerk_slack) if chain.jerk else jerk_slack,
    )
