"""What the tracking laws demand of odd cars on a winding, climbing, leaning road, put through Newton's laws: the errors then change as they shall."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from energy_mgr.following import LinearisingLaw, PathProjection, PdGains, PdLaw
from energy_mgr.following.geometric import GeometricLaw
from energy_mgr.motion import MotionDemand, VehicleState
from powertrain import Vehicle
from tests.energy_mgr.winding import winding
from tests.odd_cars import ODD

ROAD = winding()
CARS = pytest.mark.parametrize("name", ODD)


def seen(place: complex, psi: float, velocity: complex, s: float) -> SimpleNamespace:
    """The car from the road's nearest place, found near `s` by Newton's method; `velocity` in the plane."""
    for _ in range(8):
        p = ROAD.point(s)
        off = (place - complex(p.x, p.y)) * np.exp(-1j * p.psi)
        s += off.real / (1.0 - p.kappa * off.imag)
    own = velocity * np.exp(-1j * p.psi)
    return SimpleNamespace(s=s, e_y=off.imag, e_psi=math.remainder(psi - p.psi, math.tau), ahead=own.real, aside=own.imag, point=p)


def random_state(rng: np.random.Generator) -> VehicleState:
    """Beside the road by up to 15 cm and 6 degrees, sliding; so near that no limit of a law holds."""
    p = ROAD.point(rng.uniform(5.0, 110.0))
    e_y, e_psi, slide = rng.uniform(-0.15, 0.15), rng.uniform(-0.1, 0.1), rng.uniform(-0.02, 0.02)
    velocity = (p.v + rng.uniform(-0.5, 0.5)) * np.exp(1j * (slide - e_psi))
    x, y = p.x - e_y * math.sin(p.psi), p.y + e_y * math.cos(p.psi)
    return VehicleState(x, y, p.psi + e_psi, velocity.real, velocity.imag, p.kappa * p.v + rng.uniform(-0.1, 0.1), *rng.uniform(-1.0, 1.0, 2))


def moved(car: Vehicle, state: VehicleState, point, demand: MotionDemand) -> tuple[float, float, float]:
    """Rates of v_x, v_y and yaw rate in a car whose wheels give `demand`: drag, rolling, weight on slope and bank, and what turns with the wheels."""
    mass, r, d, radius = car.chassis.mass_kg, car.resistance, car.drive, car.chassis.wheel_radius_m
    turning = 4 * car.chassis.wheel_inertia_kgm2 / radius**2 + d.motor_count * d.rotor_inertia_kgm2 * (d.gear_ratio / radius) ** 2
    v, fast = state.v_x, state.v_x * 3.6 / 100
    drag = 0.5 * r.air_density_kgpm3 * r.drag_coefficient * r.frontal_area_m2 * v**2
    rolling = mass * 9.81 * (r.rolling_0 + r.rolling_1 * fast + r.rolling_4 * fast**4)
    up = (point.slope + 1j * math.tan(point.bank)) * np.exp(1j * (point.psi - state.psi))
    weight = mass * 9.81 * up / math.sqrt(1.0 + abs(up) ** 2)
    force = mass * demand.a_x - drag - rolling - weight.real
    # (mass + turning) v_x' = force + mass r v_y
    return (
        (force + mass * state.yaw_rate * state.v_y) / (mass + turning),
        demand.a_y - weight.imag / mass - state.yaw_rate * v,
        demand.yaw_acceleration,
    )


def later(state: VehicleState, rates: tuple[float, float, float], h: float, s: float) -> SimpleNamespace:
    """The car seen from the road `h` seconds later, to the second order."""
    turn = np.exp(1j * state.psi)
    velocity = complex(state.v_x, state.v_y) * turn
    gained = (complex(rates[0], rates[1]) + 1j * state.yaw_rate * complex(state.v_x, state.v_y)) * turn
    place = complex(state.x, state.y) + h * velocity + 0.5 * h**2 * gained
    return seen(place, state.psi + h * state.yaw_rate + 0.5 * h**2 * rates[2], velocity + h * gained, s)


def errors_around(car: Vehicle, state: VehicleState, at, demand: MotionDemand, h: float = 5e-3) -> SimpleNamespace:
    """Errors now, with their first and second derivatives in time under `demand`."""
    rates = moved(car, state, at.point, demand)
    before, now, after = (later(state, rates, k * h, at.s) for k in (-1, 0, 1))
    pick = [np.array([row.e_y, row.e_psi, row.ahead]) for row in (before, now, after)]
    return SimpleNamespace(now=now, value=pick[1], first=(pick[2] - pick[0]) / (2 * h), second=(pick[2] - 2 * pick[1] + pick[0]) / h**2)


@CARS
def test_linearised_errors_obey_their_poles_exactly_on_any_road(name: str):
    """e'' = -(p + q) e' - p q e for offset and heading, the speed along the road by its own law: for an odd car on a banked slope, with side slip."""
    car, rng = ODD[name], np.random.default_rng(72)
    for _ in range(60):
        state = random_state(rng)
        at, law = PathProjection(ROAD).update(state, 0.004), LinearisingLaw(car)
        found = errors_around(car, state, at, law.demand(state, at, 0.004))
        assert not law.supervised
        # differences over 5 ms leave 1e-4; the law takes the curvature's slope as constant between stations, which are 1 m apart: 6e-3 rad/s^2
        assert found.second[0] == pytest.approx(-(1.6 + 3.2) * found.first[0] - 1.6 * 3.2 * found.value[0], abs=2e-3)
        assert found.second[1] == pytest.approx(-(3.0 + 4.5) * found.first[1] - 3.0 * 4.5 * found.value[1], abs=2e-2)
        wanted, feed = at.speed
        feed *= found.now.ahead / wanted if feed < 0.0 else 1.0
        assert found.first[2] == pytest.approx(feed + 1.5 * (wanted - found.now.ahead), abs=1e-3)


