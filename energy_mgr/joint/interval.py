"""One interval of the joint problem as a small CasADi function: what it costs and what it must keep, from path and speed together.

Path: first and second derivative p, b of the spline at start, middle and end are linear in six variables; from them

    ds = dq / 6 (|p0| + 4 |pm| + |p1|)        way (Simpson)
    kappa = (p x b) / |p|^3                   curvature (3.11)

Speed: v^2 is linear over the way, with v0 and v1 at the ends. The energy is that of `powertrain.energy.balance`; |tau|, which is not smooth, enters
by its positive and negative part `pull` and `push`, exact at the optimum because loss grows with both.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec

from powertrain import driving_resistance
from powertrain.energy.balance import balance
from powertrain.energy.motor import gear_factor, inverter_factor
from powertrain.symbolic import ca

from ..path.problem.spline import PER_KNOT
from .grid import PLACES

if TYPE_CHECKING:
    from powertrain import Vehicle

#: Local variables: six of the path, v0, v1, pull, push.
PATH_SIZE = 2 * PER_KNOT
SIZE = PATH_SIZE + 4
_PAIRS = 2 * PLACES
#: Names of what an interval gives, one row each: energy and time, then what is bounded.
OUTPUTS = (
    "energy",
    "time",
    "force_gap",
    "gain",
    "lateral_start",
    "lateral_after",
    "lateral_before",
    "lateral_end",
    "force_start",
    "force_end",
    "power_start",
    "power_end",
    "bend_start",
    "bend_middle",
    "bend_end",
)


class Scales(NamedTuple):
    """Units of the problem, chosen such that all numbers in it are of order one.

    Attributes:
        speed: m/s.
        force: N.
        energy: J.
        power: W.
        lateral: the bound on lateral acceleration, m/s^2.
        curvature: the bound on curvature, 1/m; infinite for none.
    """

    speed: float
    force: float
    energy: float
    power: float
    lateral: float
    curvature: float


def smooth(vehicle: Vehicle) -> Vehicle:
    """The car without the losses that go with |tau|, which are added through `pull` and `push`."""
    return msgspec.structs.replace(vehicle, drive=msgspec.structs.replace(vehicle.drive, inverter_per_current_wpa=0.0, gear_efficiency=1.0))


def interval_function(vehicle: Vehicle, scales: Scales) -> Any:
    """The CasADi function of local variables (10,) and of a column of `Grid.table` (80,) that gives a column of `OUTPUTS` (15,)."""
    local = ca.SX.sym("local", SIZE)
    table = ca.SX.sym("table", 2 + _PAIRS * (2 * PATH_SIZE + 1))
    dq, dz = table[0], table[1]
    p, b = _derivatives(local[:PATH_SIZE], table[2:])
    rates = [ca.sqrt(px**2 + py**2) for px, py in p]
    ds = dq / 6.0 * (rates[0] + 4.0 * rates[1] + rates[2])
    kappa = [(px * by - py * bx) / rate**3 for (px, py), (bx, by), rate in zip(p, b, rates, strict=True)]
    v0, v1 = scales.speed * local[PATH_SIZE], scales.speed * local[PATH_SIZE + 1]
    pull, push = local[PATH_SIZE + 2], local[PATH_SIZE + 3]
    found = balance(smooth(vehicle), ds, v0, v1, dz)
    per_force = inverter_factor(vehicle) / vehicle.motor_ratio
    energy = sum(found.energies.values()) + (pull + push) * scales.force * (per_force * found.time + gear_factor(vehicle) * ds)
    gain = (v1**2 - v0**2) / (2.0 * ds)
    forces = [vehicle.effective_mass * gain + driving_resistance(vehicle, v, dz / ds) for v in (v0, v1)]
    rows = [energy / scales.energy, found.time, found.force / scales.force - pull + push, gain]
    # the middle binds the speeds at both ends, not the one between: that is how `SpeedLimits` counts on stations half as far apart
    bends = ((kappa[0], v0), (kappa[1], v0), (kappa[1], v1), (kappa[2], v1))
    rows += [bend * v**2 / scales.lateral for bend, v in bends]
    rows += [force / scales.force for force in forces]
    rows += [force * v / scales.power for force, v in zip(forces, (v0, v1), strict=True)]
    rows += [bend / scales.curvature for bend in kappa]
    return ca.Function("interval", [local, table], [ca.vertcat(*rows)])


def _derivatives(path: Any, maps: Any) -> tuple[list[Any], list[Any]]:
    """First and second derivative of the path at the three places, as pairs."""
    size, constant = PATH_SIZE * _PAIRS, PATH_SIZE * _PAIRS + _PAIRS
    first = [ca.dot(maps[PATH_SIZE * k : PATH_SIZE * (k + 1)], path) + maps[size + k] for k in range(_PAIRS)]
    second = [ca.dot(maps[constant + PATH_SIZE * k : constant + PATH_SIZE * (k + 1)], path) for k in range(_PAIRS)]
    return [(first[2 * k], first[2 * k + 1]) for k in range(PLACES)], [(second[2 * k], second[2 * k + 1]) for k in range(PLACES)]
