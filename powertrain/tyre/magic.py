"""The magic formula tyre: one measured curve, combined slip by similarity, cheap enough for the inside of a plant's step.

The curve is (C.4) of the observer model O1, `F = D sin(C atan(B s - E (B s - atan(B s))))`. Combined slip follows the similarity method
(Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, section 4.2): both slips are normalised by where their own curve would reach the same share of
its peak, the length of the normalised slip enters the curve, and the force points along it. So the friction ellipse is kept exactly, and each
pure slip is the plain formula. Friction and load scale the peak; a changed friction leaves the stiffness at zero slip, which belongs to the
rubber and not to the road.
"""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
import numpy as np

from ..errors import VehicleError
from .force import SHORTEST_RELAXATION, CheckedStruct, Degression, NotNegative, Positive, TyreForces, load_share

#: Added to the squared normalised slip: the share of the force in the slip is then smooth where both are zero. It changes forces by 1e-12 D.
_SMALLEST_SLIP = 1e-6
#: Friction below this counts as this: the normalised slip is divided by it.
_SMALLEST_FRICTION = 1e-6


class MagicTyre(CheckedStruct, frozen=True, kw_only=True, tag_field="model", tag="magic"):
    """One wheel's tyre. Peaks and lengths at the nominal load.

    The defaults of the curve are O1's fit of the ROMO with `peak_n` half an axle's 7247 N (specification, table C.4 with erratum 34).

    Attributes:
        nominal_load_n: wheel load that the peaks belong to.
        stiffness_factor: B of the lateral curve, 1/rad.
        shape_factor: C, of both curves.
        curvature_factor: E, of both curves, at most 1.
        peak_n: D of the lateral curve.
        longitudinal_peak_n: D of the longitudinal curve.
        slip_stiffness_n: slope of the longitudinal curve at zero slip; its B follows.
        load_degression: 0 lets the peaks grow in proportion to load; `q` cuts the growth at the nominal load to 1 / (1 + q) of that.
        camber_slip: side slip angle that pushes as much as a unit of camber does.
        pneumatic_trail_m: distance of the lateral force behind the wheel's centre at zero slip, in proportion to load.
        relaxation_longitudinal_m: rolled way after which 63 % of a longitudinal force has built up.
        relaxation_lateral_m: the same for the lateral force.
        rolling_radius_m: effective rolling radius.
    """

    nominal_load_n: Positive
    stiffness_factor: Annotated[float, msgspec.Meta(gt=0.0, le=100.0)] = 5.1088547
    shape_factor: Annotated[float, msgspec.Meta(ge=1.0, le=2.5)] = 2.0280
    curvature_factor: Annotated[float, msgspec.Meta(ge=-100.0, le=1.0)] = 0.8903703
    peak_n: Positive = 3623.5
    longitudinal_peak_n: Positive = 3623.5
    slip_stiffness_n: Positive = 60e3
    load_degression: Degression = 0.0
    camber_slip: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    pneumatic_trail_m: NotNegative = 0.03
    relaxation_longitudinal_m: Positive
    relaxation_lateral_m: Positive
    rolling_radius_m: Positive

    def __post_init__(self) -> None:
        """Check the fields and that the curve stays positive up to broadside slip."""
        CheckedStruct.__post_init__(self)
        if self._curve(self._broadside) <= 0.0:
            raise VehicleError(
                f"MagicTyre: stiffness {self.stiffness_factor:g}, shape {self.shape_factor:g} and curvature factor {self.curvature_factor:g} "
                "turn the side force round below a slip angle of 90 degrees, expected a curve that is positive up to there"
            )

    def forces(self, kappa: Any, alpha: Any, load: Any, camber: Any = 0.0, friction: Any = 1.0) -> TyreForces:
        """Forces in N and aligning moment in Nm (any broadcast shape); signs as in `powertrain.tyre.force`.

        Beyond the slip of a wheel that is pushed broadside the force stays what it is there: sliding friction. The trail falls with the square of
        the share that the secant stiffness has of the one at zero slip: to 1/8 at the peak for the default curve, to nothing in full sliding.
        """
        carried = np.maximum(load, 0.0)
        along = self.slip_stiffness_n / (self.shape_factor * self.longitudinal_peak_n) * kappa
        across = self.stiffness_factor * (alpha - self.camber_slip * camber)
        slip = np.sqrt(along * along + across * across + _SMALLEST_SLIP**2) / np.maximum(friction, _SMALLEST_FRICTION)
        gain = self._curve(np.minimum(slip, self._broadside)) / slip
        scaled = load_share(carried, self.nominal_load_n, self.load_degression) * gain
        lateral = self.peak_n * across * scaled
        lever = -self.pneumatic_trail_m / (self.shape_factor**2 * self.nominal_load_n)
        return TyreForces(self.longitudinal_peak_n * along * scaled, lateral, lever * carried * gain * gain * lateral)

    def slip_stiffness(self, load: Any) -> Any:
        """Slope of the longitudinal force over slip at zero slip, N."""
        return self.slip_stiffness_n * load_share(load, self.nominal_load_n, self.load_degression)

    def cornering_stiffness(self, load: Any) -> Any:
        """Slope of the lateral force over side slip angle at zero slip, B C D, N/rad."""
        nominal = self.stiffness_factor * self.shape_factor * self.peak_n
        return nominal * load_share(load, self.nominal_load_n, self.load_degression)

    def relaxation(self, load: Any) -> tuple[Any, Any]:
        """Longitudinal and lateral relaxation length in m: they grow as the stiffness does, the carcass staying the same."""
        share = np.maximum(load_share(load, self.nominal_load_n, self.load_degression), SHORTEST_RELAXATION)
        return self.relaxation_longitudinal_m * share, self.relaxation_lateral_m * share

    @property
    def rolling_radius(self) -> float:
        """Effective rolling radius, m."""
        return self.rolling_radius_m

    @property
    def _broadside(self) -> float:
        return 0.5 * np.pi * self.stiffness_factor

    def _curve(self, x: Any) -> Any:
        """Share of the peak at normalised slip `x`."""
        return np.sin(self.shape_factor * np.arctan(x - self.curvature_factor * (x - np.arctan(x))))
