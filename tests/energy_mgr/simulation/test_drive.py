"""The closed loop: accounts, ends, events, seeds, files."""

import json
import math

import numpy as np
import pyarrow.parquet as pq
import pytest

from energy_mgr import PlanningError, Trajectory
from energy_mgr.manager import EnergyManager
from energy_mgr.simulation import Event, simulate
from powertrain import VehicleError
from tests.energy_mgr.following.rig import arc, circle, straight, there_and_stop

SHORT = there_and_stop(length=24.0, cruise=6.0)


def drive(road, vehicle, **options):
    return simulate(road, vehicle, **{"compiled": False, **options})


@pytest.fixture(scope="module")
def short(romo):
    return drive(SHORT, romo)


@pytest.fixture(scope="module")
def any_manager(romo):
    return EnergyManager(romo, SHORT, allocator="equal-split")


def test_it_arrives_where_and_when_the_plan_says_and_every_joule_is_accounted_for(short):
    assert short.outcome == "arrived"
    assert max(short.ledger.imbalance.values()) < 1e-9
    assert short.ledger.unserved == 0.0
    assert short.errors == 0
    assert sum(short.refused.values()) == 0
    assert short.columns["s_m"][-1] == pytest.approx(24.0, abs=0.25)
    assert short.columns["v_x_mps"][-1] == pytest.approx(0.0, abs=0.02)
    assert short.offset_max < 0.02
    assert short.journey_time == pytest.approx(SHORT.journey_time, abs=1.0)


def test_the_columns_are_finite_and_begin_where_the_road_does(short):
    count = len(short.columns["t_s"])
    for name, column in short.columns.items():
        assert column.shape == (count,)
        assert np.all(np.isfinite(column)), name
    assert np.diff(short.columns["t_s"]) == pytest.approx(0.004)
    assert count == sum(short.statuses.values()) == len(short.step_time)
    with pytest.raises(PlanningError, match="no column 'none', expected one of t_s, "):
        short["none"]


def test_the_log_agrees_with_the_account(short):
    """Each mean power of the battery's steps of 20 ms stands in the log for five periods, from the period after the step on."""
    c = short.columns
    power = c["battery_power_w"]
    assert np.all(power[:5] == 0.0)
    steps, logged = len(power) // 5, power[5::5]
    # a step that ends with the drive is in no row any more; the car stands by then, and draws what it did before to 2e-4 J in 27 kJ
    unlogged = (steps - len(logged)) * power[-1]
    assert steps - len(logged) in (0, 1)
    assert 0.02 * (float(np.sum(logged)) + unlogged) == pytest.approx(short.ledger.energy["terminal"], rel=1e-7)
    # over all rows the same but for its beginning and end: 20 ms of what is drawn there, at most 1 kW
    assert float(np.sum(power) * 0.004) == pytest.approx(short.ledger.energy["terminal"], abs=20.0)
    # the work of the forces is the change of kinetic energy and the losses, whatever the plan says
    x = c["x_m"]
    assert float(np.trapezoid(c["v_x_mps"], c["t_s"])) == pytest.approx(float(x[-1] - x[0]), abs=0.02)
    energy = short.ledger.energy
    assert short.drive_energy == pytest.approx(energy["terminal"] - energy["auxiliary"] - energy["converter"])
    assert short.battery_energy == energy["terminal"]


def test_the_file_reads_back(romo, short, tmp_path):
    path = short.save(tmp_path / "new" / "log.parquet")
    table = pq.read_table(path)
    assert table.column_names == list(short.columns)
    for name, column in short.columns.items():
        assert np.array_equal(table[name].to_numpy(), column)
    about = json.loads(table.schema.metadata[b"energy_mgr.drive"])
    assert (about["outcome"], about["vehicle"], about["allocator"]) == ("arrived", romo.name, "efficient")
    assert sorted(file.name for file in path.parent.iterdir()) == ["log.parquet"]
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(PlanningError, match="cannot be written"):
        short.save(blocked / "log.parquet")


def test_the_same_seed_gives_the_same_log_and_another_seed_another(romo):
    road, options = straight(60.0, v=8.0), {"sensors": "real", "longest": 0.8}
    one, same, other = (drive(road, romo, seed=seed, **options) for seed in (4, 4, 5))
    for name, column in one.columns.items():
        if name != "step_time_s":
            assert np.array_equal(column, same.columns[name], equal_nan=True), name
    assert not np.array_equal(one.columns["torque_cmd_1_nm"], other.columns["torque_cmd_1_nm"])


