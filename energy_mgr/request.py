"""What a user asks of a plan, as one object that is handed on whole."""

from __future__ import annotations

import math
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass, replace
from numbers import Real
from typing import TYPE_CHECKING, Any, Literal, TypedDict, get_args

import numpy as np

from roads.road import Extent

from .errors import PlanningError
from .path import End, PathOptions, Weights
from .path.planner import PathKind
from .speed import DriveRules, Window

if TYPE_CHECKING:
    from collections.abc import Mapping

    from powertrain import Vehicle

SpeedKind = Literal["fast", "toppra", "eco", "socp", "dp", "nlp"]
PlanMethod = Literal["sequential", "joint"]

_CHOICES = {"corridor": get_args(Extent), "path": get_args(PathKind), "speed": get_args(SpeedKind), "method": get_args(PlanMethod)}


class PlanWishes(TypedDict, total=False):
    """The fields of `PlanRequest` as keywords of `plan`, `plan_front` and `joint_plan`."""

    corridor: Extent
    path: PathKind
    speed: SpeedKind
    method: PlanMethod
    journey_time: float | None
    price: float | None
    soc: float | None
    rules: DriveRules
    margin: float
    path_options: PathOptions


@dataclass(frozen=True)
class PlanRequest:
    """What a user asks of a plan; one request serves many roads and cars.

    Attributes:
        corridor: what the car may use: `lane`, `own` (all lanes that lead its way) or `road` (edge to edge).
        path: `optimal` (least curvature) or `lane` (its centre).
        speed: `eco` (least energy at the arrival time), `fast` (V1; with a time scaled to it, V2), or another method of `speed.plan_speed`.
        method: `sequential` (path, then speed) or `joint` (both at once, warm started by the sequential plan; `eco` on the optimal path).
        journey_time: arrival time in s; by default the least time that the lane centre and the optimal path can both make (`eco`), which nearly
            always is that of the lane centre, or the least possible (`fast`).
        price: of time, W, instead of an arrival time: the drive is the thriftiest one plus this for every second.
        soc: charge at the start, 0 to 1: the battery's power bounds the drive, and the arrival is put off until the charge lasts.
        rules: what else bounds the drive: stops, windows, jerk, grip, friction brakes, speeds at the ends.
        margin: distance kept between the car's side and the borders, m.
        path_options: how the path is found.

    Raises:
        PlanningError: a value out of range, or wishes that exclude each other.
    """

    corridor: Extent = "own"
    path: PathKind = "optimal"
    speed: SpeedKind = "eco"
    method: PlanMethod = "sequential"
    journey_time: float | None = None
    price: float | None = None
    soc: float | None = None
    rules: DriveRules = field(default_factory=DriveRules)
    margin: float = 0.2
    path_options: PathOptions = field(default_factory=PathOptions)

    def __post_init__(self) -> None:
        for name, allowed in _CHOICES.items():
            if getattr(self, name) not in allowed:
                raise PlanningError(f"{name} {getattr(self, name)!r}, expected one of {', '.join(allowed)}")
        for name, kind in (("rules", DriveRules), ("path_options", PathOptions)):
            if not isinstance(getattr(self, name), kind):
                raise PlanningError(f"{name} {getattr(self, name)!r}, expected {kind.__name__}")
        for name in ("margin", "journey_time", "price", "soc"):
            value = getattr(self, name)
            if not (isinstance(value, Real) or (value is None and name != "margin")):
                raise PlanningError(f"{name} {value!r}, expected a number")
        if not 0.0 <= self.margin < 100.0:
            raise PlanningError(f"margin {self.margin} m, expected 0 to 100 m")
        if self.journey_time is not None and not 0.0 < self.journey_time < 1e7:
            raise PlanningError(f"arrival time {self.journey_time} s, expected more than 0 and less than 1e7 s")
        if self.price is not None and not 0.0 <= self.price < 1e9:
            raise PlanningError(f"price of time {self.price} W, expected 0 to 1e9 W")
        if self.soc is not None and not 0.0 <= self.soc <= 1.0:
            raise PlanningError(f"state of charge {self.soc}, expected 0 to 1")
        if self.price is not None and (self.journey_time is not None or self.speed not in ("eco", "dp") or self.method == "joint"):
            found = f"price of time {self.price} W with speed {self.speed}, arrival time {self.journey_time}, method {self.method}"
            raise PlanningError(f"{found}; expected speed eco or dp, no arrival time, method sequential")
        if self.method == "joint" and (self.path != "optimal" or self.speed != "eco"):
            raise PlanningError(f"method joint with path {self.path} and speed {self.speed}, expected optimal and eco")
        if self.speed == "fast" and (self.rules.jerk is not None or self.rules.windows):
            raise PlanningError("speed fast knows no limit of jerk and no windows, expected eco or nlp")
        if self.soc is not None and self.speed != "eco":
            raise PlanningError(f"a state of charge with speed {self.speed}, expected speed eco")

    def refuse_beside(self, what: str, *counting: str) -> None:
        """Refuse wishes that do not count for `what`, whose fields are named: they would be passed over without a word.

        Raises:
            PlanningError: a field beside these that is not as by default.
        """
        for one in fields(self):
            if one.name not in counting and getattr(self, one.name) != _default(one):
                raise PlanningError(f"{one.name} {getattr(self, one.name)!r} means nothing for {what}, expected it left out")

    def clearance(self, vehicle: Vehicle) -> float:
        """Distance of the car's centre line from the borders, m."""
        return 0.5 * vehicle.chassis.width_m + self.margin

    def options_for(self, vehicle: Vehicle) -> PathOptions:
        """How the path is found, with no more curvature than the car can steer."""
        radius, options = vehicle.limits.turning_radius_min_m, self.path_options
        return options if radius is None else replace(options, curvature_max=min(options.curvature_max, 1.0 / radius))

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, words, lists and dictionaries, as JSON and TOML have them; what is as by default is left out.

        Raises:
            PlanningError: the rules hold parts of one's own, which are code.
        """
        if self.rules.parts:
            raise PlanningError("rules.parts are code and cannot be written down, expected stops, windows, jerk, grip or friction_brakes")
        return _plain(self)

    @classmethod
    def from_dict(cls, found: Mapping[str, Any]) -> PlanRequest:
        """The request that `to_dict` wrote down, or one like it.

        Raises:
            PlanningError: an unknown key, or a value of the wrong kind or out of range; named with its dotted key.
        """
        return _made(cls, found, "")


def requested(request: PlanRequest | None, wishes: PlanWishes) -> PlanRequest:
    """A request and keywords beside it as one request; `None` among the keywords leaves what the request, or the default, has.

    Raises:
        TypeError: an unknown keyword.
        PlanningError: as `PlanRequest`.
    """
    for name in wishes:
        if name not in PlanRequest.__dataclass_fields__:
            raise TypeError(f"unexpected keyword {name!r}, expected one of {', '.join(PlanRequest.__dataclass_fields__)}")
    given = {name: value for name, value in wishes.items() if value is not None}
    return replace(request or PlanRequest(), **given) if given or request is None else request


# -- as plain data ----------------------------------------------------------------------------------------------------------------------

#: What a key holds besides numbers and words, by its dotted name.
_INSIDE: dict[str, type] = {"rules": DriveRules, "path_options": PathOptions, "path_options.weights": Weights}
_WORDS = {*_CHOICES, "path_options.method", "path_options.qp"}
_FLAGS = {"rules.friction_brakes"}
_WHOLE = {"path_options.control_points"}
#: Not read: code, and what only retries set.
_HIDDEN = {"rules.parts", "path_options.density"}


def _default(one: Field[Any]) -> Any:
    return one.default_factory() if one.default_factory is not MISSING else one.default


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        found = {}
        for one in fields(value):
            if one.name == "density":  # what only retries set
                continue
            own = getattr(value, one.name)
            if own != _default(one):
                found[one.name] = _plain(own)
        return found
    if isinstance(value, Window) and math.isinf(value.latest):
        return [float(value.s), float(value.earliest)]
    if isinstance(value, list | tuple):
        # TOML has no null: an end that is left free is an empty table
        return [{} if one is None else _plain(one) for one in value]
    return value.item() if isinstance(value, np.generic) else value


def _made(kind: Any, found: Any, prefix: str) -> Any:
    if not hasattr(found, "items"):
        raise PlanningError(f"{prefix.rstrip('.')} is {found!r}, expected a table of keys")
    known = [one.name for one in fields(kind) if prefix + one.name not in _HIDDEN]
    given = {}
    for name, value in found.items():
        if name not in known:
            raise PlanningError(f"unknown key {prefix + str(name)!r}, expected one of {', '.join(prefix + one for one in known)}")
        given[name] = _value(prefix + name, value)
    try:
        return kind(**given)
    except PlanningError as error:
        raise PlanningError(f"{prefix.rstrip('.')}: {error}" if prefix else str(error)) from None


def _value(key: str, value: Any) -> Any:
    """A plain value as the field of that dotted key has it."""
    if key in _INSIDE:
        return _made(_INSIDE[key], value, key + ".")
    if key == "rules.stops":
        return tuple(_number(key, one) for one in _list(key, value))
    if key == "rules.windows":
        return tuple(Window(*(_number(key, number) for number in _list(key, one, 2, 3))) for one in _list(key, value))
    if key == "path_options.ends":
        return tuple(None if one is None or one == {} else _made(End, one, "path_options.ends.") for one in _list(key, value, 2))
    if key in _WORDS or (key == "path_options.knots" and isinstance(value, str)):
        if not isinstance(value, str):
            raise PlanningError(f"{key} is {value!r}, expected a word")
        return value
    if key in _FLAGS:
        if not isinstance(value, bool):
            raise PlanningError(f"{key} is {value!r}, expected true or false")
        return value
    if key in _WHOLE:
        if not isinstance(value, int) or isinstance(value, bool):
            raise PlanningError(f"{key} is {value!r}, expected a whole number")
        return value
    return _number(key, value)


def _list(key: str, value: Any, *counts: int) -> Any:
    if not isinstance(value, list | tuple) or (counts and len(value) not in counts):
        raise PlanningError(f"{key} has {value!r}, expected a list" + (" of " + " or ".join(map(str, counts)) if counts else ""))
    return value


def _number(key: str, value: Any) -> float:
    if not isinstance(value, Real) or isinstance(value, bool) or math.isnan(value):
        raise PlanningError(f"{key} is {value!r}, expected a number")
    return float(value)
