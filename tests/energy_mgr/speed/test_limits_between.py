"""Every limit looked at again every 0.1 m, in plain sums that share nothing with the package's own checks.

Between two stations speed squared is linear. Slope is what the plan knows: height is linear between its stations too.
"""

import numpy as np
import pytest

import roads
from energy_mgr import SpeedLimits, plan_path
from energy_mgr.path import Path
from energy_mgr.speed import (
    BatteryPower,
    Comfort,
    EcoSolver,
    FrictionBrakes,
    Grip,
    Jerk,
    Lateral,
    Motors,
    Posted,
    SpeedProfile,
    eco_profile,
    fastest_profile,
    scaled_profile,
)
from energy_mgr.speed.bounds.parts import Part
from powertrain import Vehicle, driving_resistance, force_limits, load_vehicle, motor_losses
from powertrain.drive.supply import converter_input
from powertrain.vehicle import GRAVITY
from roads import Road
from tests.conftest import DATA

from .rig import driven_share

TRACKS = ("BrandsHatch", "Hockenheim", "Norisring", "Oschersleben", "Spielberg", "Zandvoort")
FOLDER = DATA / "roads" / "tum"
TOLERANCE = 1e-3
MU, GIVE, TAKE, BRAKE = 0.7, 4e4, 2e4, 3000.0
SETS: dict[str, list[Part]] = {
    "standard": [Posted(), Lateral(), Comfort(), Motors()],
    "everything": [Posted(), Lateral(), Comfort(), Motors(), BatteryPower(GIVE, TAKE), FrictionBrakes(BRAKE), Grip(MU)],
}


class Dense:
    """A profile and what lies along its path, every 0.1 m; at a station the interval after it counts."""

    def __init__(self, road: Road, path: Path, limits: SpeedLimits, profile: SpeedProfile) -> None:
        self.limits, self.vehicle = limits, limits.vehicle
        even = np.arange(0.0, path.curve.length - 1e-6, 0.1)
        inside = np.searchsorted(profile.s, even, side="right") - 1
        # the far end of every interval too: there the acceleration is still the one of that interval
        self.s, self.k = np.append(even, profile.s[1:]), np.append(inside, np.arange(len(profile.s) - 1))
        e = profile.v**2
        share = (self.s - profile.s[self.k]) / np.diff(profile.s)[self.k]
        self.v = np.sqrt(e[self.k] + share * (e[self.k + 1] - e[self.k]))
        self.gain = (np.diff(e) / (2.0 * np.diff(profile.s)))[self.k]
        own = path.road_station(self.s)
        self.kappa, self.bank = path.curve.curvature(self.s), road.bank_at(own)
        self.posted, self.friction = road.speed_limit_at(own), road.friction_at(own)
        z = road.height_at(path.road_station(profile.s))
        self.slope = (np.diff(z) / np.diff(profile.s))[self.k]
        self.brake = np.zeros_like(self.s) if profile.brake is None else profile.brake[self.k]
        self.wheels = self.vehicle.effective_mass * self.gain + driving_resistance(self.vehicle, self.v, self.slope)

    def at_most(self, what: str, values: np.ndarray, bound: np.ndarray | float, scale: float = 0.0) -> None:
        bound = np.broadcast_to(bound, values.shape)
        beyond = values - bound - TOLERANCE * np.maximum(np.abs(bound), scale)
        at = int(np.argmax(beyond))
        assert beyond[at] <= 1e-9, f"{what} at s = {self.s[at]:.1f} m: {values[at]:.5g}, limit {bound[at]:.5g}, v {self.v[at]:.3f} m/s"

    def standard(self) -> None:
        car = self.vehicle.limits
        self.at_most("posted speed", self.v, np.minimum(self.posted, car.speed_max_mps))
        felt = np.abs(self.kappa * self.v**2 * np.cos(self.bank) + GRAVITY * np.sin(self.bank))
        self.at_most("lateral acceleration", felt, car.lateral_acceleration_max_mps2)
        self.at_most("acceleration", self.gain, car.acceleration_max_mps2)
        self.at_most("deceleration", -self.gain, car.deceleration_max_mps2)
        motors = self.wheels + self.brake
        drive, regen = force_limits(self.vehicle, self.v)
        # 0.1 % is of an ordinary braking where the motor gives less
        scale = self.vehicle.effective_mass * car.deceleration_max_mps2
        self.at_most("driving force", motors, drive, scale)
        self.at_most("recuperating force", -motors, regen, scale)

    def everything(self) -> None:
        self.standard()
        self.at_most("friction brakes", self.brake, BRAKE)
        car, motors = self.vehicle, self.wheels + self.brake
        count, ratio = car.drive.motor_count, car.motor_ratio
        idle = 0.0 if car.electrics is None else float(converter_input(car.electrics, car.electrics.auxiliary_w))
        drawn = motors * self.v + count * sum(motor_losses(car, motors / (count * ratio), self.v * ratio)) + idle
        # below walking pace a bound on power is one on force; 0.1 % of the force at the wheels, as power
        walking = self.v > 1.0
        scale = 1e4
        self.at_most("battery discharge", np.where(walking, drawn, 0.0), GIVE, scale)
        self.at_most("battery charge", np.where(walking, -drawn, 0.0), TAKE, scale)
        across = self.kappa * self.v**2 * np.cos(self.bank) + GRAVITY * np.sin(self.bank)
        load = GRAVITY * np.cos(self.bank) - self.kappa * self.v**2 * np.sin(self.bank)
        share = np.where(self.wheels > 0.0, driven_share(car), 1.0)
        along = self.wheels / (car.chassis.mass_kg * share)
        self.at_most("grip", np.hypot(along, across), MU * self.friction * load)


