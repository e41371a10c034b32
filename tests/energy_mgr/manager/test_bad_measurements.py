"""What sensors send when they fail: refused, counted, survived."""

import gc
import json
import math
import tracemalloc
from decimal import Decimal

import numpy as np
import pytest

from energy_mgr import PlanningError
from energy_mgr.manager import EnergyManager, Measurements, Trust
from tests.energy_mgr.following.rig import straight
from tests.energy_mgr.manager.rig import DT, assert_allowed, rolled, rolling

NUMBERS = [name for name in Measurements._fields if name not in ("wheel_speeds", "torques", "angles", "brakes")]
TUPLES = {"wheel_speeds": 4, "torques": 4, "angles": 4, "brakes": 4}


def refused(manager, bad, k=10, reason="not a number"):
    """The commands after `bad`, checked to be the last ones and counted for `reason`."""
    counted, last = dict(manager.refused), manager.allocation.command.tolist()
    commands = manager.step(bad, DT * k)
    assert (commands.status, commands.reason) == ("rejected", reason)
    assert list(commands.inputs) == last
    assert manager.refused == {**counted, reason: counted[reason] + 1}
    assert manager.errors == 0
    return commands


@pytest.fixture(scope="module")
def made(romo):
    """One manager for all, with its memory new and after ten good measurements."""
    manager = EnergyManager(romo, straight())
    new = manager.snapshot()
    for k in range(10):
        manager.step(rolling(k), DT * k)
    return manager, new, manager.snapshot(), manager.allocation


@pytest.fixture
def fresh(made):
    made[0].restore(made[1])
    return made[0]


@pytest.fixture
def manager(made):
    manager, _, kept, manager.allocation = made
    manager.restore(kept)
    return manager


@pytest.mark.parametrize("field", NUMBERS)
def test_no_number_in_any_field_is_believed(manager, field):
    values = [math.nan, "12", (1.0,), [1.0, 2.0], {}, 1j, Decimal(1), object()]
    if field != "pose_time":
        values.append(None)
    if field not in ("power_min", "power_max"):
        values += [math.inf, -math.inf]
    for value in values:
        refused(manager, rolling(10)._replace(**{field: value}))
    recovered = manager.step(rolling(10), 10 * DT)
    assert recovered.status == "solved"


@pytest.mark.parametrize("field", TUPLES)
def test_no_wrong_list_is_believed(manager, field):
    good, count = (1.0,) * TUPLES[field], TUPLES[field]
    bad = [(math.nan, *good[1:]), (*good[1:], math.inf), good[1:], (*good, 1.0), ("a",) * count, (None,) * count, None, 1.0, "abcd", (good,) * count]
    for value in bad:
        refused(manager, rolling(10)._replace(**{field: value}))


@pytest.mark.parametrize("bad", [None, (), (1.0,) * 9, "measurement", 3.0, {}, [math.nan] * 18, object()])
def test_what_is_no_measurement_at_all_is_refused(manager, bad):
    refused(manager, bad)


def test_windows_the_wrong_way_round_and_roads_without_friction_are_refused(manager):
    refused(manager, rolling(10, power_min=10.0, power_max=-10.0))
    refused(manager, rolling(10, power_min=math.nan))
    refused(manager, rolling(10, friction=0.0))
    refused(manager, rolling(10, friction=-1.0))


def test_integers_beyond_floats_are_refused(manager):
    refused(manager, rolling(10, x=10**400))
    refused(manager, rolling(10, torques=(10**400, 0, 0, 0)))


