"""The fastest profile against a slow, independent one."""

import numpy as np
import pytest

from energy_mgr import InfeasibleError
from energy_mgr.speed import BatteryPower, Comfort, FrictionBrakes, Grip, Lateral, Motors, Posted, SpeedCap, SpeedLimits, Stop, fastest_profile
from powertrain import Vehicle
from powertrain.drive.supply import converter_input
from powertrain.vehicle import GRAVITY

from ..rig import ROMO, VAN, changed, driven_share, limits_of
from ..slow_oracle import Slow


def slow_of(limits: SpeedLimits, *, up: float = 2.0, down: float = 2.0, **more) -> Slow:
    v_max = limits.v_max.copy()
    if not limits.closed:
        v_max[[0, -1]] = limits.start_speed, limits.end_speed
    return Slow(limits.vehicle, limits.s.tolist(), limits.z.tolist(), v_max.tolist(), up, down, limits.closed, **more)


def assert_same(limits: SpeedLimits, slow: Slow) -> bool:
    """The package's profile is the slow one, or both say that there is none. True where there is one."""
    expected = slow.profile()
    if expected is None:
        with pytest.raises(InfeasibleError, match=r"^rig: .* at s = \d"):
            fastest_profile(limits)
        return False
    found = fastest_profile(limits).v
    # speeds to 1e-6 m/s; near standstill the same in v^2/2, in which the passes are done
    assert np.all(np.abs(found - expected) <= 1e-6 + 1e-7 / np.maximum(expected, 1e-3))
    return True


def random_road(rng: np.random.Generator, length: float, *, closed: bool = False) -> dict:
    """Slopes up to 12 %, bends both ways, banks, posted limits that change."""
    waves = [(rng.uniform(15, 120), rng.uniform(0, 6.3), rng.uniform(0, 1)) for _ in range(3)]
    if closed:
        waves = [(length / (2 * np.pi) / rng.integers(1, 6), phase, size) for _, phase, size in waves]
    total = sum(size for _, _, size in waves)
    steep, sharp, tilt = rng.uniform(0.0, 0.12), rng.uniform(0.0, 0.08), rng.uniform(0.0, 0.06)
    marks, limits = np.sort(rng.uniform(0, length, 2)), rng.uniform(6, 28, 3)

    def wave(s: np.ndarray) -> np.ndarray:
        return sum(size / total * np.sin(s / lag + phase) for lag, phase, size in waves)

    def height(s: np.ndarray) -> np.ndarray:
        return steep * sum(size / total * lag * -np.cos(s / lag + phase) for lag, phase, size in waves)

    return {
        "length": length,
        "kappa": lambda s: sharp * wave(1.3 * s if not closed else s),
        "bank": lambda s: tilt * wave(s),
        "height": height,
        "posted": lambda s: limits[np.searchsorted(marks, s)] if not closed else np.full_like(s, limits[0]),
        "closed": closed,
    }


def random_car(rng: np.random.Generator) -> Vehicle:
    base = (ROMO, VAN)[int(rng.integers(2))]
    return changed(
        base,
        drive={
            "torque_max_nm": rng.uniform(0.4, 1.2) * base.drive.torque_max_nm,
            "power_max_w": rng.uniform(0.15, 1.0) * base.drive.power_max_w,
            "regen_torque_max_nm": rng.uniform(0.3, 1.2) * base.drive.regen_torque_max_nm,
            "regen_power_max_w": rng.uniform(0.15, 1.0) * base.drive.regen_power_max_w,
        },
    )


@pytest.mark.parametrize("seed", range(16))
def test_random_roads_and_cars_with_motors_comfort_and_stops(seed: int):
    rng = np.random.default_rng(seed)
    length = float(rng.uniform(120, 400))
    road, car = random_road(rng, length), random_car(rng)
    through = rng.uniform(0, length, int(rng.integers(0, 6))).tolist()
    extra = [Stop(float(rng.uniform(0.3, 0.7) * length))] if rng.random() < 0.4 else []
    up, down = rng.uniform(1.0, 4.0, 2)
    limits = limits_of(car, step=float(rng.uniform(3, 12)), parts=[Posted(), Lateral(), Comfort(up, down), Motors(), *extra], through=through, **road)
    assert_same(limits, slow_of(limits, up=up, down=down))


@pytest.mark.parametrize("seed", range(8))
def test_random_roads_with_battery_power(seed: int):
    rng = np.random.default_rng(100 + seed)
    road, car = random_road(rng, 250.0), random_car(rng)
    give, take = float(rng.uniform(1e4, 4e4)), float(rng.uniform(3e3, 2e4))
    extra = [BatteryPower(give, take)]
    auxiliary = float(converter_input(car.electrics, car.electrics.auxiliary_w)) if car.electrics else 0.0
    limits = limits_of(car, step=6.0, extra=extra, **road)
    assert_same(limits, slow_of(limits, give=give, take=take, auxiliary=auxiliary))


