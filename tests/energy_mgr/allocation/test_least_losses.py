"""What the freedom of many actuators is used for: losses, brakes only where needed, faults made up for."""

import math

import numpy as np
import pytest

from energy_mgr import PlanningError
from energy_mgr.allocation import ALLOCATORS, Ahead, EfficientAllocator, Faults, Layout, PreviewAllocator
from energy_mgr.allocation.preview import _FADE
from energy_mgr.motion import MotionDemand
from powertrain import load_vehicle, shipped
from tests.energy_mgr.allocation.rig import Car, constant_ahead, cornering, random_situation, settled

CARS = pytest.mark.parametrize("name", shipped())
#: demand (m/s^2, rad/s^2) that counts as met by the true model
MET = 0.03


def own(name, vehicle, **more):
    """Every allocator with the same tyres, so that the same demand is met."""
    return ALLOCATORS[name](vehicle, tyre="own", **more)


@pytest.fixture(scope="module")
def all_of_romo(romo):
    return {name: own(name, romo) for name in ALLOCATORS} | {"heuristic": own("efficient", romo, cost="heuristic")}


def bends(rng, car, count):
    for _ in range(count):
        v, a_y = rng.uniform(4.0, 25.0), rng.uniform(-4.0, 4.0)
        yield cornering(car, v, rng.uniform(-1.2, 1.2), a_y, v_y=-a_y * rng.uniform(0.0, 0.08))


def missed(car, command, now):
    return float(np.max(np.abs(car.motion(command, now.state[3:]) - now.demand)))


def test_nobody_meets_the_same_demand_with_less_losses(romo, rng, all_of_romo):
    """Settled, in steady bends, counted by motors, brakes and sliding of the tyres on their own: others need more, never less."""
    car, gains = Car(romo), {name: [] for name in all_of_romo}
    for now in bends(rng, car, 10):
        ours = settled(all_of_romo["efficient"], now)
        assert missed(car, ours.command, now) < MET
        least = car.losses(ours.command, now.state[3:])
        for name, allocator in all_of_romo.items():
            other = settled(allocator, constant_ahead(allocator, now))
            if missed(car, other.command, now) < MET:
                gains[name].append(car.losses(other.command, now.state[3:]) - least)
    for name, gain in gains.items():
        assert len(gain) >= 5 or name in ("weighted",), (name, len(gain))
        # the demand may be missed by 1e-3 m/s^2: at 25 m/s a ton does 25 W less for it
        assert min(gain, default=0.0) > -25.0, (name, min(gain))
    assert np.mean(gains["equal-split"]) > 1.0
    assert np.mean(gains["heuristic"]) > -0.5


def test_the_least_losses_are_those_that_a_search_over_everything_finds(romo, rng):
    """SLSQP from several starts over all commands at an equality of the true model."""
    from scipy.optimize import minimize

    car, allocator = Car(romo), own("efficient", romo)
    for now in bends(rng, car, 4):
        x, ours = now.state[3:], settled(allocator, now)
        exact = MotionDemand(*car.motion(ours.command, x).tolist())
        layout, scale = car.layout, car.layout.scale
        low, high = car.box(np.zeros(layout.size), now.wheel_speeds, Faults(), dt=1e3)
        high[layout.brakes] = 1e-9

        def wrong(z, x=x, scale=scale, exact=exact):
            return car.motion(z * scale, x) - exact

        best = math.inf
        for _ in range(3):
            start = ours.command / scale + rng.normal(0, 0.05, layout.size)
            found = minimize(
                lambda z, x=x, scale=scale: car.losses(z * scale, x) / 1e3,
                start,
                constraints={"type": "eq", "fun": wrong},
                bounds=list(zip(low / scale, high / scale, strict=True)),
                options={"maxiter": 300, "ftol": 1e-10},
            )
            if np.max(np.abs(wrong(found.x))) < 1e-6:
                best = min(best, 1e3 * found.fun)
        assert car.losses(ours.command, x) <= best * 1.002 + 2.0


@CARS
def test_the_physical_cost_loses_no_more_than_the_heuristic(name, rng):
    vehicle = load_vehicle(name)
    car, physical, heuristic = Car(vehicle), own("efficient", vehicle), own("efficient", vehicle, cost="heuristic")
    for now in bends(rng, car, 8):
        one, other = (car.losses(settled(a, now).command, now.state[3:]) for a in (physical, heuristic))
        assert one <= other * 1.001 + 2.0


