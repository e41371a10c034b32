from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import fresnel

import energy_mgr
from energy_mgr import Trajectory
from roads import RoadBuilder

#: Curvature grows by this per metre on the clothoid below, 1/m^2.
SHARPNESS = 2e-3


def clothoid(s):
    """x, y, psi, kappa of a clothoid that starts straight along +x at s = 0, and of the straight before it: Fresnel integrals."""
    unit = np.sqrt(np.pi / SHARPNESS)
    y, x = fresnel(np.maximum(s, 0.0) / unit)
    bent = np.maximum(s, 0.0)
    return x * unit + np.minimum(s, 0.0), y * unit, 0.5 * SHARPNESS * bent**2, SHARPNESS * bent


def on_clothoid(s, **more) -> Trajectory:
    return Trajectory.along(s, *clothoid(s), np.full(len(s), 10.0), **more)


def circle(radius=30.0, count=64, **more) -> Trajectory:
    """A closed one, counter-clockwise from (radius, 0), with speed and height that vary."""
    angle = np.linspace(0.0, 2 * np.pi, count + 1)
    more = {"z": np.sin(angle), "bank": 0.1 * np.cos(angle), "power": 1e3 * np.arange(count), "name": "ring"} | more
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    x[-1], y[-1], more["z"][-1] = x[0], y[0], more["z"][0]
    speed = 10.0 + np.sin(angle)
    speed[-1] = speed[0]
    return Trajectory.along(radius * angle, x, y, angle + np.pi / 2, np.full(count + 1, 1 / radius), speed, closed=True, **more)


def straight(v, step=2.0, **more) -> Trajectory:
    s = step * np.arange(len(v))
    return Trajectory.along(s, s, 0.0 * s, 0.0 * s, 0.0 * s, v, **more)


@pytest.fixture(scope="module")
def ring_plan() -> energy_mgr.Plan:
    oval = RoadBuilder("oval").limit(20)
    for _ in range(2):
        oval.straight(60).bend(25, np.pi, 15)
    return energy_mgr.plan(oval.build(closed=True), corridor="road")


# -- time and speed ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("start", "acceleration"), [(0.0, 1.5), (3.0, 0.7), (20.0, -1.9), (12.0, 0.0)])
def test_motion_with_constant_acceleration_is_that_of_the_textbook_everywhere(start: float, acceleration: float):
    s = np.linspace(0.0, 100.0, 12)
    trajectory = Trajectory.along(s, s, 0 * s, 0 * s, 0 * s, np.sqrt(start**2 + 2 * acceleration * s))
    t = np.linspace(0.0, trajectory.journey_time, 997)
    wanted = start * t + 0.5 * acceleration * t**2
    assert trajectory.at_time(t) == pytest.approx(wanted, abs=1e-11)
    found = trajectory.at(np.clip(wanted, 0.0, 100.0))
    assert found.v == pytest.approx(start + acceleration * t, abs=1e-6 if start == 20 else 1e-11)
    assert found.t == pytest.approx(t, abs=1e-11)
    assert found.a == pytest.approx(acceleration, abs=1e-12)
    assert trajectory.jerk == pytest.approx(0.0, abs=1e-11)


def test_a_stop_is_reached_and_left_in_finite_time():
    trajectory = straight(np.array([0.0, 4.0, 0.0, 2.0]))
    # half way to the first station from standstill: v^2 is half, and 2 d / v have passed
    assert trajectory.point(1.0).v == pytest.approx(np.sqrt(8.0))
    assert trajectory.point(1.0).t == pytest.approx(2.0 / np.sqrt(8.0))
    assert trajectory.t == pytest.approx([0.0, 1.0, 2.0, 4.0])
    # a micrometre on either side of the standstill, braking at 4 m/s^2 and leaving at 1 m/s^2
    assert trajectory.point(4.0 - 1e-6).t == pytest.approx(2.0 - np.sqrt(2e-6 / 4.0), abs=1e-9)
    assert trajectory.point(4.0 + 1e-6).t == pytest.approx(2.0 + np.sqrt(2e-6 / 1.0), abs=1e-9)


@given(
    v=st.lists(st.floats(0.1, 60.0), min_size=2, max_size=8),
    step=st.floats(0.1, 50.0),
    share=st.floats(0.0, 1.0),
    stops=st.lists(st.sampled_from([0, 2, 4, 6]), max_size=4),
)
@settings(deadline=None)
def test_station_at_a_time_undoes_time_at_a_station(v: list[float], step: float, share: float, stops: list[int]):
    speeds = np.array(v)
    speeds[[k for k in stops if k < len(v)]] = 0.0
    trajectory = straight(speeds, step)
    t = share * trajectory.journey_time
    s = trajectory.at_time(t)
    assert 0.0 <= s <= trajectory.length
    # time as a function of s has a vertical tangent at a stop: what rounding does to s moves it by the root
    assert trajectory.point(s).t == pytest.approx(t, rel=1e-9, abs=1e-4 if stops else 1e-10)
    assert trajectory.at_time(trajectory.point(share * trajectory.length).t) == pytest.approx(share * trajectory.length, rel=1e-9, abs=1e-12)
    assert trajectory.at_time([t, t])[0] == pytest.approx(s, rel=1e-15)


