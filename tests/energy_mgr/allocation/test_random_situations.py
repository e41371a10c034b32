"""Thousands of random demands, states, faults and battery windows: limits kept, answers optimal, misses the least possible and told."""

import math
from types import SimpleNamespace

import clarabel
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import lsq_linear

from energy_mgr.allocation import ALLOCATORS, Faults, Situation
from energy_mgr.motion import MotionDemand, VehicleState
from powertrain import load_vehicle, shipped
from powertrain.energy.motor import inverter_factor
from tests.energy_mgr.allocation.rig import DT, Car, constant_ahead, led, random_situation

#: How much a miss may be without being told.
MET = 0.02
#: Inner radius of the friction polygon.
INNER = math.cos(math.pi / 8)


def made(name, allocator="efficient", **more):
    vehicle = load_vehicle(name)
    return SimpleNamespace(car=Car(vehicle), allocator=ALLOCATORS[allocator](vehicle, **more))


def weights(car):
    """Of a_x, a_y and yaw acceleration in our allocator's norm; where one axle steers, yaw follows from a_y and counts a tenth."""
    return np.array([1.0, 1.0, 1.5 if len(car.layout.steered) == 4 else 0.15])


def clarabel_answer(H, f, A, lower, upper):
    """The minimiser by an interior-point method that shares nothing with the allocator's active-set one."""
    n = len(f)
    rows = np.vstack([np.eye(n), A])
    above, below = upper < 1e20, lower > -1e20
    G, h = np.vstack([rows[above], -rows[below]]), np.concatenate([upper[above], -lower[below]])
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.tol_gap_abs, settings.tol_gap_rel, settings.tol_feas, settings.max_iter = False, 1e-11, 1e-11, 1e-11, 200
    size = float(np.abs(H).max())
    cone = [clarabel.NonnegativeConeT(len(h))]
    found = clarabel.DefaultSolver(sp.csc_matrix(np.triu(H / size)), f / size, sp.csc_matrix(G), h, cone, settings).solve()
    return np.array(found.x), str(found.status)


def numbers(allocator):
    H, f, At, lower, upper = (part.copy() for part in allocator._qp.numbers)
    return H, f[:, 0], At.T, lower[:, 0], upper[:, 0]


def assert_inside(car, now, command):
    low, high = car.box(now.before, now.wheel_speeds, now.faults)
    size = car.layout.scale
    assert np.all(command >= low - 1e-12 * size), (now, command - low)
    assert np.all(command <= high + 1e-12 * size), (now, high - command)


def assert_closest_to(found, H, f, A, lower, upper):
    """Against Clarabel. Both stop by their cost, whose rounding is of the size of H and f: as well as that do they know the flattest unknown."""
    z, status = clarabel_answer(H, f, A, lower, upper)
    assert status in ("Solved", "AlmostSolved"), status
    size, stiff = max(1.0, float(np.abs(f).max())), max(1.0, float(np.abs(f).max()), float(np.abs(H).max()))
    away = float(np.max(np.abs(found - z)))
    # prices of 1e7 for steering at standstill and for racks leave Clarabel 1e-3 of freedom in the brakes
    assert away <= 1e-6 * size or (stiff > 1e6 and away <= 2e-3), away
    assert (0.5 * found @ H @ found + f @ found) - (0.5 * z @ H @ z + f @ z) <= 1e-8 * stiff + 1e-6 * size


