import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from energy_mgr import PlanningError, Trajectory
from energy_mgr.following import PathProjection
from energy_mgr.motion import VehicleState
from tests.energy_mgr.following.rig import DT, arc, beside, circle, clothoid, eight, straight


def follow(projection, road, places, dt=DT, **offset):
    """Projections of a car that drives along `places`, at `road`'s speed."""
    return [projection.update(beside(road, s, **offset), dt) for s in places]


def drifting(road, e_y, s, dt=DT):
    """A car at constant offset: it is as fast as its circle about the path's centre asks."""
    p = road.point(s)
    return beside(road, s, e_y, v=p.v * (1 - p.kappa * e_y))


# -- the published law ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("e_y", [-8.0, 0.0, 12.0])
def test_tipi_error_decays_with_the_gain_times_one_minus_kappa_offset(e_y: float):
    """On a circle a standing car at radius rho sees the angle theta to its station: d theta/dt = -K_Ps rho sin(theta)/R."""
    radius, gain, dt, theta = 30.0, 5.0, 1e-4, 0.05
    road = circle(radius)
    projection = PathProjection(road, method="tipi", gain=gain)
    start, car = 40.0, 40.0 + radius * theta
    projection.update(beside(road, start, e_y, v=0.0), dt)
    at = None
    for _ in range(3000):
        at = projection.update(beside(road, car, e_y, v=0.0), dt)
    rate = gain * (1 - e_y / radius)
    exact = 2 * math.atan(math.tan(theta / 2) * math.exp(-rate * 3000 * dt))
    # the road's points are right to 1e-9, the explicit step to rate * dt / 2 of the decay
    assert (car - at.s) / radius == pytest.approx(exact, rel=1.5e-3)
    assert at.e_x == pytest.approx((radius - e_y) * math.sin(exact), rel=1.5e-3)


def test_tipi_refuses_a_gain_that_its_period_cannot_carry():
    with pytest.raises(PlanningError, match="product below 1"):
        PathProjection(circle(), method="tipi", gain=300.0, dt=DT)
    projection = PathProjection(circle(), method="tipi", gain=10.0)
    projection.update(beside(circle(), 0.0), DT)
    with pytest.raises(PlanningError, match="period of 0.1 s"):
        projection.update(beside(circle(), 0.0), 0.1)


def test_tipi_keeps_up_with_a_car_that_drives_at_an_offset():
    road = circle()
    projection = PathProjection(road, method="tipi")
    ats = [projection.update(drifting(road, 5.0, 10.0 + 10.0 * DT * k), DT) for k in range(2000)]
    # explicit Euler lags by about a period's way times curvature: far below a millimetre
    assert max(abs(at.e_x) for at in ats) < 1e-3
    assert ats[-1].s == pytest.approx(10.0 + 10.0 * DT * 1999, abs=2e-3)


@pytest.mark.parametrize("setting", [{"method": "newton"}, {"gain": 0.0}, {"window": -1.0}, {"jump": math.nan}])
def test_settings_that_cannot_work_are_refused(setting):
    with pytest.raises(PlanningError, match="expected"):
        PathProjection(circle(), **setting)


# -- the safe method -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("road", [circle(), clothoid(), eight(), arc(-60.0)], ids=["circle", "clothoid", "eight", "right arc"])
@pytest.mark.parametrize("e_y", [-3.0, 0.0, 2.0])
def test_station_and_offset_are_found_again(road: Trajectory, e_y: float):
    projection = PathProjection(road)
    for k in range(600):
        s = 5.0 + 10.0 * DT * k
        at = projection.update(drifting(road, e_y, s), DT)
        assert at.how == ("global" if k == 0 else "newton")
        assert (at.s, at.e_y) == (pytest.approx(s, abs=2e-5), pytest.approx(e_y, abs=1e-6))
        assert at.e_psi == pytest.approx(0.0, abs=1e-6)
        assert at.sdot == pytest.approx(road.point(s).v, rel=1e-5)


