"""The published allocators A1 and (3.30) with their costs A2 and A3, against the equations written out with vectors and differences."""

import msgspec
import numpy as np
import pytest
from scipy.optimize import lsq_linear

from energy_mgr.allocation import ALLOCATORS, Situation
from energy_mgr.motion import MotionDemand, VehicleState
from powertrain import load_vehicle
from powertrain.drive.steering import Contact, steering_power
from tests.energy_mgr.allocation.rig import DT, Car

#: W_v as published.py has it: yaw accelerations count one and a half times.
W = np.array([1.0, 1.0, 1.5])


@pytest.fixture(scope="module")
def car(romo):
    return Car(romo, "linear")


def in_a_bend(car, step) -> Situation:
    """A gentle bend with torques and angles that all differ; the demand is what is given and `step` (m/s^2, m/s^2, rad/s^2) more."""
    state = VehicleState(0, 0, 0, 12.0, -0.1, 0.15, 0.3, 1.8)
    before = np.zeros(car.layout.size)
    before[car.layout.torques] = 20.0, 24.0, 28.0, 25.0
    before[car.layout.steers] = 0.030, 0.026, -0.012, -0.015
    demand = car.motion(before, state[3:]) + step
    return Situation(state, MotionDemand(*demand.tolist()), before, car.spins(state[3:]), dt=DT)


def moving(car):
    """Places of the commands that the published allocators use: all but the friction brakes."""
    return [k for k in range(car.layout.size) if k not in range(car.layout.size)[car.layout.brakes]]


# -- A1, step 1 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("cost", ["heuristic", "physical", "blended"])
@pytest.mark.parametrize("axis", range(3), ids=["ahead", "aside", "yaw"])
def test_what_one_period_can_give_is_given_whole_on_every_axis(romo, car, axis, cost):
    """The weights decide between demands that cannot all be met; where they can, (3.43) ends at W (B du - dv) = 0, hence without W."""
    step = 0.06 * np.eye(3)[axis]
    now = in_a_bend(car, step)
    found = ALLOCATORS["two-step"](romo, cost=cost).allocate(now)
    # 1e-7 of curvature beside the demand's own, whose least eigenvalue is about 0.1 in the scaled commands, is 1e-6 of what is asked
    assert np.array(found.given) - now.demand + step == pytest.approx(step, abs=1e-6)
    # the model that is not linearised: the bend of sine and cosine over 5 mrad
    assert car.motion(found.command, now.state[3:]) - now.demand + step == pytest.approx(step, abs=2e-4)
    assert found.status == "solved"


def test_what_one_period_cannot_give_is_missed_as_little_as_the_weights_say(romo, car, rng):
    """Bounded least squares of W (B du - dv) by another method: a demand of yaw and lateral acceleration far beyond the rates."""
    allocator = ALLOCATORS["two-step"](romo)
    for _ in range(20):
        now = in_a_bend(car, rng.uniform(-6.0, 6.0, 3))
        found, at = allocator.allocate(now), moving(car)
        low, high = (side[at] for side in car.box(now.before, now.wheel_speeds, now.faults))
        wide, B = high - low, car.jacobian(now.before, now.state[3:])[:, at]
        wanted = now.demand - car.motion(now.before, now.state[3:]) - B @ (low - now.before[at])
        # over the box counted from 0 to 1
        least = lsq_linear(W[:, None] * B * wide, W * wanted, bounds=(0.0, 1.0), tol=1e-12, lsmr_tol=1e-12)
        best = car.motion(now.before, now.state[3:]) + B @ (low - now.before[at] + wide * least.x)
        assert found.status == "limited"
        # B by central differences
        assert np.array(found.given) == pytest.approx(best, abs=1e-4)


# -- A2 and A3, step 2 ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def quick():
    """The ROMO with motors that follow at once: no bound is in the way of the cheapest command, which a linear system then gives."""
    romo = load_vehicle("romo")
    return Car(msgspec.structs.replace(romo, drive=msgspec.structs.replace(romo.drive, torque_rate_nmps=1e6)), "linear")


