import numpy as np
import pytest

import roads
from energy_mgr.joint.grid import Grid, equal_parts, finer_parts
from energy_mgr.joint.interval import OUTPUTS, interval_function
from energy_mgr.joint.programme import JointProgramme, Point
from energy_mgr.joint.start import problem_of, speeds_on, variables_of
from energy_mgr.path import PathOptions, plan_path
from energy_mgr.speed import SpeedLimits, eco_profile, fastest_profile
from powertrain import Vehicle, drive_energy, driving_resistance
from powertrain.symbolic import ca
from roads import Road, RoadBuilder

CLEARANCE = 1.05


def bend(angle: float = 1.2, limit: float = 20.0) -> Road:
    return RoadBuilder("bend").limit(limit).straight(60).bend(40, angle, 15).straight(60).build()


def made(road: Road, vehicle: Vehicle, step: float = 4.0, slower: float = 1.05) -> tuple[JointProgramme, Point]:
    """The programme of a road and the sequential plan as its start."""
    options = PathOptions()
    path = plan_path(road, CLEARANCE, extent="road", options=options)
    limits = SpeedLimits.along(road, path, vehicle)
    duration = slower * fastest_profile(limits).journey_time
    profile = eco_profile(limits, duration)
    problem = problem_of(road, path, CLEARANCE, "road", options)
    programme = JointProgramme(problem, road, vehicle, duration, 1e4, equal_parts(problem, step))
    x = variables_of(problem, path)
    return programme, Point(x, programme.grid.q, speeds_on(programme.grid, x, profile, vehicle))


@pytest.mark.parametrize("closed", [False, True])
def test_a_path_is_read_back_into_the_variables_it_was_made_from(closed: bool):
    road = roads.open_road("handling") if closed else bend()
    path = plan_path(road, CLEARANCE, extent="road")
    problem = problem_of(road, path, CLEARANCE, "road", PathOptions())
    again = problem.curve(variables_of(problem, path)).pieces
    # coefficients are numbers up to the road's size in metres; rounding leaves 1e-12 of that
    assert np.max(np.abs(again.coefficients - path.curve.pieces.coefficients)) < 1e-9


def test_grid_sees_the_lengths_and_curvatures_of_the_curve(romo: Vehicle):
    programme, point = made(bend(), romo)
    grid, curve = programme.grid, programme.problem.curve(point.x)
    s = curve.station(grid.q)
    # Simpson's rule over 4 m against Gauss-Legendre per piece
    assert np.allclose(grid.lengths(point.x), np.diff(s), rtol=1e-5)
    assert np.allclose(grid.curvatures(point.x)[:, 0], curve.curvature(s[:-1]), atol=1e-9)
    assert np.allclose(grid.curvatures(point.x)[:, 2], curve.curvature(s[1:]), atol=1e-9)


def test_posted_limit_holds_in_both_intervals_beside_a_station(romo: Vehicle):
    road = RoadBuilder("limits").limit(20.0).straight(50).limit(10.0).straight(50.5).limit(20.0).straight(60).build()
    path = plan_path(road, CLEARANCE)
    problem = problem_of(road, path, CLEARANCE, "own", PathOptions())
    grid = Grid.of(problem, road, romo, equal_parts(problem, 4.0))
    for start, end, low, high in zip(grid.q[:-1], grid.q[1:], grid.v_posted[:-1], grid.v_posted[1:], strict=True):
        least = np.min(road.speed_limit_at(np.linspace(start, end, 101)))
        assert max(low, high) <= least + 1e-12


def test_derivatives_are_those_of_automatic_differentiation(romo: Vehicle, rng: np.random.Generator):
    programme, point = made(bend(), romo, step=12.0)
    linear, select, _, _ = programme._rows()
    assembled = programme._assembled(linear, select)
    x = assembled.nlp["x"]
    scale, multipliers = ca.MX.sym("scale"), ca.MX.sym("multipliers", linear.shape[0])
    lagrangian = scale * assembled.nlp["f"] + ca.dot(multipliers, assembled.nlp["g"])
    plain = ca.Function(
        "plain", [x, scale, multipliers], [ca.gradient(assembled.nlp["f"], x), ca.jacobian(assembled.nlp["g"], x), ca.hessian(lagrangian, x)[0]]
    )
    at = programme._vector(point) + 1e-2 * rng.standard_normal(x.shape[0]) * (programme._vector(point) != 0.0)
    weights = rng.standard_normal(linear.shape[0])
    gradient, jacobian, hessian = (np.array(one.full()) for one in plain(at, 0.7, weights))
    ours = assembled.derivatives
    assert np.allclose(np.array(ours["grad_f"](at, [])[1]).ravel(), gradient.ravel(), rtol=1e-10, atol=1e-12)
    assert np.allclose(ours["jac_g"](at, [])[1].full(), jacobian, rtol=1e-10, atol=1e-12)
    upper = ours["hess_lag"](at, [], 0.7, weights).full()
    assert np.allclose(upper, np.triu(hessian), rtol=1e-9, atol=1e-9 * np.max(np.abs(hessian)))