def test_errors_of_heading_are_wrapped():
    road = straight()
    at = PathProjection(road).update(beside(road, 20.0, 0.0, 0.3)._replace(psi=0.3 + 10 * math.pi), DT)
    assert at.e_psi == pytest.approx(0.3)


def test_a_closed_path_counts_on_over_the_laps():
    road = circle()
    projection = PathProjection(road)
    ats = follow(projection, road, 10.0 * DT * np.arange(14000))
    assert {at.how for at in ats[1:]} == {"newton"}
    assert ats[-1].s == pytest.approx(10.0 * DT * 13999, abs=2e-5)
    assert ats[-1].s > 2.9 * road.length


def test_a_crossing_keeps_its_branch_and_a_start_there_takes_that_of_the_heading(rng: np.random.Generator):
    road = eight()
    projection = PathProjection(road)
    half = road.length / 2
    for k in range(9000):
        s = 1.0 + 10.0 * DT * k
        car = beside(road, s, 0.5 * math.sin(0.1 * s), v=10.0)
        at = projection.update(car._replace(x=car.x + rng.normal(0, 0.02), y=car.y + rng.normal(0, 0.02)), DT)
        assert at.s == pytest.approx(s, abs=0.15)
    for s in (0.0, half):
        at = PathProjection(road).update(beside(road, s, 0.3), DT)
        assert math.remainder(at.s - s, road.length) == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("road", [circle(), clothoid(), eight(), arc(-60.0), straight()], ids=["circle", "clothoid", "eight", "arc", "straight"])
def test_a_start_anywhere_is_as_near_as_brute_force_finds(road: Trajectory, rng: np.random.Generator):
    fine = road.at(np.linspace(road.s[0], road.s[-1], 40001))
    for _ in range(60):
        x, y = rng.uniform(-60, 120), rng.uniform(-60, 60)
        at = PathProjection(road).update(VehicleState(x, y, rng.uniform(-3, 3), 0.0, 0.0, 0.0), DT)
        found, least = math.hypot(at.e_x, at.e_y), float(np.min(np.hypot(fine.x - x, fine.y - y)))
        # a branch up to a metre farther may win by its heading; then it is a local minimum all the same
        assert found <= least + 1.0 + 1e-6
        if not at.end:
            assert at.e_x == pytest.approx(0.0, abs=1e-6)


def test_beyond_the_ends_the_station_is_held_and_said():
    road = straight(100.0)
    projection = PathProjection(road)
    before = projection.update(VehicleState(-3.0, 1.0, 0.0, 10.0, 0.0, 0.0), DT)
    assert (before.s, before.e_x, before.e_y, before.end) == (0.0, pytest.approx(-3.0), pytest.approx(1.0), True)
    ats = [projection.update(VehicleState(-3.0 + 0.04 * k, 1.0, 0.0, 10.0, 0.0, 0.0), DT) for k in range(2700)]
    assert not any(at.end for at in ats if 0.05 < at.s < 99.95)
    assert (ats[-1].s, ats[-1].end, ats[-1].to_go) == (100.0, True, 0.0)
    assert ats[-1].e_x == pytest.approx(-3.0 + 0.04 * 2699 - 100.0)


def test_at_the_centre_of_curvature_the_station_goes_on_and_comes_back():
    road = circle(10.0, v=3.0)
    projection = PathProjection(road)
    stations, hows = [], []
    # straight through the middle of the circle, from its right side to the left
    for k in range(5000):
        x = -10.0 + DT * k
        at = projection.update(VehicleState(0.0, x, math.pi / 2, 1.0, 0.0, 0.0), DT)
        assert all(map(math.isfinite, at[:5]))
        stations.append(at.s)
        hows.append(at.how)
    assert "outside" in hows
    held = [b - a for a, b, how in zip(stations, stations[1:], hows[1:], strict=False) if how == "outside"]
    assert min(held) >= 0.0
    assert max(held) <= 1.0 * DT + 1e-9
    # out on the other side it is found again
    assert math.hypot(at.e_x, at.e_y) < 0.5