@pytest.mark.parametrize(("slope", "take"), [(0.04, 3e3), (0.06, 3e3), (0.08, 4.6e3), (0.10, 8e3), (0.10, 4.6e3), (0.12, 8e3)])
def test_a_battery_that_takes_little_is_driven_down_a_long_hill_slowly(slope: float, take: float):
    limits = limits_of(VAN, length=300.0, step=6.0, extra=[BatteryPower(28e3, take)], height=lambda s: -slope * s)
    auxiliary = float(converter_input(VAN.electrics, VAN.electrics.auxiliary_w))
    assert assert_same(limits, slow_of(limits, give=28e3, take=take, auxiliary=auxiliary))


def grip_data(limits: SpeedLimits) -> list[tuple[float, float, float]]:
    """Friction, curvature and bank that the package takes for each interval; that they are safe is a test of its own."""
    return [tuple(row) for row in np.column_stack(next(limit.data for limit in limits.forces if limit.name == "grip")).tolist()]


@pytest.mark.parametrize("seed", range(4))
def test_grip_takes_the_sharpest_curvature_and_the_least_friction_of_each_interval(seed: int):
    road = random_road(np.random.default_rng(seed), 200.0)
    limits = limits_of(extra=[Grip(0.8)], step=6.0, friction=lambda s: 0.8 + 0.2 * np.cos(s / 9.0), **road)
    for k, (mu, kappa, bank) in enumerate(grip_data(limits)):
        inside = np.linspace(limits.s[k], limits.s[k + 1], 301)
        # the rig looks every 0.3 m
        assert abs(kappa) >= np.max(np.abs(road["kappa"](inside))) * (1 - 1e-3) - 1e-6
        assert abs(kappa) <= np.max(np.abs(road["kappa"](np.linspace(limits.s[k] - 0.4, limits.s[k + 1] + 0.4, 301)))) + 1e-6
        assert mu <= 0.8 * np.min(0.8 + 0.2 * np.cos(inside / 9.0)) + 1e-3
        assert bank == pytest.approx(float(np.mean(road["bank"](limits.s[k : k + 2]))), abs=2e-3)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("brakes", [False, True])
def test_random_roads_with_grip_and_friction_brakes(seed: int, brakes: bool):
    rng = np.random.default_rng(200 + seed)
    road, car, mu = random_road(rng, 200.0), random_car(rng), float(rng.uniform(0.3, 0.9))
    extra = [FrictionBrakes(3000.0)] if brakes else []
    parts = [Posted(), Lateral(0.8 * mu * GRAVITY), Comfort(6.0, 6.0), Motors(), *extra, Grip(mu)]
    limits = limits_of(car, step=6.0, parts=parts, **road)
    share = driven_share(car)
    more = {"grip": grip_data(limits), "shares": (share, 1.0 if brakes else share), "brake": 3000.0 if brakes else 0.0}
    assert_same(limits, slow_of(limits, up=6.0, down=6.0, **more))


@pytest.mark.parametrize("seed", range(6))
def test_random_circuits(seed: int):
    rng = np.random.default_rng(300 + seed)
    road, car = random_road(rng, 300.0, closed=True), random_car(rng)
    through = rng.uniform(0, 300.0, 3).tolist()
    limits = limits_of(car, step=7.0, through=through, **road)
    if assert_same(limits, slow_of(limits)):
        profile = fastest_profile(limits)
        assert profile.v[0] == pytest.approx(profile.v[-1], abs=1e-9)


@pytest.mark.parametrize("at", [0.0, 0.4, 1.0])
def test_a_stop_on_a_circuit_is_a_stop_wherever_it_is(at: float):
    limits = limits_of(length=400.0, step=5.0, kappa=2 * np.pi / 400, closed=True, extra=[Stop(400.0 * at)])
    profile = fastest_profile(limits)
    assert profile.v[int(np.argmin(np.abs(limits.s - 400.0 * at)))] == 0.0
    assert profile.v[0] == profile.v[-1]
    # the same lap wherever it is counted from: up to the speed in bends at 2 m/s^2, and down again
    top = float(np.min(limits.v_max[limits.v_max > 0]))
    assert profile.journey_time == pytest.approx(top / 2.0 * 2 + (400.0 - top**2 / 2.0) / top, rel=2e-3)


def test_a_cap_before_the_seam_of_a_circuit_holds_at_its_first_station_too():
    limits = limits_of(length=600.0, step=5.0, kappa=2 * np.pi / 600, closed=True, extra=[SpeedCap([0.0, 550.0], [np.inf, 5.0])], posted=15.0)
    profile = fastest_profile(limits)
    assert profile.v[0] == pytest.approx(5.0)
    assert np.all(profile.v[limits.s >= 550.0] <= 5.0 + 1e-9)


