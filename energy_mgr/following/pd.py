"""The published tracking law F2: three separate PD controllers, (3.23), (3.24) and yaw, with constant gains.

Reading (ii) of the interface: wanted accelerations = feed-forward (v v', kappa v^2, kappa' v^2 + kappa dv/dt) + PD. Derivatives of the errors are
analytic, from measured velocities (that of the speed from the measured acceleration), so nothing has to be filtered. As published there is no
scheduling, no supervision and no integral action: a large error, a low grip or a standing car beside its path asks for whatever the gains give.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..motion import MotionDemand
from .law import STOP_ZONE, Course, Resistances

if TYPE_CHECKING:
    from powertrain import Vehicle

    from ..motion import VehicleState
    from .projected import Projected


@dataclass(frozen=True)
class PdGains:
    """Constant gains; the source gives none. Lateral poles at 2 1/s, yaw poles at 4 1/s, both double.

    Attributes:
        k_px: speed, 1/s.
        k_dx: its derivative, 1.
        k_py, k_dy: offset, 1/s^2, and its derivative, 1/s.
        k_ppsi, k_dpsi: heading, 1/s^2, and its derivative, 1/s.
        feedforward: add driving resistances, slope and bank.
    """

    k_px: float = 1.5
    k_dx: float = 0.05
    k_py: float = 4.0
    k_dy: float = 4.0
    k_ppsi: float = 16.0
    k_dpsi: float = 8.0
    feedforward: bool = True


class PdLaw:
    """Three PDs; has no state."""

    def __init__(self, vehicle: Vehicle, gains: PdGains | None = None) -> None:
        self.gains = gains or PdGains()
        self.supervised = False
        self._resistances = Resistances(vehicle) if self.gains.feedforward else None

    def demand(self, state: VehicleState, at: Projected, dt: float) -> MotionDemand:
        """As `TrackingLaw`; the errors are path minus car, as printed."""
        g, c = self.gains, Course.of(state, at)
        wanted, feed = (0.0, 0.0) if at.to_go <= STOP_ZONE else (at.point.v, at.point.a)
        along = feed * c.sdot / max(wanted, 0.1) if feed < 0.0 else feed
        a_x = along + g.k_px * (wanted - state.v_x) + g.k_dx * (along - state.a_x - state.yaw_rate * state.v_y)
        # (3.24): path minus car along the car's own left axis; that axis turns with the yaw rate
        left = at.e_x * c.sin - at.e_y * c.cos
        left_rate = -at.sdot * c.sin - state.v_y + state.yaw_rate * (at.e_x * c.cos + at.e_y * c.sin)
        a_y = c.kappa * state.v_x**2 + g.k_py * left + g.k_dy * left_rate
        turn = c.kappa_rate * state.v_x**2 + c.kappa * along
        yaw = turn - g.k_ppsi * at.e_psi + g.k_dpsi * (c.kappa * at.sdot - state.yaw_rate)
        if self._resistances is None:
            return MotionDemand(a_x, a_y, yaw)
        return self._resistances.demand(a_x, a_y, yaw, state, at)

    def achieved(self, demand: MotionDemand, given: MotionDemand) -> None:
        """Nothing to do: there is no integral action."""

    def adapt(self, lean: float, pace: float) -> None:
        """As `TrackingLaw`: this law knows no faults."""

    def reset(self) -> None:
        """Nothing to do."""

    def snapshot(self) -> tuple[Any, ...]:
        """Empty."""
        return ()

    def restore(self, snapshot: tuple[Any, ...]) -> None:
        """Nothing to do."""
