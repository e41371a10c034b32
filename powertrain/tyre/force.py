"""What every tyre model gives back, what a tyre loses in sliding, and what the models share.

Axes and signs of the whole package, per wheel: x forward in the wheel's plane, y left, z up; forces of the road on the tyre.

* `kappa = (omega R_e - v_x) / |v_x|`, longitudinal slip: positive drives.
* `alpha = delta - atan2(v_y, v_x)`, side slip angle in rad: positive pushes to the left. Models expect `|alpha| < pi / 2`.
* `camber`: inclination of the wheel against the road in rad, right-handed about x: positive leans to the right and pushes to the right.
* `load`: wheel load in N; at or below zero every force is zero.
* `friction`: friction of the road relative to the one the tyre was described for.
"""

from __future__ import annotations

import math
import operator
from typing import Annotated, Any, NamedTuple, Protocol

import msgspec
import numpy as np

from ..description.sections import NotNegative as NotNegative
from ..description.sections import Positive as Positive
from ..errors import VehicleError

Degression = Annotated[float, msgspec.Meta(ge=0.0, le=10.0)]

#: Relaxation lengths do not fall below this share of their nominal value: a plant divides by them, and a wheel may lift.
SHORTEST_RELAXATION = 0.1


class TyreForces(NamedTuple):
    """Force of the road on a tyre in N and its moment about the vertical axis in Nm (floats, arrays or symbols)."""

    longitudinal: Any
    lateral: Any
    aligning: Any


class Tyre(Protocol):
    """What a plant, an allocator or an observer may ask of a tyre; `LinearTyre`, `MagicTyre` and `MfTyre` answer."""

    @property
    def rolling_radius(self) -> float:
        """Effective rolling radius at the nominal load, m."""
        ...

    def forces(self, kappa: Any, alpha: Any, load: Any, camber: Any = 0.0, friction: Any = 1.0) -> TyreForces:
        """Forces and aligning moment; see the module for the signs."""
        ...

    def slip_stiffness(self, load: Any) -> Any:
        """Slope of the longitudinal force over `kappa` at zero slip, N."""
        ...

    def cornering_stiffness(self, load: Any) -> Any:
        """Slope of the lateral force over `alpha` at zero slip, N/rad."""
        ...

    def relaxation(self, load: Any) -> tuple[Any, Any]:
        """Longitudinal and lateral relaxation length, m."""
        ...


def sliding_power(longitudinal: Any, lateral: Any, kappa: Any, alpha: Any, speed: Any) -> Any:
    """What forces in a contact patch do against its sliding, W: `(F_x kappa + F_y tan(alpha)) |v_x|`; see `slip_power`, which cuts it off at zero."""
    return (longitudinal * kappa + lateral * np.tan(alpha)) * speed


def slip_power(forces: TyreForces, kappa: Any, alpha: Any, speed: Any) -> Any:
    """Power that a tyre loses by sliding in its contact patch, W, not negative.

    The patch slides over the road with `v_sx = v_x - omega R_e = -kappa |v_x|` and `v_sy = -|v_x| tan(alpha)`; the loss is minus force times
    sliding velocity, `(F_x kappa + F_y tan(alpha)) |v_x|`. This is exact for the patch as one body; left out is the spin of the patch
    (aligning moment times yaw rate against the road, some watts at the parking speeds where it is largest). Rolling resistance is not in it.
    Horizontal and vertical shifts of a measured tyre make the product slightly negative next to zero slip, which no loss can be: cut off at zero.

    Args:
        forces: from a model's `forces`.
        kappa: longitudinal slip.
        alpha: side slip angle, rad.
        speed: |v_x| of the wheel's centre in the wheel's plane, m/s.
    """
    return np.maximum(sliding_power(forces.longitudinal, forces.lateral, kappa, alpha, speed), 0.0)


def load_share(load: Any, nominal: float, degression: float) -> Any:
    """Growth of a stiffness or peak with load: 0 at zero load, 1 at the nominal load, proportional for zero degression, flatter above it.

    `(1 + q) z / (1 + q z)` with `z = load / nominal` and degression q: its slope at the nominal load is `1 / (1 + q)` of the proportional one.
    Unlike the parabola `c_1 F_z - c_2 F_z^2` it never falls and never turns negative, whatever the load.
    """
    carried = np.maximum(load, 0.0)
    return (1.0 + degression) * carried / (nominal + degression * carried)


class CheckedStruct(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A struct whose `float` fields are checked when it is made by hand, too; msgspec itself checks decoded data only.

    Raises:
        VehicleError: a field that is not a number or out of its range.
    """

    def __post_init__(self) -> None:
        """Check every field with a range."""
        kind = msgspec.inspect.type_info(type(self))
        assert isinstance(kind, msgspec.inspect.StructType)
        for field in kind.fields:
            if isinstance(field.type, msgspec.inspect.FloatType):
                _check(f"{type(self).__name__}.{field.name}", getattr(self, field.name), field.type)


def _check(place: str, value: Any, kind: msgspec.inspect.FloatType) -> None:
    rules = ((">=", kind.ge, operator.ge), (">", kind.gt, operator.gt), ("<=", kind.le, operator.le), ("<", kind.lt, operator.lt))
    bounded = [(sign, bound, holds) for sign, bound, holds in rules if bound is not None]
    plain = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    if not plain or not all(holds(value, bound) for _, bound, holds in bounded):
        expected = " and ".join(f"{sign} {bound:g}" for sign, bound, _ in bounded)
        raise VehicleError(f"{place} is {value!r}, expected a number {expected}".rstrip())