def test_jerk_of_a_motion_with_constant_jerk_is_found_to_the_first_order():
    jerk, errors = 0.6, []
    for count in (50, 100, 200):
        # s = 10 t + jerk t^3 / 6, at equal stations: t by Newton's method
        s = np.linspace(0.0, 60.0, count + 1)
        t = s / 10.0
        for _ in range(30):
            t = t - (10.0 * t + jerk * t**3 / 6.0 - s) / (10.0 + 0.5 * jerk * t**2)
        trajectory = Trajectory.along(s, s, 0 * s, 0 * s, 0 * s, 10.0 + 0.5 * jerk * t**2)
        errors.append(np.max(np.abs(trajectory.jerk - jerk)))
    assert errors[0] < 2e-3
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] < 0.6 * errors[1]


def test_jerk_wraps_on_a_closed_track_and_repeats_its_neighbour_at_the_ends_of_another():
    ring = circle()
    dt = np.diff(ring.t)
    assert ring.jerk[0] == ring.jerk[-1] == pytest.approx((ring.a[0] - ring.a[-2]) / (0.5 * (dt[0] + dt[-1])))
    trajectory = straight(np.array([1.0, 2.0, 4.0, 3.0]))
    assert trajectory.jerk[0] == trajectory.jerk[1] == pytest.approx((3.0 - 0.75) / (0.5 * (2 * 2 / 3 + 2 * 2 / 6)))
    assert trajectory.jerk[-1] == trajectory.jerk[-2]
    assert np.array_equal(straight(np.array([1.0, 2.0])).jerk, [0.0, 0.0])


def test_acceleration_and_power_are_those_of_the_interval_that_begins_at_the_station():
    ring = circle()
    assert np.allclose(ring.a[:-1], np.diff(ring.v**2) / (2 * np.diff(ring.s)))
    assert (ring.a[-1], ring.power[-1]) == (ring.a[0], ring.power[0])
    trajectory = straight(np.array([1.0, 2.0, 4.0]), power=np.array([10.0, 30.0]))
    assert trajectory.a.tolist() == [0.75, 3.0, 3.0]
    assert trajectory.at([0.0, 1.999, 2.0, 4.0]).power.tolist() == [10.0, 10.0, 30.0, 30.0]


# -- geometry ------------------------------------------------------------------------------------------------------------------------


def test_an_arc_is_right_between_stations_two_metres_apart():
    angle = np.arange(0.0, 1.0001, 0.02)  # radius 100 m
    trajectory = Trajectory.along(100 * angle, 100 * np.sin(angle), 100 * (1 - np.cos(angle)), angle, np.full(len(angle), 0.01), 10.0 + 0 * angle)
    s = np.linspace(0.0, trajectory.length, 4001)
    found = trajectory.at(s)
    # 1e-13 m is what is left of 100 m in double precision
    assert np.max(np.hypot(found.x - 100 * np.sin(s / 100), found.y - 100 * (1 - np.cos(s / 100)))) < 2e-13
    assert found.psi == pytest.approx(s / 100, abs=1e-12)
    assert found.kappa == pytest.approx(0.01, abs=1e-11)


def errors_on(stations: Callable[[float], np.ndarray], step: float) -> np.ndarray:
    """Largest errors of position, heading, curvature, and of dx/ds = cos psi and dpsi/ds = kappa on the clothoid."""
    trajectory = on_clothoid(stations(step))
    s = np.linspace(trajectory.s[0] + 2e-3, trajectory.s[-1] - 2e-3, 9001)
    x, y, psi, kappa = clothoid(s)
    found, ahead, behind = trajectory.at(s), trajectory.at(s + 1e-3), trajectory.at(s - 1e-3)
    rate_x, rate_psi = ((getattr(ahead, name) - getattr(behind, name)) / 2e-3 for name in ("x", "psi"))
    pairs = ((found.psi, psi), (found.kappa, kappa), (rate_x, np.cos(found.psi)), (rate_psi, found.kappa))
    return np.array([np.max(np.hypot(found.x - x, found.y - y)), *(np.max(np.abs(a - b)) for a, b in pairs)])


def test_orders_of_the_interpolation_are_those_of_the_docstring():
    coarse, fine = (errors_on(lambda step: np.arange(0.0, 96.001, step), step) for step in (8.0, 4.0))
    orders = np.log2(coarse[:3] / fine[:3])
    assert orders == pytest.approx([6.0, 5.0, 4.0], abs=0.6)