def test_a_lap_of_a_closed_track_ends_after_one_lap(romo):
    track = circle(radius=20.0, v=7.0)
    found = drive(track, romo)
    assert found.outcome == "arrived"
    assert found.columns["s_m"][-1] - found.columns["s_m"][0] == pytest.approx(track.length, abs=0.1)
    assert found.duration == pytest.approx(track.length / 7.0, rel=0.02)
    assert found.offset_max < 0.1
    # once round: the car is where it began
    assert math.hypot(found.columns["x_m"][-1] - found.columns["x_m"][0], found.columns["y_m"][-1] - found.columns["y_m"][0]) < 0.2


# -- how a drive can end --------------------------------------------------------------------------


def test_too_late(romo):
    found = drive(straight(100.0, v=8.0), romo, longest=1.0)
    assert (found.outcome, found.duration) == ("late", pytest.approx(1.0, abs=0.005))


def test_stopped_when_nothing_is_measured_any_more(romo):
    found = drive(straight(100.0, v=5.0), romo, events=[Event(part="measurement", kind="nan", time_s=1.0)])
    assert found.outcome == "stopped"
    assert found.statuses["stopping"] > 1000
    assert found.refused["not a number"] > 1000
    assert found.errors == 0
    assert abs(found.columns["v_x_mps"][-1]) < 0.02
    assert found.columns["t_s"][np.argmax(found.columns["v_x_mps"] < 0.05)] < 4.5


def test_lost_when_a_car_starts_far_from_the_road(romo):
    found = drive(straight(100.0, v=8.0), romo, offset=10.5)
    assert found.outcome == "lost"


def test_lost_on_ice_in_a_bend(romo):
    found = drive(arc(radius=25.0, length=120.0, v=11.0), romo, events=[Event(part="friction", kind="value", share=0.05, time_s=0.5)])
    assert found.outcome == "lost"
    assert found.errors == 0


# -- events ---------------------------------------------------------------------------------------


def during(found, event, name):
    """A column before, while and after an event; the ends are left out by 0.15 s."""
    t, column = found.columns["t_s"], found[name]
    end = event.time_s + event.duration_s
    return column[t < event.time_s], column[(t > event.time_s + 0.15) & (t < end)], column[t > end + 0.15]


def assert_on_time(found):
    """At the end of its road, and by a tenth of a second when the plan says: the others make up for what is missing."""
    assert found.outcome == "arrived"
    assert found.errors == 0
    assert found.journey_time == pytest.approx(found.trajectory.journey_time, abs=0.1)
    assert found.offset_max < 0.1


def test_a_motor_dies_and_comes_back(romo):
    s = np.linspace(0.0, 20.0, 11)
    event = Event(part="motor_2", kind="dead", time_s=1.0, duration_s=1.0)
    found = drive(straight(20.0, v=np.sqrt(16.0 + 2.4 * s)), romo, events=[event])
    assert_on_time(found)
    before, while_, after = during(found, event, "torque_2_nm")
    assert np.max(np.abs(while_)) < 1.0
    assert np.max(before) > 10.0
    assert [(round(t, 3), e) for t, e in found.happened] == [(1.0, event)]
    assert all("motor 2 gives" in text for _, text in found.noticed), found.noticed
    assert next(t for t, text in found.noticed if "motor 2" in text) < 1.2
    assert len(after) > 0


def test_a_weak_motor_gives_its_share_of_the_largest_torque(romo):
    s = np.linspace(0.0, 14.0, 8)
    event = Event(part="motor_1", kind="weak", share=0.1, time_s=0.5, duration_s=1.0)
    found = drive(straight(14.0, v=np.sqrt(16.0 + 4.0 * s)), romo, events=[event])
    assert_on_time(found)
    before, while_, _ = during(found, event, "torque_1_nm")
    assert np.max(np.abs(while_)) <= 16.0 + 0.5
    assert np.max(np.abs(before)) > 25.0


def test_dead_brakes_give_nothing_and_weak_ones_less(romo):
    """Braking harder than motors can: the wheel's clamp."""
    s = np.linspace(0.0, 40.0, 41)
    road = straight(40.0, v=np.interp(s[::2], s, np.sqrt(np.maximum(18.0**2 - 2 * 4.2 * np.maximum(s - 8.0, 0.0), 16.0))))
    events = [Event(part="brake_fl", kind="dead", time_s=0.0), Event(part="brake_rr", kind="weak", share=0.2, time_s=0.0)]
    found = drive(road, romo, events=events)
    assert_on_time(found)
    assert np.max(found["clamp_fl_nm"]) < 1e-6
    assert np.max(found["clamp_rr_nm"]) <= 0.2 * 530.0 + 1e-6
    assert np.max(found["clamp_fr_nm"]) > 20.0