def test_interval_knows_the_circle(romo: Vehicle):
    """Local variables do not matter where the table says that none does: a piece of circle, driven at constant speed."""
    radius, speed = 20.0, 6.0
    angles = np.array([0.0, 0.05, 0.1])  # of a parameter that runs along the circle, hence |p| = 1
    first = np.column_stack([np.cos(angles), np.sin(angles)])
    second = np.column_stack([-np.sin(angles), np.cos(angles)]) / radius
    programme, _ = made(bend(), romo, step=12.0)
    function = interval_function(romo, programme.scales)
    # the last path variable is one and carries the second derivative
    maps = np.zeros((2, 3, 2, 6))
    maps[1, :, :, 5] = second
    local = np.array([0, 0, 0, 0, 0, 1.0, speed / programme.scales.speed, speed / programme.scales.speed, 0, 0])
    table = np.concatenate([[2.0, 0.0], maps[0].ravel(), first.ravel(), maps[1].ravel()])
    found = dict(zip(OUTPUTS, np.array(function(local, table)).ravel(), strict=True))
    assert found["time"] == pytest.approx(2.0 / speed)
    assert found["gain"] == pytest.approx(0.0, abs=1e-12)
    for name in ("lateral_start", "lateral_after", "lateral_before", "lateral_end"):
        assert found[name] == pytest.approx(speed**2 / radius / romo.limits.lateral_acceleration_max_mps2)


def test_each_end_of_an_interval_has_the_force_and_the_power_of_its_own_speed(romo: Vehicle):
    way, rise, speeds = 4.0, 0.2, (6.0, 9.0)
    programme, _ = made(bend(), romo, step=12.0)
    scales = programme.scales
    # a straight: the constant part of the first derivative alone, one metre of path per metre of road
    table = np.concatenate([[way, rise], np.zeros(36), np.tile([1.0, 0.0], 3), np.zeros(36)])
    local = np.array([*np.zeros(6), *(v / scales.speed for v in speeds), 0.0, 0.0])
    found = dict(zip(OUTPUTS, np.array(interval_function(romo, scales)(local, table)).ravel(), strict=True))
    gain = (speeds[1] ** 2 - speeds[0] ** 2) / (2.0 * way)
    for end, v in zip(("start", "end"), speeds, strict=True):
        force = romo.effective_mass * gain + driving_resistance(romo, v, rise / way)
        assert found[f"force_{end}"] * scales.force == pytest.approx(force, rel=1e-12)
        assert found[f"power_{end}"] * scales.power == pytest.approx(force * v, rel=1e-12)


@pytest.mark.parametrize("name", ["bend", "handling"])
def test_energy_and_limits_hold_on_the_curve_that_was_found(name: str, romo: Vehicle):
    road = bend() if name == "bend" else roads.open_road(name)
    programme, start = made(road, romo)
    found = programme.solve(start)
    grid, point, curve = programme.grid, found.point, programme.problem.curve(found.point.x)
    s = curve.station(grid.q)
    ledger = drive_energy(romo, s, point.v, road.height_at(grid.q))
    # asked for: 0.1 %; what differs is Simpson's rule for the way, 1e-5 of it
    assert found.energy == pytest.approx(ledger.total, rel=1e-4)
    assert ledger.journey_time == pytest.approx(programme.journey_time, rel=1e-4)
    own, gain = romo.limits, np.diff(point.v**2) / (2.0 * np.diff(s))
    assert np.max(gain) <= own.acceleration_max_mps2 * 1.001
    assert np.min(gain) >= -own.deceleration_max_mps2 * 1.001
    assert np.max(np.abs(curve.curvature(s)) * point.v**2) <= own.lateral_acceleration_max_mps2 * 1.001
    assert np.all(point.v <= grid.v_posted + 1e-6)
    assert programme.problem.worst_row(point.x)[0] < 1e-5
    if road.closed:
        assert point.v[0] == pytest.approx(point.v[-1], abs=1e-6)
    else:
        assert point.v[0] == point.v[-1] == 0.0


def test_intervals_are_halved_where_a_peak_lies_between_their_places(romo: Vehicle):
    road = bend(angle=2.4)
    programme, start = made(road, romo, step=12.0)
    problem, parts = programme.problem, programme.parts
    curve, bound = problem.curve(start.x), 4.0
    slow = finer_parts(problem, parts, start.x, np.full(len(programme.grid.q), 1.0), bound)
    assert np.array_equal(slow, parts)
    sharpest = np.max(np.abs(curve.curvature(np.arange(0.0, curve.length, 0.05))))
    quick = finer_parts(problem, parts, start.x, np.full(len(programme.grid.q), 1.1 * bound / sharpest), bound)
    at = problem.spline.segment_of(np.array([curve.parameter(np.argmax(np.abs(curve.curvature(np.arange(0.0, curve.length, 0.05)))) * 0.05)]))[0]
    assert quick[at] == 2 * parts[at]
    assert np.sum(quick != parts) < 0.3 * len(parts)
