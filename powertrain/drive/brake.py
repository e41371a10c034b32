"""Friction brake M9: dry friction that holds a wheel at rest without creep.

Dry friction with a presliding range (Dahl's model): `hold` is the share of the clamped torque that acts. It grows as the wheel turns against the
clamped pad and settles at plus or minus one once the pad slides; at rest it stays where it is, so a parked car does not creep. With speed the
settling is slowed to `sliding_time_s`, which keeps the equation soft enough for a fixed step.

    hold' = (omega - |omega| hold) / (presliding + |omega| sliding_time)
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..description.sections import Brakes

#: Damping of the presliding range, s: torque per clamped torque and rate of `hold`. Near a tenth of the wheel's period on the pad.
_DAMPING = 0.004
#: 1/s without clamping, falling to nothing at 1 Nm.
_FORGET = 20.0


def hold_rate(brakes: Brakes, clamped: Any, speed: Any, hold: Any) -> Any:
    """d hold/dt in 1/s with `clamped` Nm pressed on, at wheel `speed` (rad/s); a pad that is let go forgets its stretch."""
    turning = np.fabs(speed)
    return (speed - turning * hold) / (brakes.presliding_rad + turning * brakes.sliding_time_s) - _FORGET * hold * np.fmax(1.0 - clamped, 0.0)


def brake_torque(brakes: Brakes, clamped: Any, speed: Any, hold: Any) -> Any:
    """Torque on the wheel in Nm, against its rotation, when `clamped` (Nm) is pressed on."""
    return clamped * (hold + _DAMPING * hold_rate(brakes, clamped, speed, hold))


def stored(brakes: Brakes, clamped: Any, hold: Any) -> Any:
    """Elastic energy of the presliding pad, J."""
    return 0.5 * clamped * brakes.presliding_rad * hold**2