@pytest.mark.parametrize("field", ["a_x", "a_y", "friction", "soc", "power_min", "power_max", "pose_time", "v_y", "yaw_rate", "psi", "y"])
@pytest.mark.parametrize("size", [1e6, 1e30, 1e200, -1e6, -1e30, -1e200])
def test_absurd_but_finite_numbers_spoil_no_command_and_no_later_one(made, field, size):
    manager = made[0]
    for k, kept in ((0, made[1]), (10, made[2])):
        manager.restore(kept)
        commands = manager.step(rolling(k, **{field: size}), DT * k)
        before = commands
        assert manager.errors == 0, manager.last_error
        assert np.all(np.isfinite(commands.inputs)), commands
        statuses = []
        for later in range(k + 1, k + 30):
            commands = manager.step(rolling(later), DT * later)
            assert_allowed(manager, commands, before)
            before = commands
            statuses.append(commands.status)
        assert manager.errors == 0, manager.last_error
        assert statuses[-1] in ("solved", "limited")


@pytest.mark.parametrize("field", list(TUPLES))
@pytest.mark.parametrize("size", [1e6, 1e200, -1e200])
def test_absurd_reports_of_drives_spoil_no_command(manager, field, size):
    before = manager.step(rolling(10), 10 * DT)
    for k in range(11, 20):
        commands = manager.step(rolling(k, **{field: (size,) * 4}), DT * k)
        assert np.all(np.isfinite(commands.inputs)), commands
        assert manager.errors == 0, manager.last_error
    for k in range(20, 60):
        commands = manager.step(rolling(k), DT * k)
        assert np.all(np.isfinite(commands.inputs))
    assert np.all(np.abs(commands.inputs) <= manager.allocator.layout.upper + 1e-9)
    assert before.status == "solved"


def test_arrays_do_as_well_as_tuples(romo):
    """Plain data is asked for; NumPy users send arrays nevertheless."""
    plain, arrays = rolled(romo), rolled(romo)
    layout = plain.allocator.layout
    for k in range(10, 20):
        m = rolling(k, layout=layout)
        one = plain.step(m, DT * k)
        other = arrays.step(m._replace(wheel_speeds=np.array(m.wheel_speeds), torques=np.array(m.torques), angles=np.array(m.angles)), DT * k)
        assert arrays.errors == 0, arrays.last_error
        assert one == other


def test_frozen_numbers_of_a_moving_car_are_refused_those_of_a_standing_one_not(romo, manager):
    frozen = rolling(9)
    for k in range(10, 20):
        refused(manager, frozen._replace(t=DT * k), k, "frozen")
    standing = EnergyManager(romo, straight())
    for k in range(20):
        assert standing.step(rolling(k, v=0.0), DT * k).status in ("solved", "limited")
    assert sum(standing.refused.values()) == 0


def test_late_future_and_backward_measurements_are_refused(manager):
    refused(manager, rolling(10, t=10 * DT - 0.11), reason="late")
    refused(manager, rolling(11), reason="late")  # of the next period
    refused(manager, rolling(9), reason="late")  # seen already
    refused(manager, rolling(4), reason="late")
    refused(manager, rolling(10, pose_time=10 * DT + 0.01), reason="late")
    for t in (math.nan, math.inf, -math.inf, -1.0):
        commands = manager.step(rolling(10), t)
        assert commands.status in ("rejected", "stopping")
        assert np.all(np.isfinite(commands.inputs))
    assert manager.errors == 0
    assert manager.step(rolling(10), 10 * DT).status in ("solved", "limited")  # some of the clocks have closed the brakes


@pytest.mark.parametrize("jump", [{"x": 5.0}, {"y": -2.0}, {"psi": 1.0}, {"v_x": 15.0}, {"v_y": 3.0}, {"yaw_rate": -2.0}])
def test_a_jump_is_refused_and_one_that_lasts_is_the_new_truth(manager, jump):

    def jumped(k):
        m = rolling(k)
        return m._replace(**{name: (getattr(m, name) if name == "x" else 0.0) + by for name, by in jump.items()})

    refused(manager, jumped(10), reason="jump")
    assert manager.step(rolling(11), 11 * DT).status in ("solved", "limited")
    lasting = {"x", "y", "psi"} & jump.keys()  # a car that stays so fast moves otherwise
    if not lasting:
        return
    statuses = [manager.step(jumped(k), DT * k).status for k in range(12, 60)]
    believed = next(k for k, status in enumerate(statuses) if status != "rejected")
    assert believed == Trust().again - 1
    assert "rejected" not in statuses[believed:]
    assert manager.errors == 0


