"""The tracking laws by name."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import Any

from ..errors import PlanningError
from .geometric import GeometricLaw
from .law import TrackingLaw
from .linearising import LinearisingLaw
from .pd import PdLaw

#: Each is made as law(vehicle, gains), gains None for its defaults.
LAWS: MappingProxyType[str, Callable[..., TrackingLaw]] = MappingProxyType({"pd": PdLaw, "geometric": GeometricLaw, "linearising": LinearisingLaw})


def make_law(name: str, vehicle: Any, gains: Any = None) -> TrackingLaw:
    """The law of that name.

    Raises:
        PlanningError: there is none.
    """
    if name not in LAWS:
        raise PlanningError(f"tracking law {name!r}, expected one of {', '.join(LAWS)}")
    return LAWS[name](vehicle, gains)
