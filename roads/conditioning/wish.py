"""How a recording is to be taken."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import RoadError


@dataclass(frozen=True)
class Wish:
    """How a recording is to be taken.

    Attributes:
        raw: as it is; only repeated points are left out.
        plane: root mean square distance of the recorded places from the line, m; None: found from the recording.
        height: the same for heights, m.
        leg: which of the ways that it consists of, from 1; None: the longest.

    Raises:
        RoadError: an accuracy or a number out of range.
    """

    raw: bool = False
    plane: float | None = None
    height: float | None = None
    leg: int | None = None

    def __post_init__(self) -> None:
        for name in ("plane", "height"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value <= 100.0:
                raise RoadError(f"accuracy in the {name} {value} m, expected more than 0 and at most 100")
        if self.raw and (self.plane is not None or self.height is not None):
            raise RoadError("raw with an accuracy, expected one of them: raw data are not smoothed")
        if self.raw and self.leg is not None:
            raise RoadError(f"raw with leg {self.leg}, expected one of them: raw data are taken whole")
        if self.leg is not None and self.leg < 1:
            raise RoadError(f"leg {self.leg}, expected 1 or more")