def test_a_circuit_may_be_counted_from_anywhere():
    times = []
    for phase in (0.0, 1.0, 2.5, 4.0):
        road = {"kappa": lambda s, p=phase: 0.03 * np.sin(s / 50 + p), "height": lambda s, p=phase: 2.0 * np.sin(s / 50 + p)}
        times.append(fastest_profile(limits_of(length=100 * np.pi, step=1.0, closed=True, **road)).journey_time)
    assert times == pytest.approx([times[0]] * 4, rel=1e-4)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_roads_of_one_two_and_three_intervals(count: int):
    s = np.linspace(0.0, 30.0, count + 1)
    limits = limits_of(s=s, start_speed=8.0, end_speed=5.0)
    assert_same(limits, slow_of(limits))
    assert fastest_profile(limits).v[[0, -1]] == pytest.approx([8.0, 5.0])


@pytest.mark.parametrize("apart", [0.02, 0.3, 4.0])
def test_stop_lines_close_to_each_other_are_driven_between(apart: float):
    limits = limits_of(extra=[Stop(100.0), Stop(100.0 + apart)])
    profile = fastest_profile(limits)
    assert np.isfinite(profile.journey_time)
    # lines 2 cm apart are one
    assert np.sum(profile.v[1:-1] == 0.0) == (1 if apart < 0.1 else 2)
    assert_same(limits, slow_of(limits))


def test_stations_of_very_different_distances_give_the_speeds_of_even_ones():
    s = np.unique(np.concatenate([np.linspace(0, 300, 61), [100.05, 100.1, 100.2, 150.01, 299.9]]))
    road = {"height": lambda s: 0.03 * s, "kappa": lambda s: 0.02 * np.sin(s / 30)}
    limits = limits_of(s=s, **road)
    assert_same(limits, slow_of(limits))


@pytest.mark.parametrize("share", [0.90, 0.93, 0.95, 0.97, 0.99])
def test_recuperation_just_short_of_the_comfortable_deceleration_is_kept_at_the_slow_end_too(share: float):
    car = changed(ROMO, drive={"regen_torque_max_nm": share * 2.0 * ROMO.effective_mass / (4 * ROMO.motor_ratio)})
    limits = limits_of(car, s=np.linspace(0, 400, 9))
    assert_same(limits, slow_of(limits))


def test_no_station_can_be_faster(rng: np.random.Generator):
    """Raise the profile anywhere: a limit breaks at that station or beside it."""
    limits = limits_of(
        changed(ROMO, drive={"power_max_w": 6e3}), length=300.0, step=6.0, height=lambda s: 0.04 * s, kappa=lambda s: 0.03 * np.sin(s / 25)
    )
    v, slow = fastest_profile(limits).v, slow_of(limits)
    for k in rng.integers(1, len(v) - 1, 25):
        e = 0.5 * v**2
        e[k] += 1e-3
        above = e[k] > 0.5 * limits.v_max[k] ** 2
        keeps = all(slow._keeps(e[j], e[j + 1], j, 1) and slow._keeps(e[j + 1], e[j], j, -1) for j in (k - 1, k))
        assert above or not keeps


@pytest.mark.parametrize("seed", range(4))
def test_smooth_friction_on_winding_banked_hills_is_driven(seed: int):
    """Friction that varies with curvature once made the passes creep."""
    a, b, c = np.random.default_rng(seed).normal(size=3)
    limits = limits_of(
        extra=[Grip(0.6)], parts=[Posted(), Comfort(), Motors()], length=300.0, kappa=lambda s: 0.03 * np.sin(s / 20 + a),
        bank=lambda s: 0.05 * np.sin(s / 17 + b), height=lambda s: 1.5 * np.sin(s / 40 + c), friction=lambda s: 0.9 + 0.1 * np.cos(s / 31),
    )  # fmt: skip
    profile = fastest_profile(limits)
    assert 10.0 < profile.journey_time < 120.0


@pytest.mark.parametrize("extra", [[], [FrictionBrakes(5000.0)]])
def test_without_comfort_the_forces_alone_bound_the_profile(extra: list):
    limits = limits_of(parts=[Posted(), Lateral(), Motors(), *extra], length=300.0, step=6.0, height=lambda s: 2.0 * np.sin(s / 40.0))
    assert assert_same(limits, slow_of(limits, up=np.inf, down=np.inf, brake=5000.0 if extra else 0.0))


def test_without_any_bound_on_acceleration_the_profile_is_the_bound_on_speed():
    limits = limits_of(parts=[Posted()], start_speed=10.0, end_speed=20.0)
    v = fastest_profile(limits).v
    assert v == pytest.approx(np.concatenate([[10.0], np.full(len(v) - 1, 20.0)]))