@CARS
def test_the_geometric_law_gives_the_velocities_that_its_course_and_turning_ask_for(name: str):
    car, rng = ODD[name], np.random.default_rng(73)
    for _ in range(60):
        state = random_state(rng)
        at, law = PathProjection(ROAD).update(state, 0.004), GeometricLaw(car)
        demand = law.demand(state, at, 0.004)
        rates, now = moved(car, state, at.point, demand), seen(complex(state.x, state.y), state.psi, 0j, at.s)
        wanted, feed = at.speed
        feed *= state.v_x / wanted if feed < 0.0 else 1.0
        assert rates[0] == pytest.approx(feed + 1.5 * (wanted - state.v_x), abs=1e-9)
        # course towards the road by e_y per second over the speed, less where the nose points already; it follows within 0.2 s
        speed = math.hypot(state.v_x, state.v_y)
        course = -math.asin(now.e_y / speed) - now.e_psi
        assert rates[1] == pytest.approx((speed * math.sin(course) - state.v_y) / 0.2, abs=1e-6)
        turning = at.point.kappa * at.sdot - 2.0 * now.e_psi
        feed_yaw = rates[2] - (turning - state.yaw_rate) / 0.2
        # what is left is d(kappa sdot)/dt while the car gains `ahead` along the road
        gain = feed + 1.5 * (wanted - state.v_x)
        h, velocity, turns = 5e-3, complex(state.v_x, state.v_y) * np.exp(1j * state.psi), []
        for k in (-1, 1):
            there = seen(complex(state.x, state.y) + k * h * velocity, state.psi, 0j, at.s)
            turns.append(there.point.kappa * (at.ahead + k * h * gain) / (1.0 - there.point.kappa * there.e_y))
        # curvature's slope between stations, as above
        assert feed_yaw == pytest.approx((turns[1] - turns[0]) / (2 * h), abs=2e-2)


@CARS
def test_every_derivative_of_the_pd_law_is_that_of_the_error_beside_it(name: str):
    """The share of each D gain, by differences between laws, is the rate of the error of its P gain under the motion that was measured."""
    car, rng = ODD[name], np.random.default_rng(74)
    zero = dict.fromkeys(("k_px", "k_dx", "k_py", "k_dy", "k_ppsi", "k_dpsi"), 0.0)

    def asked(state: VehicleState, at, **gains: float) -> np.ndarray:
        some, none = (PdLaw(car, PdGains(**which)).demand(state, at, 0.004) for which in (zero | gains, zero))
        return np.array(some) - np.array(none)

    def errors(state: VehicleState, rates: tuple[float, float, float], h: float, at) -> np.ndarray:
        """Of the speed, to the left and of the heading, path minus car."""
        there = later(state, rates, h, at.s)
        return np.array([-(state.v_x + h * rates[0]), -there.e_y * math.cos(there.e_psi), -there.e_psi])

    for _ in range(40):
        state = random_state(rng)
        at, r, h = PathProjection(ROAD).update(state, 0.004), state.yaw_rate, 1e-3
        # the wheels' spin is fed forward from what is asked ahead, hence in that share
        heavier = car.effective_mass / car.chassis.mass_kg
        parts = [asked(state, at, **{key: 1.0}) for key in ("k_px", "k_py", "k_ppsi")]
        expected = errors(state, (0.0, 0.0, 0.0), 0.0, at)
        assert parts[0][0] / heavier == pytest.approx(at.point.v + expected[0], abs=1e-9)
        assert [parts[1][1], parts[2][2]] == pytest.approx(expected[1:], abs=1e-6)
        rates = (state.a_x + r * state.v_y, state.a_y - r * state.v_x, 0.0)
        slopes = (errors(state, rates, h, at) - errors(state, rates, -h, at)) / (2 * h)
        along = at.point.a * (at.sdot / at.point.v if at.point.a < 0.0 else 1.0)
        found = [asked(state, at, k_dx=1.0)[0] / heavier, asked(state, at, k_dy=1.0)[1], asked(state, at, k_dpsi=1.0)[2]]
        assert found[0] == pytest.approx(along + slopes[0], abs=1e-6)
        assert found[1:] == pytest.approx(slopes[1:], abs=1e-4)
