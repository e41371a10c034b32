"""One wheel on the road: the motion of its contact patch, tyre relaxation through standstill, forces.

Each patch has a longitudinal and a lateral deflection u, w:

    u' = V_x - leak_x,    kappa = u / sigma_x         V_x = omega R - v_along
    w' = V_y - leak_y,    tan(alpha) = w / sigma_y    V_y = -v_across

with the leak |v| times slip. At speed that is the first-order relaxation of slip; at rest it is a spring, so a car stands on its tyres without creep
and without a singular slip. Near rest a patch that slides also sheds what the tyre's force does not hold: a carcass is stretched by F / k, not by the
slip of a locked or spinning wheel. And a damping adds to the slip there.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

#: Damping of the standing tyre, s: slip added per sliding speed over relaxation length. Near a tenth of the car's period on its tyres.
_DAMPING = 0.01
#: It fades out beyond this speed, m/s; so does the shedding.
_STANDING = 1.0
#: Slip that a sliding patch keeps beyond what its force holds, and the sliding speed (m/s) from which the shedding grows no faster.
_SHED_SLIP, _SHED_SPEED = 0.02, 1.0
#: Beyond the slip of a locked wheel deflections hardly grow.
_LARGEST_SLIP = 1.0
#: Rolling resistance changes its sign within about this speed, m/s.
_ROLLING_STEP = 0.05


class Wheel(NamedTuple):
    """One wheel's motion and forces."""

    #: N
    load: Any
    #: force of the road in the wheel's frame, N
    longitudinal: Any
    side: Any
    #: aligning moment, Nm
    aligning: Any
    #: the same in the body's frame, N
    body_x: Any
    body_y: Any
    #: rate of the deflections, m/s
    u_rate: Any
    w_rate: Any
    #: power lost in sliding, W, and power that the deflection takes up, W
    slip_loss: Any
    carcass: Any
    #: rolling resistance torque, Nm
    rolling: Any
    #: speed of the patch over the ground, m/s
    ground_speed: Any


class Patch(NamedTuple):
    """What a contact patch is moved by."""

    #: velocity of the patch in the body's frame, m/s
    v_x: Any
    v_y: Any
    #: steering angle, rad; None for a wheel that is not steered
    delta: Any
    #: spin, rad/s
    omega: Any
    #: deflections, m
    u: Any
    w: Any
    #: N
    load: Any


def saturated(x: Any) -> Any:
    """A smooth step from -1 to 1 with slope 1 at zero; a third of the cost of tanh."""
    return x / np.sqrt(1.0 + x * x)


def wheel_on_road(tyre: Any, radius: float, patch: Patch, friction: Any, rolling_coefficient: Any, *, powers: bool = False) -> Wheel:
    """Forces and rates of one wheel.

    Args:
        tyre: a tyre model of `powertrain.tyre`.
        radius: of the wheel, m.
        patch: motion, deflections and load.
        friction: scales the tyre.
        rolling_coefficient: rolling resistance over load.
        powers: tell springs and damping of the tyre apart, which `slip_loss` and `carcass` need; else these two mean nothing.
    """
    along, across, turn = _wheel_frame(patch)
    sliding = patch.omega * radius - along
    sigma_x, sigma_y = tyre.relaxation(patch.load)
    per_x, per_y = 1.0 / sigma_x, 1.0 / sigma_y
    slip, tan = patch.u * per_x, patch.w * per_y
    rest = 1.0 / (1.0 + (along * (1.0 / _STANDING)) ** 4)
    damping = _DAMPING * rest
    kappa, alpha = slip + damping * sliding * per_x, np.arctan(tan - damping * across * per_y)
    forces = tyre.forces(kappa, alpha, patch.load, friction=friction)
    f_x, f_y = forces.longitudinal, forces.lateral
    stiffness = np.fmax(tyre.slip_stiffness(patch.load), 1.0), np.fmax(tyre.cornering_stiffness(patch.load), 1.0)
    leak_x = _leak(along, sliding, slip, f_x / stiffness[0], rest)
    leak_y = _leak(along, across, tan, f_y / stiffness[1], rest)
    u_rate, w_rate = sliding - leak_x, -across - leak_y
    # what the springs alone would hold; the rest of the force is the damping's
    spring = tyre.forces(slip, np.arctan(tan), patch.load, friction=friction) if powers else forces
    s_x, s_y = spring.longitudinal, spring.lateral
    return Wheel(
        load=patch.load,
        longitudinal=f_x,
        side=f_y,
        aligning=forces.aligning,
        body_x=f_x if turn is None else turn[0] * f_x - turn[1] * f_y,
        body_y=f_y if turn is None else turn[1] * f_x + turn[0] * f_y,
        u_rate=u_rate,
        w_rate=w_rate,
        slip_loss=s_x * leak_x + s_y * leak_y + (f_x - s_x) * sliding - (f_y - s_y) * across,
        carcass=s_x * u_rate + s_y * w_rate,
        rolling=rolling_coefficient * patch.load * radius * saturated(patch.omega * (radius / _ROLLING_STEP)),
        ground_speed=np.sqrt(along * along + across * across),
    )


def _leak(along: Any, sliding: Any, slip: Any, held: Any, rest: Any) -> Any:
    """By how much a deflection falls behind the sliding of its patch, m/s; `held` is the slip that the force would have on the initial slope."""
    speed = np.fabs(sliding)
    shed = rest * (1.0 / _SHED_SLIP) * np.fmin(speed, _SHED_SPEED) * (slip - held)
    # a wheel that spins, or is pushed broadside, has slips of any size; its carcass has not
    return (np.fabs(along) + speed * np.fmax(np.fabs(slip) - _LARGEST_SLIP, 0.0)) * slip + shed


def _wheel_frame(patch: Patch) -> tuple[Any, Any, tuple[Any, Any] | None]:
    """Velocity of the patch along and across the wheel, and cosine and sine of its steering angle."""
    if patch.delta is None:
        return patch.v_x, patch.v_y, None
    cos, sin = np.cos(patch.delta), np.sin(patch.delta)
    return patch.v_x * cos + patch.v_y * sin, patch.v_y * cos - patch.v_x * sin, (cos, sin)