def jerk_at_stations(profile: SpeedProfile) -> np.ndarray:
    """Change of acceleration over the time from the middle of one interval to the middle of the next, at the station's speed."""
    found = []
    for k in range(1, len(profile.s) - 1):
        before = (profile.v[k] ** 2 - profile.v[k - 1] ** 2) / 2 / (profile.s[k] - profile.s[k - 1])
        after = (profile.v[k + 1] ** 2 - profile.v[k] ** 2) / 2 / (profile.s[k + 1] - profile.s[k])
        found.append(profile.v[k] * (after - before) / (0.5 * (profile.s[k + 1] - profile.s[k - 1])))
    return np.array(found)


def planned(road: Road, vehicle: Vehicle, kind: str, *, step: float = 2.0, path: Path | None = None) -> tuple[Path, SpeedLimits]:
    path = plan_path(road, 0.5 * vehicle.chassis.width_m + 0.2, extent="road") if path is None else path
    return path, SpeedLimits.along(road, path, vehicle, parts=SETS[kind], step=step)


def look(road: Road, path: Path, limits: SpeedLimits, kind: str, factors: tuple[float, ...] = (1.05, 1.3)) -> None:
    least = fastest_profile(limits).journey_time
    profiles = [fastest_profile(limits), *(eco_profile(limits, factor * least) for factor in factors)]
    if kind == "standard":
        profiles.append(scaled_profile(limits, 1.2 * least))
    for profile in profiles:
        getattr(Dense(road, path, limits, profile), kind)()


@pytest.fixture(scope="module")
def gallery() -> dict[str, tuple[Road, Path]]:
    found = {}
    for name in roads.shipped():
        road = roads.open_road(name)
        found[name] = road, plan_path(road, 1.25, extent="road")
    return found


@pytest.mark.parametrize("kind", SETS)
@pytest.mark.parametrize("car", ["romo", pytest.param("van", marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", roads.shipped())
def test_no_limit_is_broken_between_stations_on_the_gallery(gallery: dict, name: str, car: str, kind: str):
    road, path = gallery[name]
    path, limits = planned(road, load_vehicle(car), kind, step=8.0, path=path)
    look(road, path, limits, kind, (1.1,))


@pytest.mark.slow
@pytest.mark.parametrize("kind", SETS)
@pytest.mark.parametrize("car", ["romo", "van"])
@pytest.mark.parametrize("step", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("name", roads.shipped())
def test_no_limit_is_broken_whatever_the_step(gallery: dict, name: str, step: float, car: str, kind: str):
    road, path = gallery[name]
    path, limits = planned(road, load_vehicle(car), kind, step=step, path=path)
    look(road, path, limits, kind, (1.02, 1.3, 2.0))


@pytest.mark.parametrize("factor", [1.005, 1.02, 1.1])
def test_a_van_with_every_limit_is_planned_next_to_its_least_time(gallery: dict, factor: float):
    """A battery that takes little, friction brakes and grip at a stop: far from convex, and violated by far where the brakes start from nothing."""
    road, path = gallery["rural"]
    path, limits = planned(road, load_vehicle("van"), "everything", step=1.0, path=path)
    profile = eco_profile(limits, factor * fastest_profile(limits).journey_time)
    assert profile.status == "solved"
    Dense(road, path, limits, profile).everything()


@pytest.mark.parametrize("name", ["commute"])
def test_jerk_is_kept_at_every_station(gallery: dict, name: str):
    road, path = gallery[name]
    limits = SpeedLimits.along(road, path, load_vehicle("romo"), extra=[Jerk(1.0)], step=8.0)
    profile = eco_profile(limits, 1.05 * EcoSolver(limits).least_time)
    assert np.max(np.abs(jerk_at_stations(profile))) <= 1.0 * (1 + TOLERANCE)
    Dense(road, path, limits, profile).standard()


@pytest.mark.slow
@pytest.mark.skipif(not FOLDER.is_dir(), reason="real tracks are not there")
@pytest.mark.parametrize("kind", SETS)
@pytest.mark.parametrize("name", TRACKS)
def test_no_limit_is_broken_between_stations_on_real_tracks(name: str, kind: str):
    road = roads.open_road(FOLDER / f"{name}.csv", closed=True)
    path = None
    for car in ("romo", "van"):
        path, limits = planned(road, load_vehicle(car), kind, step=3.0, path=path if car == "romo" else None)
        look(road, path, limits, kind)
