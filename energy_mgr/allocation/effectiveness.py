"""Control effectiveness A1m: which motion the commands give, b(u, x), and its exact Jacobian B = db/du, (3.34) to (3.38).

Quasi-static: each wheel passes on what its motor and brake do to it, `F_l = (tau - tau_brake) / R`, and pushes aside as its tyre does at the slip
angle `alpha = delta - atan2(v_y, v_x)` of its own velocity. Relaxation, wheel spin and the lag of actuators are not in it. Motion here is force over
mass and moment over yaw inertia, so that it is linear in the forces; subtract (0, 0, yaw rate) x (v_x, v_y, 0) for the rates of the velocities
(3.37).

One description in NumPy operations serves floats, arrays and CasADi symbols.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from powertrain.symbolic import ca
from powertrain.tyre import LinearTyre
from powertrain.vehicle import GRAVITY

from ..errors import PlanningError
from .compiled import Compiled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from .layout import Layout

    Floats = NDArray[np.float64]

TyreKind = Literal["linear", "load", "own"]
#: What the motion depends on beside the commands: velocities (m/s, rad/s), accelerations (m/s^2) for the wheel loads, friction of the road.
STATES = ("v_x", "v_y", "yaw_rate", "a_x", "a_y", "friction")
#: Slip angles are those of a car that is at least this fast, m/s: at standstill a wheel has none.
SLOWEST = 1.0
#: No wheel carries less than this share of its load at rest: one that lifts keeps a little authority, and no division fails.
_LIGHTEST = 0.02


class WheelForce(NamedTuple):
    """One wheel: forces in N, in its own frame and in the car's, its slip angle (rad), load (N), speed over the ground and spin (m/s, rad/s)."""

    along: Any
    side: Any
    body_x: Any
    body_y: Any
    alpha: Any
    load: Any
    speed: Any
    spin: Any
    #: slope of the longitudinal force over slip, N
    stiffness: Any
    #: moment of the tyre about the vertical axis, Nm
    aligning: Any


class Model:
    """The quasi-static car."""

    def __init__(self, layout: Layout, tyre: TyreKind = "own") -> None:
        """The model of a car.

        Args:
            layout: its actuators.
            tyre: `linear` (constant stiffness, as published), `load` (linear, its stiffness following the wheel load) or `own` (the car's tyre).

        Raises:
            PlanningError: another word for `tyre`.
        """
        if tyre not in ("linear", "load", "own"):
            raise PlanningError(f"tyre of the allocation {tyre!r}, expected linear, load or own")
        self.layout, self.kind = layout, tyre
        self._rest = [float(load) for load in self._loads(0.0, 0.0)]
        own = layout.track.tyres
        self._tyres = own if tyre == "own" else tuple(_linear(own[k], self._rest[k], tyre) for k in range(4))

    def _loads(self, a_x: Any, a_y: Any) -> list[Any]:
        """Wheel loads in N, transfer settled."""
        b, mass = self.layout.track.body, self.layout.vehicle.chassis.mass_kg
        pitch = mass * a_x * b.cog_height_m / (2.0 * b.wheelbase_m)
        front, rear = (0.5 * mass * GRAVITY * arm / b.wheelbase_m for arm in (b.rear_axle_m, b.front_axle_m))
        roll = mass * a_y * b.cog_height_m
        across_front, across_rear = b.roll_front_share * roll / b.front_track_m, (1.0 - b.roll_front_share) * roll / b.rear_track_m
        return [front - pitch - across_front, front - pitch + across_front, rear + pitch - across_rear, rear + pitch + across_rear]

    def wheels(self, u: Sequence[Any], x: Sequence[Any]) -> list[WheelForce]:
        """The four wheels under commands `u` (in the order of the layout) in state `x` (in the order of `STATES`)."""
        layout, s = self.layout, dict(zip(STATES, x, strict=True))
        frame, radius = layout.track.body, layout.vehicle.chassis.wheel_radius_m
        drives = layout.track.drive_torques({f"torque_{k + 1}": u[k] for k in range(layout.motors)})
        loads = [np.fmax(load, _LIGHTEST * rest) for load, rest in zip(self._loads(s["a_x"], s["a_y"]), self._rest, strict=True)]
        found = []
        for k in range(4):
            v_x, v_y = s["v_x"] - frame.wheel_y[k] * s["yaw_rate"], s["v_y"] + frame.wheel_x[k] * s["yaw_rate"]
            delta = u[layout.steers.start + layout.steered.index(k)] if k in layout.steered else 0.0
            alpha = delta - np.arctan2(v_y, np.fmax(v_x, SLOWEST))
            along = (drives[k] - u[layout.brakes.start + k]) / radius
            stiffness = self._tyres[k].slip_stiffness(loads[k])
            forces = self._tyres[k].forces(along / stiffness, alpha, loads[k], friction=s["friction"])
            side = forces.lateral
            cos, sin = np.cos(delta), np.sin(delta)
            speed = np.sqrt(v_x * v_x + v_y * v_y)
            body = cos * along - sin * side, sin * along + cos * side
            found.append(WheelForce(along, side, *body, alpha, loads[k], speed, v_x / radius, stiffness, forces.aligning))
        return found

    def motion(self, wheels: Sequence[WheelForce]) -> list[Any]:
        """b: force over mass along the car's axes (m/s^2) and moment over yaw inertia (rad/s^2)."""
        body, mass = self.layout.track.body, self.layout.vehicle.chassis.mass_kg
        moment = sum(body.wheel_x[k] * wheel.body_y - body.wheel_y[k] * wheel.body_x for k, wheel in enumerate(wheels))
        return [sum(w.body_x for w in wheels) / mass, sum(w.body_y for w in wheels) / mass, moment / body.yaw_inertia_kgm2]


