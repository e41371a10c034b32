"""Quarter car (X1): one wheel and its share of the body on a road, with a semi-active damper behind a rocker.

    s_rel = i (z_b - z_w)                                       deflection of spring and damper through the rocker's ratio i
    m_b z_b'' = - i (c_s s_rel + F_d) - F_f                     F_f = F_c tanh((v_b - v_w) / eps)        (B.1)
    m_w z_w'' = + i (c_s s_rel + F_d) + F_f - c_t (z_w - z_r) - d_t (v_w - z_r')
    z_r' = - omega_r z_r + w_r                                  road as filtered noise

All displacements are from rest, upwards. The damper gives F_d = d(u) s_rel', d between its soft and hard setting.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import numpy as np

from ..description.sections import NotNegative, Positive, Section
from ..vehicle import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Sequence


class QuarterCar(Section, frozen=True, kw_only=True):
    """Parameters and equations of a quarter car; defaults are a quarter of the ROMO with its wheel to body mass ratio of 1 : 4."""

    body_mass_kg: Positive = 202.6
    wheel_mass_kg: Positive = 50.65
    spring_npm: Positive = 25e3
    damper_soft_nspm: NotNegative = 800.0
    damper_hard_nspm: NotNegative = 3000.0
    rocker_ratio: Positive = 0.81
    tyre_npm: Positive = 190e3
    tyre_nspm: NotNegative = 100.0
    friction_n: NotNegative = 20.0
    friction_step_mps: Annotated[float, msgspec.Meta(gt=0.0)] = 0.01
    road_pole_radps: Positive = 2.0

    @property
    def states(self) -> tuple[str, ...]:
        """Heights and velocities of wheel and body, height of the road: m, m/s."""
        return "z_w", "v_w", "z_b", "v_b", "z_r"

    @property
    def inputs(self) -> tuple[str, ...]:
        """Damper setting from 0 (soft) to 1 (hard), and the road's excitation in m/s."""
        return "damper", "road"

    @property
    def outputs(self) -> tuple[str, ...]:
        """What is measured: body acceleration, damper deflection, wheel acceleration; and the contact force as a check."""
        return "acceleration_body", "deflection", "acceleration_wheel", "contact_force"

    def derivative(self, x: Sequence[Any], u: Sequence[Any]) -> list[Any]:
        """d x/dt for states and inputs in their order: numbers, arrays or CasADi symbols."""
        z_w, v_w, _, v_b, z_r = x
        strut, road_rate = self._strut(x, u), u[1] - self.road_pole_radps * z_r
        tyre = self.tyre_npm * (z_w - z_r) + self.tyre_nspm * (v_w - road_rate)
        return [v_w, (strut - tyre) / self.wheel_mass_kg, v_b, -strut / self.body_mass_kg, road_rate]

    def output(self, x: Sequence[Any], u: Sequence[Any]) -> list[Any]:
        """The outputs in their order, m/s^2, m, m/s^2, N; the contact force includes the static load."""
        rate = self.derivative(x, u)
        static = (self.body_mass_kg + self.wheel_mass_kg) * GRAVITY
        contact = static + self.tyre_npm * (x[4] - x[0]) + self.tyre_nspm * (rate[4] - x[1])
        return [rate[3], self.rocker_ratio * (x[2] - x[0]), rate[1], contact]

    def _strut(self, x: Sequence[Any], u: Sequence[Any]) -> Any:
        """Force between body and wheel in N, positive when it pulls them together."""
        z_w, v_w, z_b, v_b, _ = x
        damping = self.damper_soft_nspm + (self.damper_hard_nspm - self.damper_soft_nspm) * u[0]
        through = self.rocker_ratio**2 * (self.spring_npm * (z_b - z_w) + damping * (v_b - v_w))
        return through + self.friction_n * np.tanh((v_b - v_w) / self.friction_step_mps)
