"""The linear tyre: force proportional to slip, stiffness growing less than in proportion to load.

Valid for moderate driving (about |a_y| < 4 m/s^2 on a dry road). There is no saturation in it: neither the friction circle nor its limits are
kept, and longitudinal and lateral force do not know of each other. Two multiplications per force: for allocators and linear observers.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .force import SHORTEST_RELAXATION, CheckedStruct, Degression, NotNegative, Positive, TyreForces, load_share


class LinearTyre(CheckedStruct, frozen=True, kw_only=True, tag_field="model", tag="linear"):
    """One wheel's tyre, linear in slip. Values at the nominal load.

    Attributes:
        nominal_load_n: wheel load that the other values belong to.
        cornering_stiffness_nprad: lateral force per side slip angle.
        slip_stiffness_n: longitudinal force per unit of slip.
        load_degression: 0 lets stiffness grow in proportion to load; `q` cuts the growth at the nominal load to 1 / (1 + q) of that.
        camber_stiffness_nprad: lateral force per camber angle, towards the side that the wheel leans to.
        pneumatic_trail_m: distance of the lateral force behind the wheel's centre.
        relaxation_longitudinal_m: rolled way after which 63 % of a longitudinal force has built up.
        relaxation_lateral_m: the same for the lateral force.
        rolling_radius_m: effective rolling radius.
    """

    nominal_load_n: Positive
    cornering_stiffness_nprad: Positive
    slip_stiffness_n: Positive
    load_degression: Degression = 0.0
    camber_stiffness_nprad: NotNegative = 0.0
    pneumatic_trail_m: NotNegative = 0.0
    relaxation_longitudinal_m: Positive
    relaxation_lateral_m: Positive
    rolling_radius_m: Positive

    def forces(self, kappa: Any, alpha: Any, load: Any, camber: Any = 0.0, friction: Any = 1.0) -> TyreForces:
        """Forces in N and aligning moment in Nm (any broadcast shape); signs as in `powertrain.tyre.force`.

        A line has no peak for friction to lower, so `friction` scales the force itself.
        """
        scale = load_share(load, self.nominal_load_n, self.load_degression) * friction
        lateral = scale * (self.cornering_stiffness_nprad * alpha - self.camber_stiffness_nprad * camber)
        return TyreForces(scale * self.slip_stiffness_n * kappa, lateral, -self.pneumatic_trail_m * lateral)

    def slip_stiffness(self, load: Any) -> Any:
        """Slope of the longitudinal force over slip at zero slip, N."""
        return self.slip_stiffness_n * load_share(load, self.nominal_load_n, self.load_degression)

    def cornering_stiffness(self, load: Any) -> Any:
        """Slope of the lateral force over side slip angle at zero slip, N/rad."""
        return self.cornering_stiffness_nprad * load_share(load, self.nominal_load_n, self.load_degression)

    def relaxation(self, load: Any) -> tuple[Any, Any]:
        """Longitudinal and lateral relaxation length in m: they grow as the stiffness does, the carcass staying the same."""
        share = np.maximum(load_share(load, self.nominal_load_n, self.load_degression), SHORTEST_RELAXATION)
        return self.relaxation_longitudinal_m * share, self.relaxation_lateral_m * share

    @property
    def rolling_radius(self) -> float:
        """Effective rolling radius, m."""
        return self.rolling_radius_m