def assert_rows_kept(car, now, command):
    """Grip and battery in a linear model by differences, where the retreat of all forces would keep them too; and at the true forces."""
    state, layout = led(car, now), car.layout
    low, high = car.box(now.before, now.wheel_speeds, now.faults)
    step = command - now.before
    back = np.zeros(layout.size)
    back[: layout.brakes.stop] = -now.before[: layout.brakes.stop]
    for k, wheel in enumerate(layout.steered):
        back[layout.steers.start + k] = -car.wheels(now.before, state)[wheel][3]
    back = np.clip(back, low - now.before, high - now.before)
    usage = car.usage(now.before, state)
    slopes = car.jacobian(now.before, state, of=lambda u, x: car.usage(u, x).ravel())
    limit = np.maximum(INNER * state[5], (usage.ravel() + slopes @ back))
    linear = usage.ravel() + slopes @ step
    assert np.max(linear - limit) < 2e-4
    # within one period the forces are what the lines say, but for the bend of the tyre's curve; what failed in this moment jumps farther
    true = car.usage(command, state).ravel()
    gradual = np.abs(step) <= np.maximum(car.layout.rate * DT, 1e-9) * (1 + 1e-9)
    wheels = car.wheels(now.before, state)
    sound = [np.all(gradual) and math.hypot(w[0], w[1]) < 0.9 * state[5] * w[4] and abs(w[3]) < 0.06 * state[5] for w in wheels]
    kept = (limit <= INNER * state[5] + 1e-9) & np.repeat(sound, 8)
    assert np.max((true - limit)[kept], initial=-1.0) < 0.01
    power, reached = car.power(now.before, state), car.jacobian(now.before, state, of=lambda u, x: [car.power(u, x)])[0]
    if np.all(gradual) and now.power_min <= power + reached @ back <= now.power_max - 1e3:
        found = car.power(command, state)
        # the losses' kinks at zero torque are not in a parabola: a torque that changes its sign within the period is let off with them
        kinks, drive = 0.0, car.vehicle.drive
        for k, speed in enumerate(car.motor_speeds(car.spins(state))):
            if now.before[k] * command[k] <= 0.0:
                kinks += 2 * (inverter_factor(car.vehicle) + (1 - drive.gear_efficiency) * abs(speed)) * abs(command[k] - now.before[k])
        assert now.power_min - 5.0 <= found <= now.power_max + 5.0 + kinks


def tried(name, count, seed, every, allocator="efficient"):
    """Solves `count` situations; Clarabel and the linear models look at each `every`th."""
    rig, rng, statuses = made(name, allocator), np.random.default_rng(seed), []
    for k in range(count):
        now = random_situation(rng, rig.car)
        found = rig.allocator.allocate(now)
        statuses.append(found.status)
        assert found.status in ("solved", "limited"), now
        assert found.residual <= 1e-6, now
        assert_inside(rig.car, now, found.command)
        asked = 3 if len(rig.car.layout.steered) == 4 else 2  # with one steered axle yaw is not to be chosen
        missed = max(abs(a - b) for a, b in list(zip(found.given, now.demand, strict=True))[:asked])
        assert (found.status == "limited") == (missed > MET)
        if k % every == 0:
            qp = numbers(rig.allocator)
            z = (found.command - now.before) / rig.car.layout.scale
            # what lies outside of its limits at once (a dead motor) is put inside after the QP
            assert_closest_to(np.clip(z, qp[3][: len(z)], qp[4][: len(z)]), *qp)
            assert_rows_kept(rig.car, now, found.command)
    return statuses


@pytest.mark.parametrize("name", shipped())
def test_every_answer_is_allowed_optimal_and_honest(name):
    statuses = tried(name, 300, 41, every=1 if name == "romo" else 4)
    assert 10 < statuses.count("limited") < 295


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped())
def test_ten_thousand_answers_are_allowed_optimal_and_honest(name):
    tried(name, 10_000 if name == "romo" else 2_000, 42, every=1)


@pytest.mark.parametrize("allocator", ALLOCATORS)
@pytest.mark.parametrize("name", ["romo", "dual_motor"])
def test_every_allocator_keeps_the_actuators_limits(name, allocator):
    rig, rng = made(name, allocator), np.random.default_rng(43)
    for _ in range(200):
        now = random_situation(rng, rig.car)
        found = rig.allocator.allocate(constant_ahead(rig.allocator, now))
        if allocator in ("efficient", "preview"):
            assert_inside(rig.car, now, found.command)
        else:  # these know no friction brakes: what was clamped is let go at once, or as fast as it goes
            low, high = rig.car.box(now.before, now.wheel_speeds, now.faults)
            low[rig.car.layout.brakes] = 0.0
            assert np.all(found.command >= low - 1e-9)
            assert np.all(found.command <= high + 1e-9)
        assert np.all(np.isfinite(found.given))
        assert found.residual <= 1e-6