@CARS
def test_a_demand_that_lasts_is_met_without_brakes_while_recuperation_suffices(name):
    vehicle = load_vehicle(name)
    car, allocator = Car(vehicle), EfficientAllocator(vehicle)
    for v in (4.0, 12.0, 22.0):
        _, back = car.range(car.motor_speeds(car.spins((v, 0, 0, 0, 0, 1.0)))[0])
        most = back * sum(car.share for m in car.motor_of_wheel if m is not None) / car.radius / car.mass
        now = cornering(car, v, a_x=-0.8 * min(most, 5.0))
        for _ in range(150):  # from the first step of the demand on
            found = allocator.allocate(now)
            assert np.all(found.command[car.layout.brakes] < 1e-6)
            now = now._replace(before=found.command)
        assert found.status == "solved"
        assert car.motion(found.command, now.state[3:])[0] == pytest.approx(now.demand.a_x, abs=MET)


@CARS
@pytest.mark.parametrize("why", ["envelope", "battery", "dead motors"])
def test_brakes_give_what_recuperation_cannot(name, why):
    vehicle = load_vehicle(name)
    car = Car(vehicle)
    allocator, v = EfficientAllocator(vehicle), 20.0
    demand = {"envelope": -4.5, "battery": -1.5, "dead motors": -1.5}[why]
    more = {"battery": {"power_min": -2000.0}, "dead motors": {"faults": Faults((0.0,) * car.layout.motors)}}.get(why, {})
    now = cornering(car, v, a_x=demand, **more)
    end = settled(allocator, now, steps=400)
    assert end.found.status == "solved"
    assert car.motion(end.command, now.state[3:])[0] == pytest.approx(demand, abs=MET)
    brakes, torques = end.command[car.layout.brakes], end.command[car.layout.torques]
    assert np.sum(brakes) > 20.0
    assert np.all(torques < 1e-6)
    if why == "battery":
        assert car.power(end.command, now.state[3:]) == pytest.approx(-2000.0, abs=100.0)
    if why == "dead motors":
        assert np.max(np.abs(torques)) < 1e-9
    if why == "envelope":  # all that recuperation gives is taken first
        assert torques == pytest.approx(-np.array([car.range(w)[1] for w in car.motor_speeds(now.wheel_speeds)]), rel=0.02)


@pytest.mark.parametrize("motor", range(4))
@pytest.mark.parametrize("a_x", [1.0, -1.0])
def test_three_motors_do_the_work_of_four_and_the_car_does_not_turn_for_it(romo, motor, a_x):
    car, allocator = Car(romo), own("efficient", romo)
    dead = Faults(tuple(float(k != motor) for k in range(4)))
    for v, a_y in ((8.0, 0.0), (15.0, 2.0), (20.0, -2.0)):
        now = cornering(car, v, a_x, a_y, v_y=-0.02 * a_y, faults=dead)
        end = settled(allocator, now)
        assert end.found.status == "solved"
        assert end.command[motor] == 0.0
        assert missed(car, end.command, now) < MET
        assert np.max(end.command[car.layout.brakes]) < 1e-6


@pytest.mark.parametrize("wheel", range(4))
def test_three_wheels_steer_where_one_is_stuck(romo, wheel):
    car, allocator = Car(romo), own("efficient", romo)
    for angle in (0.0, 0.02, -0.02):
        stuck = Faults(stuck=tuple(angle if k == wheel else None for k in range(4)))
        for v, a_y in ((8.0, 0.5), (15.0, -1.0)):
            now = cornering(car, v, 0.3, a_y, v_y=-0.02 * a_y, faults=stuck)
            end = settled(allocator, now)
            assert end.command[car.layout.steers][wheel] == angle
            assert end.found.status == "solved"
            assert missed(car, end.command, now) < MET


@pytest.mark.parametrize("cost", ["physical", "heuristic"])
def test_with_a_demand_that_lasts_looking_ahead_ends_where_the_present_does(romo, cost):
    car, ahead, now_only = Car(romo), PreviewAllocator(romo, cost=cost), EfficientAllocator(romo, cost=cost)
    for v, a_x, a_y in ((8.0, 0.8, 0.0), (15.0, -0.7, 2.0), (20.0, 0.3, -3.0), (12.0, 0.0, 1.0)):
        now = cornering(car, v, a_x, a_y)
        one, other = settled(ahead, constant_ahead(ahead, now), steps=1500), settled(now_only, now, steps=1500)
        assert one.found.status == other.found.status == "solved"
        assert np.max(np.abs(one.command - other.command)[car.layout.torques]) < 0.5
        assert np.max(np.abs(one.command - other.command)[car.layout.steers]) < 2e-4