def steering_parabola(car, now, turned):
    """f1 and D1 of (3.45) for each wheel: derivatives of the steering power over the increment, at the increment of the period before."""
    steering, slopes, bends, h = car.vehicle.steering, [], [], 1e-6
    # of the tyres that the allocator is given: the trail of the car's own ones at small slip
    trails = [-float(small.aligning / small.lateral) for small in (tyre.forces(0.0, 1e-3, car.loads(0, 0)[k]) for k, tyre in enumerate(car.tyres))]
    for k, (along, side, _, _, load, speed, _) in enumerate(car.wheels(now.before, now.state[3:])):
        contact = Contact(side, along, load, speed, aligning=-trails[k] * side, left=1.0 if k % 2 == 0 else -1.0)
        power = [float(steering_power(steering, (turned[k] + e) / DT, e / DT**2, contact).total) for e in (-h, 0.0, h)]
        slopes.append((power[2] - power[0]) / (2 * h))
        # the friction |rate| counts as the parabola through rest with its slope there, as the true losses of motors do
        friction = steering.gear_ratio * (steering.friction_nm + steering.hysteresis_nm) / DT / abs(turned[k])
        bends.append((power[2] - 2 * power[1] + power[0]) / h**2 + friction)
    return np.array(slopes), np.array(bends)


def published_cost(car, now, turned, cost):
    """E and e of 0.5 du' E du + e' du in W over torques and angles: (3.45) with y = du - (turned, 0), or (3.46)."""
    # W/Nm and W/Nm^2: [CHK] of (3.39)
    a, b = 1.68491, 0.0291952
    torques = now.before[car.layout.torques]
    if cost == "heuristic":
        stiff = np.array([float(car.tyres[k].cornering_stiffness(car.mass * 9.81 / 4)) for k in range(4)])
        # towards the most recuperation; an angle weighs as the torque with as large a force
        return np.diag([2 * b] * 4 + list(2 * b * (stiff * car.radius) ** 2)), np.append(2 * b * (torques + 160.0), np.zeros(4))
    slope, bend = steering_parabola(car, now, turned)
    y0 = np.append(np.zeros(4), turned)
    E = np.diag(np.append([2 * b] * 4, bend))
    return E, np.append(a * np.sign(torques) + 2 * b * torques, slope) - E @ y0


@pytest.mark.parametrize("cost", ["heuristic", "physical"])
def test_the_second_step_ends_where_its_quadratic_cost_is_least_for_the_attained_motion(quick, cost):
    """(3.44) solved as a linear system; the wheels were turning before, about which A2 expands their power and not about standing still."""
    car = quick
    allocator, turned = ALLOCATORS["two-step"](car.vehicle, cost=cost), np.array([2e-3, 1.5e-3, -1.2e-3, -1.5e-3])
    allocator.restore(tuple(turned.tolist()))
    now, at = in_a_bend(car, np.array([0.1, 0.15, 0.1])), moving(car)
    found = allocator.allocate(now)
    E, e = published_cost(car, now, turned, cost)
    B = car.jacobian(now.before, now.state[3:])[:, at]
    system = np.block([[E / 1e3, B.T], [B, np.zeros((3, 3))]])
    least = np.linalg.solve(system, np.append(-e / 1e3, now.demand - car.motion(now.before, now.state[3:])))[:8]
    step = (found.command - now.before)[at]
    assert found.status == "solved"
    # the kink of friction is rounded below 0.01 rad/s, which at 0.3 rad/s leaves 1e-3 of a small part of the slope: 2e-4 Nm and 1e-8 rad were found
    assert step[:4] == pytest.approx(least[:4], abs=2e-3)
    assert step[4:] == pytest.approx(least[4:], abs=1e-7)
    assert np.max(np.abs(step[4:])) < 5e-3  # within the steering's rate
    # about which the next period expands it
    assert allocator.snapshot() == tuple(step[4:].tolist())