def test_scattered_jumps_are_never_the_new_truth(manager, rng):
    for k in range(10, 60):
        m = rolling(k)
        commands = manager.step(m._replace(x=m.x + rng.uniform(20, 500)), DT * k)
        assert commands.status in ("rejected", "stopping")


def test_a_heading_that_is_wrapped_is_no_jump(manager):
    for k in range(10, 20):
        assert manager.step(rolling(k, psi=2 * math.pi * (k % 3 - 1)), DT * k).status == "solved"


def test_without_measurements_the_car_is_stopped_blindly_and_goes_on_when_they_come_back(romo):
    manager = rolled(romo)
    layout, before, statuses = manager.allocator.layout, None, []
    for k in range(10, 260):
        commands = manager.step(rolling(k, x=math.nan), DT * k)
        statuses.append(commands.status)
        if before is not None:
            assert_allowed(manager, commands, before)
        before = commands
    patience = statuses.index("stopping")
    assert DT * patience == pytest.approx(Trust().patience, abs=2 * DT)
    assert set(statuses[:patience]) == {"rejected"}
    assert set(statuses[patience:]) == {"stopping"}
    assert before.torques == (0.0,) * 4
    force = sum(before.brakes) / romo.chassis.wheel_radius_m / romo.chassis.mass_kg
    assert 2.0 < force < 4.0
    assert np.all(np.array(before.brakes) <= layout.upper[layout.brakes])
    back = [manager.step(rolling(k), DT * k).status for k in range(260, 400)]
    assert set(back) <= {"solved", "limited"}
    assert back[-1] == "solved"
    assert manager.errors == 0


def test_a_manager_that_never_saw_a_good_measurement_holds_the_car(romo):
    manager = EnergyManager(romo, straight())
    for k in range(200):
        commands = manager.step(rolling(k, x=math.nan), DT * k)
        assert commands.torques == (0.0,) * 4
        assert all(map(math.isfinite, commands.inputs))
    assert commands.status == "stopping"
    assert sum(commands.brakes) > 500.0


@pytest.mark.parametrize("count", [4_000, pytest.param(20_000, marks=pytest.mark.slow)])
def test_memory_stays_over_thousands_of_steps(romo, count):
    """A lap after lap of good, bad and late measurements."""
    from tests.energy_mgr.following.rig import circle

    manager, radius, v = EnergyManager(romo, circle(radius=30.0, v=8.0)), 30.0, 8.0
    rng = np.random.default_rng(1)

    def run(start, count):
        for k in range(start, start + count):
            angle = v * DT * k / radius
            place = (radius * math.sin(angle), -radius * math.cos(angle), angle)
            m = Measurements(DT * k, *place, v, 0.0, v / radius, 0.0, v * v / radius, (v / 0.27365,) * 4)
            if rng.random() < 0.1:
                m = m._replace(y=float(rng.choice([math.nan, 1e3])))
            manager.step(m, DT * k)

    run(0, 1000)
    tracemalloc.start()
    run(1000, 1000)
    gc.collect()  # empties the interpreter's stock of old tuples
    first = tracemalloc.get_traced_memory()[0]
    run(2000, count - 2000)
    gc.collect()
    grown = tracemalloc.get_traced_memory()[0] - first
    tracemalloc.stop()
    assert grown < 20_000
    assert manager.errors == 0
    assert len(json.dumps(manager.refused)) < 200


@pytest.mark.parametrize("name", ["age", "patience", "place", "again"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan])
def test_trust_that_is_none_is_refused(name, value):
    with pytest.raises(PlanningError, match=f"trust in measurements: {name} = "):
        Trust(**{name: value})