def test_what_is_corrected_now_is_expected_to_fade(romo):
    """The trajectory asks for a quiet bend, the tracking law for more now: the same as if what is left of that had been told for every later time."""
    car, allocator, p = Car(romo), PreviewAllocator(romo), MotionDemand(0.2, 1.0, 0.0)
    quiet = cornering(car, 12.0, p.a_x, p.a_y)
    before = settled(allocator, constant_ahead(allocator, quiet)).command
    extra = np.array([-1.5, 0.8, 0.2])

    def answer(shares):
        allocator.restore(())
        now = quiet._replace(demand=MotionDemand(*(np.array(p) + extra)), before=before)
        told = [MotionDemand(*(np.array(p) + share * extra)) for share in shares(np.array(allocator.horizon))]
        now = now._replace(ahead=tuple(Ahead(t, d, 12.0, now.state.yaw_rate) for t, d in zip(allocator.horizon, told, strict=True)))
        for _ in range(20):
            found = allocator.allocate(now)
            now = now._replace(before=found.command)
        return found.command / allocator.layout.scale

    planned, faded = answer(lambda t: 0.0 * t), answer(lambda t: np.exp(-t / _FADE))
    # the solver's tolerance; that a correction of the other sign is told apart shows in the last line
    assert planned == pytest.approx(faded, abs=1e-5)
    turned = answer(lambda t: np.where(t > 0.0, -np.exp(-t / _FADE), 1.0))
    assert np.max(np.abs(turned - faded)) > 1e-3


@pytest.mark.parametrize("horizon", [(), (0.0,), (0.1, 0.2), (0.0, 0.2, 0.1), (0.0, 0.1, 0.1), (0.0, math.nan), (0.0, -1.0)])
def test_a_horizon_that_does_not_begin_now_and_grow_is_refused(romo, horizon):
    with pytest.raises(PlanningError, match="expected times that begin with 0 and grow"):
        PreviewAllocator(romo, horizon=horizon)


def test_without_a_preview_the_present_is_answered(romo, rng):
    car, ahead, alone = Car(romo), PreviewAllocator(romo), EfficientAllocator(romo)
    for _ in range(20):
        now = random_situation(rng, car)
        one, other = ahead.allocate(now), alone.allocate(now)
        assert one.command == pytest.approx(other.command, abs=1e-6)
        assert one.status == other.status


@pytest.mark.parametrize("cost", ["physical", "heuristic", "blended"])
@pytest.mark.parametrize("allocator", ALLOCATORS)
def test_a_restored_allocator_goes_on_bit_for_bit(romo, allocator, cost):
    rng, car = np.random.default_rng(5), Car(romo)
    one, other = ALLOCATORS[allocator](romo, cost=cost), ALLOCATORS[allocator](romo, cost=cost)
    situations = [constant_ahead(one, random_situation(rng, car)) for _ in range(30)]
    for now in situations[:10]:
        one.allocate(now)
    kept = one.snapshot()
    assert all(isinstance(value, float) for value in kept)
    other.allocate(situations[20])  # what was before must not matter
    other.restore(kept)
    for now in situations[10:]:
        first, second = one.allocate(now), other.allocate(now)
        assert first.command.tobytes() == second.command.tobytes()
        assert first[1:] == second[1:]


def test_costs_tyres_and_faults_that_do_not_exist_are_refused(romo):
    with pytest.raises(PlanningError, match="allocation cost 'none', expected one of physical, heuristic, blended"):
        EfficientAllocator(romo, cost="none")
    layout = Layout(romo)
    short = Faults(motors=(1.0,)), Faults(brakes=(1.0, 1.0)), Faults(stuck=(None,))
    for faults in (*short, Faults(motors=(2.0, 1.0, 1.0, 1.0)), Faults(stuck=(3.0, None, None, None))):
        with pytest.raises(PlanningError, match="expected"):
            layout.checked(faults)
    assert layout.checked(Faults((0.0, 1.0, 0.5, 1.0), (), (None, 0.1, None, None))).any
