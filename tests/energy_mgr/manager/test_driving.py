"""The manager on a plant: continuation, faults noticed and none imagined, every law with every allocator, standing on a slope."""

import itertools
import json
import math

import msgspec
import numpy as np
import pytest

from energy_mgr import PlanningError
from energy_mgr.allocation import ALLOCATORS, NO_FAULTS, Layout
from energy_mgr.following import LAWS
from energy_mgr.manager import DeadReckoning, EnergyManager
from energy_mgr.manager.monitor import Monitor
from powertrain import Plant, VehicleError, load_vehicle, shipped
from tests.energy_mgr.following.rig import arc, straight, there_and_stop
from tests.energy_mgr.manager.rig import DT, Loop

ROAD = arc(radius=40.0, length=120.0, v=9.0)


@pytest.mark.parametrize("allocator", ALLOCATORS)
def test_a_restored_manager_drives_on_bit_for_bit(romo, allocator):
    """Snapshot in the middle of a bend with measurements failing; the same plant goes on with either manager."""
    rng = np.random.default_rng(3)
    loop = Loop(EnergyManager(romo, ROAD, allocator=allocator, observer=DeadReckoning()), ROAD)
    seen = []

    def spoil(m):
        seen.append(m._replace(y=math.nan) if rng.random() < 0.1 else m)
        return seen[-1]

    for _ in range(150):
        loop.period(spoil=spoil)
    kept = loop.manager.snapshot()
    again = EnergyManager(romo, ROAD, allocator=allocator, observer=DeadReckoning())
    again.restore(kept)
    start = len(seen)
    first = [loop.period(spoil=spoil) for _ in range(100)]
    second = [again.step(m, m.t) for m in seen[start:]]
    assert second == first
    assert again.refused == loop.manager.refused
    assert again.errors == loop.manager.errors == 0
    assert np.array([c.inputs for c in first]).tobytes() == np.array([c.inputs for c in second]).tobytes()


@pytest.mark.parametrize("law", LAWS)
def test_a_snapshot_survives_json(romo, law):
    loop = Loop(EnergyManager(romo, ROAD, follower=law, observer=DeadReckoning()), ROAD)
    seen = []
    for _ in range(60):
        loop.period(spoil=lambda m: seen.append(m) or m)
    kept = json.loads(json.dumps(loop.manager.snapshot()))
    again = EnergyManager(romo, ROAD, follower=law, observer=DeadReckoning())
    again.restore(kept)
    start = len(seen)
    first = [loop.period(spoil=lambda m: seen.append(m) or m) for _ in range(60)]
    assert [again.step(m, m.t) for m in seen[start:]] == first
    assert again.errors == 0, again.last_error


def combinations():
    """All; each law and each allocator at least once without the slow ones."""
    quick = set(zip(itertools.cycle(LAWS), ALLOCATORS, strict=False))
    return [pytest.param(*pair, marks=() if pair in quick else pytest.mark.slow) for pair in itertools.product(LAWS, ALLOCATORS)]


@pytest.mark.parametrize(("law", "allocator"), combinations())
def test_every_law_drives_with_every_allocator(romo, law, allocator):
    """Five seconds of a bend from a little beside it."""
    loop = Loop(EnergyManager(romo, ROAD, follower=law, allocator=allocator), ROAD)
    loop.plant.state[loop.at["y"]] += 0.3
    statuses = {loop.period().status for _ in range(1250)}
    manager = loop.manager
    assert manager.errors == 0, manager.last_error
    assert sum(manager.refused.values()) == 0
    assert statuses <= {"solved", "limited"}
    assert manager.faults is NO_FAULTS
    # the published PDs have constant gains and no integral part
    assert abs(manager.following.at.e_y) < (0.3 if law == "pd" else 0.1)
    assert loop.speed == pytest.approx(9.0, abs=0.5)


@pytest.mark.parametrize("name", shipped())
@pytest.mark.parametrize("allocator", ["efficient", *(pytest.param(name, marks=pytest.mark.slow) for name in ("preview", "two-step"))])
def test_every_shipped_car_drives(name, allocator):
    vehicle = load_vehicle(name)
    loop = Loop(EnergyManager(vehicle, ROAD, allocator=allocator), ROAD)
    for _ in range(1000):
        loop.period()
    assert loop.manager.errors == 0, loop.manager.last_error
    assert loop.manager.faults is NO_FAULTS
    assert abs(loop.manager.following.at.e_y) < 0.25
    assert loop.speed == pytest.approx(9.0, abs=0.5)