def without_walls(rng, car, braking: bool) -> Situation:
    """Dry road, small forces, no battery window: nothing but the actuators limits what is attained in one period."""
    v = rng.uniform(3.0, 25.0)
    state = VehicleState(0, 0, 0, v, 0.0, rng.uniform(-0.05, 0.05))
    before = np.zeros(car.layout.size)
    before[car.layout.torques] = rng.uniform(-0.2, 0.2, car.layout.motors) * car.layout.upper[car.layout.torques]
    before[car.layout.steers] = rng.uniform(-0.01, 0.01, len(car.layout.steered))
    before = car.alike @ before[np.argmax(car.alike, axis=0)]
    a_x = rng.uniform(-30, -15) if braking else rng.uniform(0, 8)
    shares = tuple(rng.choice([0.0, 0.5, 1.0, 1.0], car.layout.motors).tolist())
    # yaw demands so small that the steering's lead changes the slip angles by less than they are
    demand = MotionDemand(float(a_x), float(rng.uniform(-6, 6)), float(rng.uniform(-6, 6)))
    return Situation(state, demand, before, car.spins(state[3:]), Faults(shares), dt=DT)


@pytest.mark.parametrize("braking", [False, True])
@pytest.mark.parametrize("name", shipped())
def test_what_cannot_be_met_is_met_as_nearly_as_the_actuators_allow(name, braking):
    """Bounded least squares over b and B without any losses, by another method: the weighted miss is the same."""
    rig, rng, limited = made(name), np.random.default_rng(44), 0
    car, n = rig.car, rig.car.layout.size
    for _ in range(60):
        now = without_walls(rng, car, braking)
        found, state = rig.allocator.allocate(now), led(car, now)
        if np.max(np.abs(car.usage(now.before, state))) > 0.7:
            continue  # the lead alone asks for all grip
        low, high = car.box(now.before, now.wheel_speeds, now.faults)
        if not braking:  # recuperation is not even asked for: brakes stay open
            high[car.layout.brakes] = low[car.layout.brakes]
        b, B, scale = car.motion(now.before, state), car.jacobian(now.before, state), car.layout.scale
        W, one = weights(car), np.argmax(car.alike, axis=0)
        wide = np.maximum(high - low, 1e-9)[one]
        # over the box counted from 0 to 1: then the least squares are well conditioned
        at = low - now.before
        columns = B @ car.alike * wide
        answer = lsq_linear(W[:, None] * columns, W * (now.demand - b - B @ at), bounds=(0.0, 1.0), tol=1e-12, lsmr_tol=1e-12)
        least = math.sqrt(2 * answer.cost)
        mine = float(np.linalg.norm(W * (b + B @ (found.command - now.before) - now.demand)))
        assert mine < least + 0.01 + 1e-3 * least, (now, mine, least)
        assert (found.status == "limited") or least < 2 * MET
        limited += found.status == "limited"
        assert np.all(np.abs(B @ scale) < 1e6)
        assert len(found.command) == n
    assert limited > 10


@pytest.mark.parametrize("name", shipped())
def test_within_grip_and_battery_too_the_least_miss_is_found(name):
    """The allocator's own constraints, but a cost of nothing except the miss: losses may not have bought motion."""
    rig, rng, worst = made(name), np.random.default_rng(45), 0.0
    car, E = rig.car, rig.car.alike
    W, n = weights(car), E.shape[1]
    for _ in range(80):
        now = random_situation(rng, car)
        found = rig.allocator.allocate(now)
        if now.state.v_x < 1.5:
            continue  # standing wheels are not turned for a moment's force
        A, lower, upper = numbers(rig.allocator)[2:]
        state, scale = led(car, now), car.layout.scale
        b, B = car.motion(now.before, state), car.jacobian(now.before, state) * scale
        weighted = W[:, None] * B @ E
        ends = [np.concatenate([part[np.argmax(E, axis=0)], part[len(scale) :]]) for part in (lower, upper)]
        z, status = clarabel_answer(weighted.T @ weighted + 1e-7 * np.eye(n), weighted.T @ (W * (b - now.demand)), A @ E, *ends)
        assert status in ("Solved", "AlmostSolved")
        least = float(np.linalg.norm(W * (b + B @ E @ z - now.demand)))
        mine = float(np.linalg.norm(W * (b + B @ ((found.command - now.before) / scale) - now.demand)))
        worst = max(worst, (mine - least) / (1.0 + least))
    assert worst < 0.02