def test_derivatives_along_the_line_agree_with_heading_and_curvature():
    coarse, fine = (errors_on(lambda step: np.arange(0.0, 96.001, step), step) for step in (8.0, 4.0))
    assert np.all(np.log2(coarse[3:] / fine[3:]) > 4.0)
    two_metres = errors_on(lambda step: np.arange(0.0, 60.001, step), 2.0)
    assert np.all(two_metres[3:] < 2e-6)


def test_orders_at_a_kink_of_curvature_within_an_interval_are_those_of_the_docstring():
    # straight up to s = 0, clothoid from there on, stations at odd halves
    coarse, fine = (errors_on(lambda step: step * (np.arange(-4, 5) + 0.5), step) for step in (0.5, 0.25))
    assert np.log2(coarse[:3] / fine[:3]) == pytest.approx([3.0, 2.0, 1.0], abs=0.3)


def test_line_goes_on_without_a_kink_over_stations():
    trajectory = on_clothoid(np.array([-7.0, -3.0, 0.0, 1.0, 6.0, 9.5, 20.0]))
    inner = trajectory.s[1:-1]
    before, after = trajectory.at(inner - 1e-9), trajectory.at(inner + 1e-9)
    for name, tolerance in {"x": 1e-8, "y": 1e-8, "psi": 1e-9, "kappa": 1e-9, "z": 1e-9, "slope": 1e-9, "v": 1e-9, "t": 1e-9}.items():
        assert getattr(before, name) == pytest.approx(getattr(after, name), abs=tolerance)


def test_height_and_slope_belong_together_and_parabolas_are_exact():
    s = np.array([0.0, 3.0, 5.0, 9.0, 16.0])
    trajectory = on_clothoid(s, z=0.01 * s**2 - 0.1 * s)
    at = np.linspace(0.0, 16.0, 101)
    assert trajectory.at(at).z == pytest.approx(0.01 * at**2 - 0.1 * at, abs=1e-13)
    assert trajectory.at(at).slope == pytest.approx(0.02 * at - 0.1, abs=1e-13)
    ring = circle()
    assert ring.slope[[0, -1]] == pytest.approx(np.cos(0.0) / 30.0, rel=2e-3)


@pytest.mark.parametrize("make", [lambda: circle(), lambda: on_clothoid(np.linspace(-5.0, 30.0, 9), z=3.0, bank=0.02)])
def test_what_the_table_says_is_found_at_its_stations(make: Callable[[], Trajectory]):
    trajectory = make()
    found = trajectory.at(trajectory.s)
    for name, column in trajectory.columns.items():
        # curvature comes out of a quotient; all else is bit for bit
        assert getattr(found, name) == pytest.approx(column, abs=1e-16 if name == "kappa" else 0.0), name
    assert np.array_equal(trajectory.at_time(trajectory.t), trajectory.s)


def test_derivatives_hold_on_a_planned_circuit(ring_plan: energy_mgr.Plan):
    trajectory, curve = ring_plan.trajectory, ring_plan.chosen.path.curve
    middle = 0.5 * (trajectory.s[1:] + trajectory.s[:-1])
    ahead, here, behind = (trajectory.at(middle + d) for d in (1e-4, 0.0, -1e-4))
    rate = {name: (getattr(ahead, name) - getattr(behind, name)) / 2e-4 for name in ("x", "y", "psi", "v", "t", "z")}
    assert here.v * rate["v"] == pytest.approx(here.a, abs=1e-7)
    assert rate["t"] == pytest.approx(1.0 / here.v, rel=1e-8)
    assert rate["z"] == pytest.approx(here.slope, abs=1e-9)
    # the planned spline has kinks of curvature between stations: third order
    assert rate["x"] == pytest.approx(np.cos(here.psi), abs=1e-4)
    assert rate["y"] == pytest.approx(np.sin(here.psi), abs=1e-4)
    assert rate["psi"] == pytest.approx(here.kappa, abs=1e-4)
    s = np.linspace(0.0, trajectory.length, 3000)
    found, place = trajectory.at(s), curve.position(s)
    assert np.max(np.hypot(found.x - place[:, 0], found.y - place[:, 1])) < 1e-4
    assert trajectory.closed
    assert trajectory.name == "oval"


def test_bank_comes_from_the_limits_where_they_have_it(ring_plan: energy_mgr.Plan):
    run = ring_plan.chosen
    bank = np.linspace(0.0, 0.05, len(run.limits.s))
    known = SimpleNamespace(s=run.limits.s, z=run.limits.z, closed=True, name="oval", bank=bank)
    made = Trajectory.of(run.path, known, run.profile, run.ledger)  # pyright: ignore[reportArgumentType]
    assert np.array_equal(made.bank, bank)
    assert made.at(0.5 * (made.s[3] + made.s[4])).bank == pytest.approx(0.5 * (bank[3] + bank[4]))