class Effectiveness:
    """b and B, compiled."""

    def __init__(self, layout: Layout, tyre: TyreKind = "own") -> None:
        """For a car with `layout`, with tyres as in `Model`."""
        model = Model(layout, tyre)
        u, x = ca.SX.sym("u", layout.size), ca.SX.sym("x", len(STATES))
        motion = ca.vertcat(*model.motion(model.wheels(ca.vertsplit(u), ca.vertsplit(x))))
        self._run = Compiled("effectiveness", [u, x], [motion, ca.jacobian(motion, u)])

    def __call__(self, u: ArrayLike, x: ArrayLike) -> tuple[Floats, Floats]:
        """b (3,) and B (3, n) at commands `u` (n,) and state `x` (6,) in the order of `STATES`."""
        motion, jacobian = self._run(np.asarray(u, dtype=np.float64), np.asarray(x, dtype=np.float64))
        return motion[:, 0].copy(), jacobian.copy()


def _linear(tyre: Any, load: float, kind: TyreKind) -> Any:
    """A linear tyre with the stiffness that `tyre` has at rest; for `load` it follows the load as that of `tyre` does."""
    across = float(tyre.cornering_stiffness(load))
    # stiffness over load: 1 in proportion, 1 / (1 + q) for a degression of q
    step = 1e-4 * load
    slope = (float(tyre.cornering_stiffness(load + step)) - float(tyre.cornering_stiffness(load - step))) / (2.0 * step) * load / across
    small = tyre.forces(0.0, 1e-3, load)
    made = LinearTyre(
        nominal_load_n=load,
        cornering_stiffness_nprad=across,
        slip_stiffness_n=float(tyre.slip_stiffness(load)),
        load_degression=min(max(1.0 / max(slope, 0.1) - 1.0, 0.0), 10.0),
        pneumatic_trail_m=max(float(-small.aligning / small.lateral), 0.0),
        relaxation_longitudinal_m=0.15,  # not used here
        relaxation_lateral_m=0.3,
        rolling_radius_m=tyre.rolling_radius,
    )
    return made if kind == "load" else _AtRest(made)


class _AtRest:
    """A linear tyre at its nominal load, whatever the load."""

    def __init__(self, tyre: LinearTyre) -> None:
        self._tyre = tyre

    def slip_stiffness(self, load: Any) -> Any:
        return self._tyre.slip_stiffness(self._tyre.nominal_load_n)

    def forces(self, kappa: Any, alpha: Any, load: Any, friction: Any = 1.0) -> Any:
        return self._tyre.forces(kappa, alpha, self._tyre.nominal_load_n)