def test_a_stuck_wheel_stays_and_is_let_go(romo):
    event = Event(part="steer_fr", kind="stuck", time_s=0.5, duration_s=1.0)
    found = drive(arc(radius=-40.0, length=22.0, v=9.0), romo, events=[event])
    # slower while the wheel is stuck
    assert found.outcome == "arrived"
    assert found.journey_time > found.trajectory.journey_time
    assert found.offset_max < 0.1
    _, while_, after = during(found, event, "delta_fr_rad")
    assert np.ptp(while_) < 0.003
    assert len(after) > 100
    assert found.errors == 0


def test_friction_changes_and_comes_back(romo):
    event = Event(part="friction", kind="value", share=0.4, station_m=8.0, duration_s=1.0)
    found = drive(straight(24.0, v=8.0), romo, events=[event])
    assert_on_time(found)
    t, mu = found["t_s"], found["friction"]
    begin = found.happened[0][0]
    assert begin == pytest.approx(1.0, abs=0.1)
    low = mu < 0.9
    assert np.unique(mu).tolist() == [0.4, 1.0]
    assert float(np.sum(low) * 0.004) == pytest.approx(1.0, abs=0.02)
    assert t[np.argmax(low)] == pytest.approx(begin, abs=0.01)


@pytest.mark.parametrize(
    ("kind", "more", "reason"),
    [("nan", {}, "not a number"), ("frozen", {}, "frozen"), ("jump", {"size": 20.0}, "jump"), ("late", {"size": 1.0}, "late")],
)
def test_spoiled_measurements_are_refused_for_their_reason_while_they_last(romo, kind, more, reason):
    event = Event(part="measurement", kind=kind, time_s=0.5, duration_s=0.08, **more)
    found = drive(straight(12.0, v=8.0), romo, events=[event])
    assert_on_time(found)
    others = {name: count for name, count in found.refused.items() if name != reason}
    assert found.refused[reason] == pytest.approx(20, abs=2)
    assert sum(others.values()) == 0
    assert found.statuses["rejected"] == found.refused[reason]
    assert found.offset_max < 0.1
    assert found.errors == 0


@pytest.mark.parametrize(
    ("event", "text"),
    [
        (Event(part="motor_5", kind="dead", time_s=0.0), "event 1: part 'motor_5', expected one of"),
        (Event(part="motor_1", kind="stuck", time_s=0.0), "event 1: motor_1 is 'stuck', expected dead or weak"),
        (Event(part="steer_fl", kind="dead", time_s=0.0), "event 1: steer_fl is 'dead', expected stuck"),
        (Event(part="friction", kind="value", time_s=0.0), "event 1: friction 0.0, expected more than 0"),
        (Event(part="friction", kind="value", share=0.5), "event 1: begins at .* expected at least one"),
        (Event(part="measurement", kind="nan", station_m=math.nan), "event 1: begins at"),
    ],
)
def test_events_that_do_not_fit_are_refused_by_number(romo, any_manager, event, text):
    with pytest.raises(PlanningError, match=text):
        simulate(SHORT, romo, manager=any_manager, events=[event])


@pytest.mark.parametrize(
    "options",
    [
        {"sensors": "none"},
        {"allocator": "none"},
        {"follower": "none"},
        {"cost": "none"},
        {"dt": 0.003},
        {"dt": -1.0},
        {"dt": 0.0},
        {"dt": math.nan},
        {"soc": 2.0},
        {"soc": math.nan},
        {"offset": math.nan},
        {"longest": math.nan},
        {"longest": -1.0},
    ],
    ids=str,
)
def test_options_that_do_not_exist_or_fit_are_refused_in_one_line(romo, any_manager, options):
    with pytest.raises((PlanningError, VehicleError)) as caught:
        drive(SHORT, romo, **({} if options.keys() & {"allocator", "follower", "cost"} else {"manager": any_manager}), **options)
    assert "\n" not in str(caught.value)


def test_a_car_without_steering_is_refused(romo):
    import msgspec

    with pytest.raises(VehicleError, match="steering"):
        simulate(SHORT, msgspec.structs.replace(romo, steering=None))


def test_a_manager_of_ones_own_drives(romo):
    manager = EnergyManager(romo, SHORT, allocator="equal-split")
    found = drive(SHORT, romo, manager=manager, longest=2.0)
    assert found.outcome == "late"
    torques = np.array([found[f"torque_cmd_{k}_nm"] for k in range(1, 5)])
    assert np.ptp(torques, axis=0).max() < 1e-9
    assert isinstance(found.trajectory, Trajectory)
