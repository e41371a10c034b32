"""What laws ask for besides corrections: driving resistances, the weight on slopes, the spin of the wheels."""

import math

import numpy as np
import pytest

from energy_mgr import Trajectory
from energy_mgr.following import LAWS, Follower, PathProjection
from energy_mgr.following.law import Resistances
from tests.energy_mgr.following.rig import DT, beside, straight

EVERY = pytest.mark.parametrize("law", list(LAWS))


@EVERY
@pytest.mark.parametrize(("grade", "tilt"), [(0.08, 0.0), (-0.05, 0.0), (0.0, 0.06)])
def test_on_its_path_at_its_speed_the_car_is_asked_for_resistances_alone(romo, law, grade, tilt):
    s = np.linspace(0.0, 100.0, 51)
    road = Trajectory.along(s, s, 0 * s, 0 * s, 0 * s, np.full(51, 15.0), z=grade * s, bank=tilt)
    demand = Follower(road, romo, law=law).step(beside(road, 30.0), DT).demand
    r, mass = romo.resistance, romo.chassis.mass_kg
    drag = 0.5 * r.air_density_kgpm3 * r.drag_coefficient * r.frontal_area_m2 * 15.0**2
    rolling = mass * 9.81 * (r.rolling_0 + r.rolling_1 * 0.54 + r.rolling_4 * 0.54**4)
    # grade or tilt alone: the weight along the road is its sine
    assert demand.a_x == pytest.approx((drag + rolling) / mass + 9.81 * math.sin(math.atan(grade)), abs=1e-9)
    assert demand.a_y == pytest.approx(9.81 * math.sin(tilt), abs=1e-9)
    assert demand.yaw_acceleration == pytest.approx(0.0, abs=1e-9)


@EVERY
@pytest.mark.parametrize("a", [1.5, -1.5])
def test_who_speeds_up_or_brakes_as_planned_is_asked_for_the_spin_of_the_wheels_too(romo, law, a):
    """Force over mass at the ground is (1 + 4 J / (m R^2)) a and resistances: J = 0.65 kg m^2 on 0.27365 m is 3.4 % of this car."""
    s = np.linspace(0.0, 60.0, 61)
    road = Trajectory.along(s, s, 0 * s, 0 * s, 0 * s, np.sqrt(225.0 + 2 * a * (s - 30.0)))
    # it does what is planned, so that no law has anything to correct
    demand = Follower(road, romo, law=law).step(beside(road, 30.0)._replace(a_x=a), DT).demand
    coasting = Follower(straight(60.0, 15.0), romo, law=law).step(beside(straight(60.0, 15.0), 30.0), DT).demand
    # v^2 is linear in s between stations as in the plan, so that a is exact
    assert demand.a_x - coasting.a_x == pytest.approx(a * (1 + 4 * 0.65 / 0.27365**2 / 1013.0), abs=1e-6)
    assert demand[1:] == pytest.approx((0.0, 0.0), abs=1e-9)


def test_wheels_spin_up_with_the_change_of_their_own_speed_and_not_with_the_acceleration_of_the_car(romo):
    """Turning at 0.5 rad/s while sliding at -0.4 m/s aside: d v_x/dt = a_x + r v_y is 0.2 m/s^2 less than a_x."""
    road = straight()
    car = beside(road, 30.0)._replace(v_y=-0.4, yaw_rate=0.5)
    at, law = PathProjection(road).update(car, DT), Resistances(romo)
    gained = law.demand(0.9, 0.0, 0.0, car, at).a_x - law.demand(0.0, 0.0, 0.0, car._replace(yaw_rate=0.0), at).a_x
    assert gained == pytest.approx(0.9 + 4 * 0.65 / 0.27365**2 / 1013.0 * (0.9 - 0.2), abs=1e-9)


@EVERY
@pytest.mark.parametrize("e_psi", [-0.9, -0.2, 0.4, 1.3])
def test_across_a_banked_hill_the_car_holds_its_weight_along_its_own_axes(romo, law, e_psi):
    grade, tilt = 0.08, 0.06
    s = np.linspace(0.0, 100.0, 51)
    level, hill = (Trajectory.along(s, s, 0 * s, 0 * s, 0 * s, np.full(51, 15.0), z=k * grade * s, bank=k * tilt) for k in (0.0, 1.0))
    car = beside(level, 30.0, 0.3, e_psi)
    plain, held = (Follower(road, romo, law=law).step(car, DT).demand for road in (level, hill))
    # the hill is z = grade x + tan(tilt) y; the weight over the mass pulls down along each axis by the rise of that axis
    climb = np.array([grade, math.tan(tilt)])
    axes = np.array([[math.cos(e_psi), math.sin(e_psi)], [-math.sin(e_psi), math.cos(e_psi)]])
    wanted = 9.81 * (axes @ climb) / math.sqrt(1.0 + climb @ climb)
    assert (held.a_x - plain.a_x, held.a_y - plain.a_y) == pytest.approx(tuple(wanted), abs=1e-9)
