"""Rows of the joint programme on a road in generic position, for a car that brakes, drives and recuperates unequally, against path and speed."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from energy_mgr.joint.grid import equal_parts
from energy_mgr.joint.programme import JointProgramme, Point
from energy_mgr.joint.start import problem_of, variables_of
from energy_mgr.path import PathOptions, plan_path
from powertrain import drive_energy, driving_resistance, load_vehicle
from powertrain.symbolic import ca
from roads import Road
from tests.energy_mgr.speed.rig import changed
from tests.roads.generic import generic

CAR = changed(load_vehicle("van"), limits={"acceleration_max_mps2": 1.7, "deceleration_max_mps2": 2.6, "lateral_acceleration_max_mps2": 3.3})
BEND, TIME = 0.06, 61.0
ENDS = 3.1, 4.7
Floats = np.ndarray
both = pytest.mark.parametrize("closed", [False, True])


@cache
def made(closed: bool) -> tuple[Road, JointProgramme, Point, Floats, dict[str, tuple[Floats, Floats, Floats]]]:
    """A programme, a point, all its rows, and by name of output those that it bounds: values, lower and upper limits."""
    road, options = generic(2, closed=closed), PathOptions(curvature_max=BEND)
    path = plan_path(road, 1.1, extent="road", options=options)
    problem = problem_of(road, path, 1.1, "road", options)
    programme = JointProgramme(problem, road, CAR, TIME, 2e4, equal_parts(problem, 3.3), *ENDS)
    grid = programme.grid
    v = 6.0 + 1.7 * np.sin(grid.q / 17.0 + 1.0) + np.random.default_rng(5).uniform(-0.3, 0.3, len(grid.q))
    point = Point(variables_of(problem, path), grid.q, v)
    linear, select, lower, upper = programme._rows()
    assembled = programme._assembled(linear, select)
    variables = programme._vector(point)
    rows = np.array(ca.Function("rows", [assembled.nlp["x"]], [assembled.nlp["g"]])(variables)).ravel()
    cost = float(ca.Function("cost", [assembled.nlp["x"]], [assembled.nlp["f"]])(variables))
    named, at = {}, problem.equalities[0].shape[0] + problem.rows.matrix.shape[0] + (1 if closed else 0)
    for names, _, _, where in programme._limits():
        count = grid.count if where is None else len(where)
        for name in names:
            named[name] = rows[at : at + count], lower[at : at + count], upper[at : at + count]
            at += count
    named["time"] = rows[at:], lower[at:], upper[at:]
    named["cost"] = np.array([cost]), np.zeros(1), np.zeros(1)
    return road, programme, point, rows, named


@both
def test_rows_are_the_cars_numbers_on_the_curve(closed: bool):
    road, programme, point, _, named = made(closed)
    q, v, curve = programme.grid.q, point.v, programme.problem.curve(point.x)
    # a circuit's curve ends where it begins
    s = np.append(curve.station(q[:-1]), curve.length)
    middle = curve.station(0.5 * (q[1:] + q[:-1]))
    ds, dz = np.diff(s), np.diff(road.height_at(q))
    gain = np.diff(v**2) / (2.0 * ds)
    kappa = [curve.curvature(s[:-1]), curve.curvature(middle), curve.curvature(s[1:])]
    most, share = CAR.limits.lateral_acceleration_max_mps2, 0.998 * BEND
    expected = {
        "force_gap": 0.0 * ds,
        "gain": gain,
        "lateral_start": kappa[0] * v[:-1] ** 2 / most,
        "lateral_after": kappa[1] * v[:-1] ** 2 / most,
        "lateral_before": kappa[1] * v[1:] ** 2 / most,
        "bend_start": kappa[0] / share,
        "bend_middle": kappa[1] / share,
    }
    if not closed:
        expected |= {"lateral_end": (kappa[2] * v[1:] ** 2 / most)[-1:], "bend_end": (kappa[2] / share)[-1:]}
    scales = programme.scales
    for end, speed in (("start", v[:-1]), ("end", v[1:])):
        force = CAR.effective_mass * gain + driving_resistance(CAR, speed, dz / ds)
        expected |= {f"force_{end}": force / scales.force, f"power_{end}": force * speed / scales.power}
    for name, values in expected.items():
        # Simpson's rule for the way leaves 1e-5 of it; rows are of order one
        assert named[name][0] == pytest.approx(values, abs=3e-4), name
    assert {name for name, rows in named.items() if len(rows[0])} == {*expected, "time", "cost"}
    ledger = drive_energy(CAR, s, v, road.height_at(q))
    assert named["time"][0] * TIME == pytest.approx([ledger.journey_time], rel=1e-4)
    assert named["cost"][0] * 2e4 == pytest.approx([ledger.total], rel=1e-4)


@both
def test_rows_end_at_what_the_car_can(closed: bool):
    _, programme, _, _, named = made(closed)
    drive, own, scales = CAR.drive, CAR.limits, programme.scales
    force, power = drive.motor_count * CAR.motor_ratio / scales.force, drive.motor_count / scales.power
    bounds = {
        "force_gap": (0.0, 0.0),
        "gain": (-own.deceleration_max_mps2, own.acceleration_max_mps2),
        "time": (0.0, 1.0),
    }
    bounds |= {f"force_{end}": (-force * drive.regen_torque_max_nm, force * drive.torque_max_nm) for end in ("start", "end")}
    bounds |= {f"power_{end}": (-power * drive.regen_power_max_w, power * drive.power_max_w) for end in ("start", "end")}
    for name, (_, lower, upper) in named.items():
        if name != "cost":
            assert (set(lower.round(12)), set(upper.round(12))) == tuple({round(x, 12)} if len(lower) else set() for x in bounds.get(name, (-1, 1)))


@both
def test_the_path_stays_between_borders_and_goes_on_smoothly_in_its_rows(closed: bool):
    road, programme, point, rows, _ = made(closed)
    problem = programme.problem
    count = problem.equalities[0].shape[0]
    _, _, lower, upper = programme._rows()
    # the path was planned as a solution of these equalities
    assert rows[:count] == pytest.approx(lower[:count], abs=1e-6)
    assert np.array_equal(lower[:count], upper[:count])
    inside = slice(count, count + problem.rows.matrix.shape[0])
    places = problem.curve(point.x).pieces(problem.row_q)[0]
    offset = np.sum((places - road.reference.position(problem.row_q)) * road.reference.normal(problem.row_q), axis=1)
    right, left = road.corridor("road", 1.1).offsets(problem.row_q)
    assert (upper - rows)[inside] == pytest.approx(left - 5e-4 - offset, abs=1e-8)
    assert (rows - lower)[inside] == pytest.approx(offset - right - 5e-4, abs=1e-8)
    if closed:
        seam = inside.stop
        assert (lower[seam], upper[seam]) == (0.0, 0.0)
        assert rows[seam] * programme.scales.speed == pytest.approx(point.v[0] - point.v[-1], abs=1e-12)


@both
def test_speeds_are_bounded_by_what_is_posted_in_both_intervals_beside_and_by_the_ends(closed: bool):
    road, programme, point, _, _ = made(closed)
    q, size = programme.grid.q, programme.problem.spline.size
    least, most = (bound[size : size + len(q)] * programme.scales.speed for bound in programme._bounds())
    inside = [np.min(road.speed_limit_at(np.linspace(a, b, 200)[1:-1])) for a, b in pairwise(q)]
    inside = np.minimum(inside, CAR.limits.speed_max_mps)
    before = np.append(inside[-1] if closed else inside[0], inside)
    after = np.append(inside, inside[0] if closed else inside[-1])
    expected = np.minimum(before, after)
    inner = slice(None) if closed else slice(1, -1)
    assert np.all(most[inner] <= expected[inner] + 1e-9)
    # a change right at a station counts on both of its sides
    assert np.mean(most[inner] < expected[inner] - 1e-9) < 0.1
    if not closed:
        assert (least[0], most[0], least[-1], most[-1]) == pytest.approx((ENDS[0], ENDS[0], ENDS[1], ENDS[1]))
    again = point.on(np.linspace(q[0], q[-1], 333))
    assert again.v**2 == pytest.approx(np.interp(again.q, q, point.v**2), rel=1e-12)