@pytest.mark.parametrize("section", ["body", "brakes", "steering"])
def test_a_car_that_lacks_a_section_is_refused_in_one_line(romo, section):
    with pytest.raises(VehicleError, match=section) as caught:
        EnergyManager(msgspec.structs.replace(romo, **{section: None}), ROAD)
    assert "\n" not in str(caught.value)


def test_options_that_do_not_exist_are_refused(romo):
    for options in ({"allocator": "none"}, {"follower": "none"}, {"cost": "none"}, {"period": 0.0}, {"period": math.nan}):
        with pytest.raises(PlanningError, match="expected"):
            EnergyManager(romo, ROAD, **options)


@pytest.mark.parametrize("grade", [0.08, -0.08])
def test_who_has_arrived_is_held_on_the_slope(romo, grade):
    road = there_and_stop(length=20.0, cruise=5.0, grade=grade)
    loop = Loop(EnergyManager(romo, road), road)
    for _ in range(5000):
        if loop.period().status == "arrived":
            break
    else:
        pytest.fail("never arrived")
    assert abs(loop.manager.following.at.s - 20.0) < 0.3
    for _ in range(100):
        commands = loop.period()
    place = float(loop.plant.state[loop.at["x"]])
    for _ in range(1000):
        commands = loop.period()
        assert commands.status == "arrived"
        assert commands.torques == (0.0,) * 4
    # 1.5 m/s^2 of brakes against 0.8 of slope
    assert abs(float(loop.plant.state[loop.at["x"]]) - place) < 0.01
    assert loop.speed < 0.005


# -- faults ---------------------------------------------------------------------------------------


def noticed(loop, change, most=250):
    """Periods until the manager says that there is a fault."""
    for k in range(most):
        loop.period(change=change)
        if loop.manager.faults is not NO_FAULTS:
            return k
    return math.inf


@pytest.mark.parametrize(
    ("motor", "share"), [(0, 0.0), (3, 0.4), *(pytest.param(*pair, marks=pytest.mark.slow) for pair in ((0, 0.4), (1, 0.0), (2, 0.0), (3, 0.0)))]
)
def test_a_dead_or_weak_motor_is_found_within_two_tenths_of_a_second(romo, motor, share):
    s = np.linspace(0.0, 150.0, 76)
    road = straight(150.0, v=np.sqrt(25.0 + 2 * 1.2 * s))
    loop = Loop(EnergyManager(romo, road), road)
    for _ in range(200):
        loop.period()

    def change(inputs, t):
        inputs[motor] *= share
        return inputs

    assert noticed(loop, change) * DT <= 0.2
    found = loop.manager.faults
    assert [k for k, left in enumerate(found.motors) if left != 1.0] == [motor]
    # of its largest torque: what it reports, of which nobody knows whether it could be more
    assert found.motors[motor] <= share + 0.05
    assert found.motors[motor] > 0.0 or share == 0.0
    assert all(angle is None for angle in found.stuck)
    for _ in range(250):
        commands = loop.period(change=change)
    assert f"motor {motor + 1} gives" in commands.reason
    assert loop.manager.errors == 0


