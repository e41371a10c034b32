"""MF-Tyre as a tyre of this package: signs, ranges, zero load, stiffness, relaxation, rolling."""

from __future__ import annotations

from typing import Any, Literal

import msgspec
import numpy as np

from ...errors import VehicleError
from ..force import SHORTEST_RELAXATION, TyreForces
from . import v52, v61
from .checks import findings
from .coefficients import Coefficients
from .shared import State, longitudinal_factors

#: Below this load, N, forces fall to zero in proportion: the equations divide by the load.
_LEAST_LOAD = 1.0
#: Friction below this counts as this: the equations divide by it.
_LEAST_FRICTION = 1e-3


class MfTyre(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """MF-Tyre 5.2 or 6.1, made by `read_tir`. Steady state at combined slip with camber and inflation pressure.

    The equations' own signs are ISO W; they differ from this package's in the side slip angle only, which is turned round on the way in.

    Attributes:
        name: where the coefficients come from, for messages.
        version: the equations to use.
        coefficients: of the tyre, SI.
        side: of the car where the tyre was measured (TYRESIDE); "symmetric" if the file does not say.
        mirrored: as the same tyre behaves on the other side.
        unused: keys that look like coefficients but belong to no equation here.
    """

    name: str
    version: Literal["5.2", "6.1"]
    coefficients: Coefficients
    side: Literal["left", "right", "symmetric"] = "symmetric"
    mirrored: bool = False
    unused: tuple[str, ...] = ()

    def forces(
        self, kappa: Any, alpha: Any, load: Any, camber: Any = 0.0, friction: Any = 1.0, *, pressure: Any = None, clip: bool = False
    ) -> TyreForces:
        """Forces in N and aligning moment in Nm (any broadcast shape); signs as in `powertrain.tyre.force`.

        Args:
            kappa: longitudinal slip.
            alpha: side slip angle, rad.
            load: wheel load, N; at or below zero the forces are zero, below 1 N they fall to it in proportion.
            camber: inclination, rad.
            friction: of the road, relative; multiplies LMUX and LMUY and leaves the stiffness.
            pressure: of inflation, Pa; by default the file's INFLPRES. 5.2 does not know it.
            clip: hold slips, camber, load and pressure within the file's ranges of validity instead of extrapolating.
        """
        p, turn = self.coefficients, (-1.0 if self.mirrored else 1.0)
        alpha, camber = -turn * alpha, turn * camber
        carried = np.maximum(load, 0.0)
        if clip:
            kappa, alpha = _held(kappa, p.KPUMIN, p.KPUMAX), _held(alpha, p.ALPMIN, p.ALPMAX)
            camber, carried = _held(camber, p.CAMMIN, p.CAMMAX), np.minimum(carried, p.FZMAX)
        inside = np.maximum(carried, max(p.FZMIN, _LEAST_LOAD) if clip else _LEAST_LOAD)
        state = self._state(kappa, alpha, inside, camber, np.maximum(friction, _LEAST_FRICTION), pressure, clip)
        longitudinal, lateral, aligning = (v61 if self.version == "6.1" else v52).forces(p, state)
        ramp = carried / inside
        return TyreForces(longitudinal * ramp, turn * lateral * ramp, turn * aligning * ramp)

    def slip_stiffness(self, load: Any) -> Any:
        """K_x,kappa: slope of the longitudinal curve over slip where it passes zero side slip and its shifts, N."""
        carried, inside = np.maximum(load, 0.0), np.maximum(load, _LEAST_LOAD)
        return longitudinal_factors(self.coefficients, self._state(0.0, 0.0, inside)).slope * carried / inside

    def cornering_stiffness(self, load: Any) -> Any:
        """-K_y,alpha: slope of the lateral curve over side slip angle at its shifts, upright, N/rad; positive for a real tyre."""
        carried, inside = np.maximum(load, 0.0), np.maximum(load, _LEAST_LOAD)
        version = v61 if self.version == "6.1" else v52
        return -version.cornering_slope(self.coefficients, self._state(0.0, 0.0, inside)) * carried / inside

    def relaxation(self, load: Any) -> tuple[Any, Any]:
        """Longitudinal and lateral relaxation length, m, never below a tenth of their nominal value.

        5.2: from PTX and PTY. Else, and for 5.2 without them: slip stiffness over the carcass stiffness at the ground (Besselink, Schmeitz and
        Pacejka, VSD 48 (2010), (17) to (19)).

        Raises:
            VehicleError: a file that has neither.
        """
        own = self.version == "5.2" and self.coefficients.PTX1 > 0.0 and self.coefficients.PTY1 > 0.0
        lengths = self._relaxation_52 if own else self._relaxation_61
        nominal = self.coefficients.FNOMIN * self.coefficients.LFZO
        x, y = lengths(np.maximum(load, _LEAST_LOAD))
        least_x, least_y = lengths(nominal)
        return np.maximum(x, SHORTEST_RELAXATION * least_x), np.maximum(y, SHORTEST_RELAXATION * least_y)

    def effective_radius(self, load: Any) -> Any:
        """Effective rolling radius at rest in m, from BREFF, DREFF, FREFF; the unloaded radius for a file without vertical stiffness."""
        p = self.coefficients
        if p.VERTICAL_STIFFNESS <= 0.0:
            return p.UNLOADED_RADIUS + 0.0 * load
        relative = np.maximum(load, 0.0) / p.FNOMIN
        return p.UNLOADED_RADIUS - p.FNOMIN / p.VERTICAL_STIFFNESS * (p.DREFF * np.arctan(p.BREFF * relative) + p.FREFF * relative)

    @property
    def rolling_radius(self) -> float:
        """Effective rolling radius at the nominal load, m."""
        return float(self.effective_radius(self.coefficients.FNOMIN))

    def rolling_moment(self, longitudinal: Any, load: Any, speed: Any, camber: Any = 0.0) -> Any:
        """Moment of rolling resistance against the wheel's forward turning in Nm, positive forward (4.E70; 5.2 has its first four terms).

        Args:
            longitudinal: force, N.
            load: wheel load, N.
            speed: of the wheel forward, m/s; at rest it is without moment, below 0.1 m/s it grows smoothly.
            camber: inclination, rad.
        """
        p, carried = self.coefficients, np.maximum(load, 0.0)
        v, relative = speed / p.LONGVL, carried / p.FNOMIN
        share = p.QSY1 + p.QSY2 * longitudinal / p.FNOMIN + p.QSY3 * abs(v) + p.QSY4 * v**4 + (p.QSY5 + p.QSY6 * relative) * camber**2
        pressure = (p.INFLPRES / p.NOMPRES) ** p.QSY8 if p.INFLPRES > 0.0 and p.NOMPRES > 0.0 else 1.0
        share = share * np.maximum(relative, 1e-9) ** p.QSY7 * pressure
        return carried * p.UNLOADED_RADIUS * share * p.LMY * np.tanh(speed / 0.05)

    def on(self, side: Literal["left", "right"]) -> MfTyre:
        """The tyre as it behaves on that side of the car: mirrored if it was measured on the other."""
        return msgspec.structs.replace(self, mirrored=self.side not in (side, "symmetric"))

    def check(self) -> list[str]:
        """What is out of physics in the coefficients, one line each; empty for a sound tyre."""
        return findings(self.version, self.coefficients, self.unused)

    def _state(self, kappa: Any, alpha: Any, load: Any, camber: Any = 0.0, friction: Any = 1.0, pressure: Any = None, clip: bool = False) -> State:
        p = self.coefficients
        if self.version == "5.2":
            return State(kappa, alpha, alpha, load, camber, camber, friction)
        now = (p.INFLPRES or p.NOMPRES) if pressure is None else pressure
        now = _held(now, p.PRESMIN, p.PRESMAX) if clip else now
        increment = (now - p.NOMPRES) / p.NOMPRES if p.NOMPRES > 0.0 else 0.0
        return State(kappa, alpha, np.tan(alpha), load, camber, np.sin(camber), friction, increment)

    def _relaxation_52(self, load: Any) -> tuple[Any, Any]:
        p, dfz = self.coefficients, self._state(0.0, 0.0, load).dfz(self.coefficients)
        nominal = p.FNOMIN * p.LFZO
        x = load * (p.PTX1 + p.PTX2 * dfz) * np.exp(-p.PTX3 * dfz) * p.UNLOADED_RADIUS / nominal * p.LSGKP
        return x, p.PTY1 * np.sin(2.0 * np.arctan(load / (p.PTY2 * nominal))) * p.UNLOADED_RADIUS * p.LFZO * p.LSGAL

    def _relaxation_61(self, load: Any) -> tuple[Any, Any]:
        p, state = self.coefficients, self._state(0.0, 0.0, load)
        if p.LONGITUDINAL_STIFFNESS <= 0.0 or p.LATERAL_STIFFNESS <= 0.0:
            raise VehicleError(f"{self.name}: LONGITUDINAL_STIFFNESS or LATERAL_STIFFNESS is missing, expected both for relaxation lengths")
        dfz, dpi = state.dfz(p), state.pressure
        along = p.LONGITUDINAL_STIFFNESS * (1.0 + p.PCFX1 * dfz + p.PCFX2 * dfz**2) * (1.0 + p.PCFX3 * dpi)
        across = p.LATERAL_STIFFNESS * (1.0 + p.PCFY1 * dfz + p.PCFY2 * dfz**2) * (1.0 + p.PCFY3 * dpi)
        return abs(self.slip_stiffness(load) / along), abs(self.cornering_stiffness(load) / across)


def _held(value: Any, least: float, most: float) -> Any:
    return np.minimum(np.maximum(value, least), most)