@pytest.mark.parametrize("jump", [1.5, 4.0, -6.0, 60.0])
def test_a_jump_of_the_measured_place_is_followed(jump: float):
    road = eight()
    projection = PathProjection(road)
    follow(projection, road, 20.0 + 10.0 * DT * np.arange(100))
    at = projection.update(beside(road, 24.0 + jump, 0.4), DT)
    assert at.how in ("window", "global")
    assert math.remainder(at.s - 24.0 - jump, road.length) == pytest.approx(0.0, abs=1e-5)
    assert at.e_y == pytest.approx(0.4, abs=1e-6)


def test_a_jump_on_to_the_crossing_stays_on_the_branch():
    road = eight()
    projection = PathProjection(road)
    start = road.length / 2 - 6.0
    follow(projection, road, start + 10.0 * DT * np.arange(50))
    car = beside(road, road.length / 2, 0.0)
    at = projection.update(car._replace(psi=math.pi / 2), DT)  # half way between both headings
    assert at.s == pytest.approx(road.length / 2, abs=1e-5)


def test_a_new_trajectory_is_entered_where_the_car_is():
    old, new = arc(60.0, 200.0), arc(60.0, 200.0)
    projection = PathProjection(old)
    follow(projection, old, 30.0 + 10.0 * DT * np.arange(100))
    # the same line, but stations count from 1000
    shifted = Trajectory.along(new.s + 1000.0, new.x, new.y, new.psi, new.kappa, new.v)
    projection.replace(shifted)
    assert projection.s == pytest.approx(1000.0 + 30.0 + 10.0 * DT * 99, abs=1e-5)
    at = projection.update(beside(old, 34.0), DT)
    assert (at.how, at.s) == ("newton", pytest.approx(1034.0, abs=1e-4))


@pytest.mark.parametrize("method", ["safe", "tipi"])
def test_a_restored_projection_goes_on_bit_for_bit(method):
    road = eight()
    projection = PathProjection(road, method=method)
    follow(projection, road, 10.0 * DT * np.arange(100), e_y=0.3)
    kept = projection.snapshot()
    first = follow(projection, road, 4.0 + 10.0 * DT * np.arange(200), e_y=0.3)
    projection.restore(kept)
    assert follow(projection, road, 4.0 + 10.0 * DT * np.arange(200), e_y=0.3) == first


def test_the_tipi_oracle_agrees_with_the_printed_law():
    """(3.20)-(3.22) integrated by another hand on a clothoid whose point is taken from Fresnel integrals."""
    from scipy.special import fresnel

    sharpness, gain = 5e-4, 8.0
    unit = math.sqrt(math.pi / sharpness)

    def law(t, s):
        y, x = (unit * float(value) for value in fresnel(s[0] / unit))
        psi, kappa = 0.5 * sharpness * s[0] ** 2, sharpness * s[0]
        dx, dy = 3.0 + 9.0 * t - x, 2.0 - y
        e_x, e_y = dx * math.cos(psi) + dy * math.sin(psi), dy * math.cos(psi) - dx * math.sin(psi)
        return [gain * e_x + 9.0 * math.cos(psi) / (1 - kappa * e_y)]

    road = clothoid(sharpness, 60.0)
    projection = PathProjection(road, method="tipi", gain=gain)
    first = projection.update(VehicleState(3.0, 2.0, 0.0, 9.0, 0.0, 0.0), 1e-3)
    dt = 1e-3
    for k in range(3000):
        at = projection.update(VehicleState(3.0 + 9.0 * dt * k, 2.0, 0.0, 9.0, 0.0, 0.0), dt)
    wanted = solve_ivp(law, (0.0, 3.0), [first.s], rtol=1e-10, atol=1e-10).y[0, -1]
    assert at.s == pytest.approx(wanted, abs=0.02)