@pytest.mark.parametrize("wheel", [0, 2, pytest.param(1, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
def test_stuck_steering_is_found_within_two_tenths_of_a_second_and_survived(romo, wheel):
    """Stuck while the road begins to bend."""
    from tests.energy_mgr.following.rig import clothoid

    road = clothoid(sharpness=1.5e-3, length=60.0, v=9.0)
    loop = Loop(EnergyManager(romo, road), road)
    for _ in range(200):
        loop.period()
    place = loop.plant.body.inputs.index(("steer_cmd_fl", "steer_cmd_fr", "steer_cmd_rl", "steer_cmd_rr")[wheel])
    angle = float(loop.plant.state[loop.angles[wheel]])

    def change(inputs, t):
        inputs[place] = angle
        return inputs

    since, began = math.inf, None
    for k in range(700):
        commands = loop.period(change=change)
        if began is None and abs(commands.angles[wheel] - angle) > 0.015:
            began = k  # from here on it is to be seen
        if loop.manager.faults is not NO_FAULTS:
            since = k
            break
    if began is None and wheel >= 2:  # a rear wheel is hardly turned on this road: nothing to be seen, nothing lost
        assert abs(loop.manager.following.at.e_y) < 0.1
        return
    assert began is not None
    assert (since - began) * DT <= 0.2
    stuck = loop.manager.faults.stuck
    assert [k for k, at in enumerate(stuck) if at is not None] == [wheel]
    assert stuck[wheel] == pytest.approx(angle, abs=0.01)
    for _ in range(200):
        loop.period(change=change)
    assert abs(loop.manager.following.at.e_y) < 0.5
    assert loop.manager.errors == 0


def hard_commands(rng, vehicle, layout):
    """Launch, emergency braking, and a slalom with torque reversals, all as fast as commands may change; (t, target) by time."""
    full = layout.upper.copy()
    for k in range(5000):
        t = k * DT
        target = np.zeros(layout.size)
        if t < 2.0:  # launch
            target[layout.torques] = full[layout.torques]
        elif t < 3.0:  # emergency
            target[layout.torques], target[layout.brakes] = layout.lower[layout.torques], full[layout.brakes]
        elif t < 12.0:  # double lane changes at full rate with reversals
            sign = 1.0 if math.sin(2 * math.pi * 0.6 * t) > 0 else -1.0
            target[layout.steers] = sign * np.where(np.arange(len(layout.steered)) < 2, 0.06, -0.03)
            target[layout.torques] = full[layout.torques] * (1.0 if math.sin(2 * math.pi * 2.3 * t) > 0 else -0.9)
        else:  # steps of everything
            if k % 20 == 0:
                hard_commands.kept = layout.lower + rng.random(layout.size) * (full - layout.lower)
                hard_commands.kept[layout.steers] *= 0.15
                hard_commands.kept[layout.brakes] *= 0.05
            target = hard_commands.kept
        yield t, target


@pytest.mark.parametrize("name", ["romo", *(pytest.param(name, marks=pytest.mark.slow) for name in shipped() if name != "romo")])
def test_no_fault_is_imagined_on_the_hardest_drive(name, rng):
    vehicle = load_vehicle(name)
    layout, plant = Layout(vehicle), Plant(vehicle, speed=8.0, battery_every=4)
    monitor, command = Monitor(layout, DT), np.zeros(layout.size)
    states = plant.body.states
    spins = [states.index(f"omega_{wheel}") for wheel in ("fl", "fr", "rl", "rr")]
    torques = [states.index(f"torque_{motor}") for motor in plant.body.motors]
    angles = [states.index(f"delta_{wheel}") for wheel in plant.body.steered]
    sound = layout.packed(NO_FAULTS).tolist()
    for t, target in hard_commands(rng, vehicle, layout):
        state = plant.state.tolist()
        found = monitor.update(command.tolist(), tuple(state[k] for k in torques), tuple(state[k] for k in angles), ())
        assert found is NO_FAULTS, (t, found)
        low, high = layout.box(command.tolist(), [state[k] for k in spins], DT, sound)
        command = np.clip(target, low, high)
        plant.advance([*command.tolist(), 0.0, 0.0, 1.0], 4)


def test_no_fault_is_imagined_on_a_lane_change_and_emergency_stop_in_closed_loop(romo):
    s = np.linspace(0.0, 130.0, 261)
    y, v = np.zeros_like(s), np.full_like(s, 14.0)
    for start, sign in ((15.0, 1.0), (55.0, -1.0)):
        u = np.clip((s - start) / 25.0, 0.0, 1.0)
        y += sign * 2.5 * (10 * u**3 - 15 * u**4 + 6 * u**5)
    v = np.minimum(v, np.sqrt(2 * 5.0 * np.maximum(130.0 - s, 0.0)))
    x = np.concatenate(([0.0], np.cumsum(np.sqrt(np.maximum(np.diff(s) ** 2 - np.diff(y) ** 2, 0.0)))))
    psi = np.arctan2(np.gradient(y, s), np.gradient(x, s))
    from energy_mgr import Trajectory

    way = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    road = Trajectory.along(way, x, y, psi, np.gradient(psi, way), v)
    loop = Loop(EnergyManager(romo, road), road)
    for _ in range(3500):
        commands = loop.period()
        assert loop.manager.faults is NO_FAULTS, (loop.periods * DT, loop.manager.faults)
        if commands.status == "arrived":
            break
    assert loop.manager.errors == 0
    assert commands.status == "arrived"
