"""ESTM: closed forms, standstill, and the double track as the richer truth."""

import numpy as np
import pytest

from powertrain import driving_resistance, load_vehicle
from powertrain.chassis import DoubleTrack, Machine, SingleTrack
from powertrain.energy.performance import axle_stiffness, understeer_gradient
from powertrain.symbolic import ca

ROMO = load_vehicle("romo")
MODEL = SingleTrack(ROMO)
MACHINE = Machine(MODEL, 0.01, substeps=4)


def drive(x, u, seconds: float):
    for _ in range(round(seconds / MACHINE.dt)):
        x = MACHINE.step(x, u)
    return dict(zip(MODEL.states, x, strict=True))


def holding(v: float) -> float:
    """Torque per wheel that balances the resistances at `v`, Nm."""
    return float(driving_resistance(ROMO, v, 0.0)) * ROMO.chassis.wheel_radius_m / 4.0


def test_yaw_rate_of_small_angles_is_the_bicycle_closed_form():
    v, delta = 12.0, 0.002
    end = drive([0.0, v, 0.0, 0.0, 0.0, 0.0], [*[holding(v)] * 4, delta, 0.0], 6.0)
    expected = end["v"] * delta / (2.4 + understeer_gradient(ROMO) * end["v"] ** 2)
    assert end["yaw_rate"] == pytest.approx(expected, rel=2e-3)


def test_slip_angles_at_the_axles_are_those_of_equation_c4():
    """Magic formula of the source with its B, C, E and the corrected D, written out here."""
    alpha, B, C, E = 0.03, 5.1088547, 2.0280, 0.8903703
    x = [0.0, 15.0, 0.0, 0.0, 0.0, 0.0]
    rate = dict(zip(MODEL.states, MODEL.derivative(x, [0.0, 0.0, 0.0, 0.0, alpha, alpha]), strict=True))
    share = {"f": 1.182 / 1.2, "r": 1.218 / 1.2}
    # load degression of 0.3 about a quarter of the weight
    peak = {axle: 7247.0 * 1.3 * z / (1.0 + 0.3 * z) for axle, z in share.items()}
    # the tyre states its nominal load with four digits
    force = {axle: D * np.sin(C * np.arctan(B * alpha - E * (B * alpha - np.arctan(B * alpha)))) for axle, D in peak.items()}
    side = (force["f"] + force["r"]) * np.cos(alpha)
    # rolling resistance of the turned wheels has a share across, too
    rolling = 1013.0 * 9.81 * (0.009 + 0.002811588 * 0.54 + 0.0044906 * 0.54**4)
    moving = 0.5 * (15.0 + np.hypot(15.0, 2.0 * MODEL.v_min))
    assert rate["beta"] == pytest.approx((side - rolling * np.sin(alpha)) / (1013.0 * moving), rel=1e-3)


def magic_side_force(axle: int, alpha: float) -> float:
    """(C.4) of both wheels of an axle under its static load, with the peak's load degression of 0.3 about a quarter of the weight."""
    B, C, E = 5.1088547, 2.0280, 0.8903703
    z = 0.5 * 1013.0 * 9.81 * (1.182, 1.218)[axle] / 2.4 / 2484.4
    slope = B * alpha
    return 7247.0 * 1.3 * z / (1.0 + 0.3 * z) * np.sin(C * np.arctan(slope - E * (slope - np.arctan(slope))))


def rates_by_newton(x, u) -> dict[str, float]:
    """Rates of a bicycle in the plane: wheels with velocities of their own, forces turned by the wheels' angles, moments by a cross product."""
    beta, v, yaw_rate = x[:3]
    mass, inertia, radius, v_min = 1013.0, 1130.0, 0.27365, MODEL.v_min
    modified = 0.5 * (v + np.hypot(v, 2.0 * v_min))
    course = np.array([np.cos(beta), np.sin(beta)])
    rolling = mass * 9.81 * (0.009 + 0.002811588 * (0.036 * v) + 0.0044906 * (0.036 * v) ** 4)
    force, moment = np.array([-0.5 * 1.249512 * 0.3 * 1.2323485 * v**2, 0.0]), 0.0
    for axle, (place, load_share) in enumerate(((1.218, 1.182 / 2.4), (-1.182, 1.218 / 2.4))):
        delta = u[4 + axle]
        along, across = np.array([np.cos(delta), np.sin(delta)]), np.array([-np.sin(delta), np.cos(delta)])
        moves = modified * course + np.array([0.0, place * yaw_rate])
        alpha = delta - np.arctan2(moves[1], moves[0])
        wheel = along * ((u[2 * axle] + u[2 * axle + 1]) / radius - load_share * rolling) + across * magic_side_force(axle, alpha)
        force, moment = force + wheel, moment + place * wheel[1]
    left = np.array([-course[1], course[0]])
    return {"beta": force @ left / (mass * modified) - yaw_rate, "v": force @ course / mass, "yaw_rate": moment / inertia}


def test_rates_are_those_of_newton_for_every_force_on_both_axles(rng):
    """(C.1) to (C.6) derived once more with vectors; torques and angles of the axles differ, so that no term can hide behind another."""
    for _ in range(20):
        x = [rng.uniform(-0.1, 0.1), rng.uniform(5.0, 25.0), rng.uniform(-0.6, 0.6), rng.uniform(-3.0, 3.0), 1.0, 2.0]
        u = [*rng.uniform(-120.0, 120.0, 4), *rng.uniform(-0.3, 0.3, 2)]
        rate = dict(zip(MODEL.states, MODEL.derivative(x, u), strict=True))
        for name, expected in rates_by_newton(x, u).items():
            # the same numbers on both sides: rounding alone, of forces of 9 kN that partly cancel
            assert rate[name] == pytest.approx(expected, rel=1e-9, abs=1e-9), name
        assert (rate["psi"], rate["x"], rate["y"]) == pytest.approx((x[2], x[1] * np.cos(x[3] + x[0]), x[1] * np.sin(x[3] + x[0])))


@pytest.mark.parametrize("axle", [0, 1], ids=["front", "rear"])
def test_torque_on_a_turned_axle_pulls_along_and_aside_where_its_wheels_point(axle: int):
    """The difference that 100 N make: cos and sin of the angle; a front axle turns the car to where it points, a rear one away."""
    x, angles, pull, delta = [0.0, 10.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0], 100.0, 0.2
    angles[axle] = delta
    without, torques = MODEL.derivative(x, [0.0] * 4 + angles), [0.0] * 4
    torques[2 * axle] = pull * ROMO.chassis.wheel_radius_m
    change = {name: a - b for name, a, b in zip(MODEL.states, MODEL.derivative(x, torques + angles), without, strict=True)}
    modified = 0.5 * (10.0 + np.hypot(10.0, 2.0 * MODEL.v_min))
    # resistances and side forces do not depend on torque: rounding is all that is left
    assert change["v"] == pytest.approx(pull * np.cos(delta) / 1013.0, rel=1e-9)
    assert change["beta"] == pytest.approx(pull * np.sin(delta) / (1013.0 * modified), rel=1e-9)
    assert change["yaw_rate"] == pytest.approx((1.218, -1.182)[axle] * pull * np.sin(delta) / 1130.0, rel=1e-9)


@pytest.mark.parametrize("torque", [0.0, 3.0, -3.0, 6.0])
def test_the_car_stands_still_where_rolling_resistance_holds_it(torque: float):
    """4 x 6 Nm are 88 N, a little less than the rolling resistance; turned wheels and side slip do not turn the standing car."""
    end = drive([0.0, 0.0, 0.0, 0.3, 5.0, 6.0], [torque] * 4 + [0.3, -0.3], 60.0)
    assert np.all(np.isfinite(list(end.values())))
    assert np.hypot(end["x"] - 5.0, end["y"] - 6.0) < 1e-3
    assert end["psi"] == pytest.approx(0.3, abs=1e-6)


@pytest.mark.parametrize("steer", [0.0, 0.05])
def test_the_car_drives_off_when_torque_suffices(steer: float):
    """4 x 20 Nm less rolling resistance give 0.2 m/s^2, with the wheels turned as in driving, too."""
    assert drive([0.0] * 6, [20.0] * 4 + [steer, -steer], 5.0)["v"] == pytest.approx(0.98 * np.cos(steer), rel=0.1)


def test_braking_torque_ends_at_rest_and_not_in_reverse():
    end = drive([0.0, 5.0, 0.0, 0.0, 0.0, 0.0], [-100.0] * 4 + [0.02, 0.0], 20.0)
    assert abs(end["v"]) < 1e-6
    assert abs(end["yaw_rate"]) < 1e-6
    assert abs(end["beta"]) < 0.05


def test_coasting_ends_at_rest_and_stays_there():
    end = drive([0.02, 3.0, 0.1, 0.0, 0.0, 0.0], [0.0] * 6, 60.0)
    assert abs(end["v"]) < 1e-6
    assert abs(end["yaw_rate"]) < 1e-9


def test_constant_force_gives_the_closed_form_of_speed():
    """Against rolling resistance alone, drag taken out of the comparison by low speed: dv/dt = (F - F_R)/m."""
    end = drive([0.0, 1.5, 0.0, 0.0, 0.0, 0.0], [40.0] * 4 + [0.0, 0.0], 1.0)
    force = 160.0 / ROMO.chassis.wheel_radius_m - float(driving_resistance(ROMO, 1.75, 0.0))
    assert end["v"] == pytest.approx(1.5 + force / 1013.0, rel=2e-3)


def test_it_follows_the_double_track_up_to_four_metres_per_second_squared():
    """A slalom at 12 m/s: yaw rate within 6 % of its peak; the double track has rolling masses, relaxation and lags that the ESTM has not."""
    plant = DoubleTrack(ROMO)
    truth = Machine(plant, 1e-3)
    at = {name: k for k, name in enumerate(plant.states)}
    full, simple = np.array(plant.initial(12.0)), np.array([0.0, 12.0, 0.0, 0.0, 0.0, 0.0])
    off, peak, most = 0.0, 0.0, 0.0
    for k in range(600):
        t = 0.01 * k
        steer = 0.06 * np.sin(2.0 * np.pi * 0.3 * t)
        u = plant.command(torque_cmd=holding(12.0), steer_cmd_fl=steer, steer_cmd_fr=steer)
        for _ in range(10):
            full = truth.step(full, u)
        # the ESTM has no steering lag: it is given the angle that the wheels have
        simple = MACHINE.step(simple, [*[holding(12.0)] * 4, full[at["delta_fl"]], 0.0])
        off = max(off, abs(full[at["yaw_rate"]] - simple[2]))
        peak, most = max(peak, abs(full[at["yaw_rate"]])), max(most, abs(full[at["yaw_rate"]] * full[at["v_x"]]))
    assert 3.0 < most < 4.5
    assert off < 0.06 * peak


def test_jacobian_is_finite_at_rest():
    x, u = ca.SX.sym("x", 6), ca.SX.sym("u", 6)
    rate = ca.vertcat(*MODEL.derivative(ca.vertsplit(x), ca.vertsplit(u)))
    jacobian = ca.Function("j", [x, u], [ca.jacobian(rate, x), ca.jacobian(rate, u)])
    for part in jacobian(np.zeros(6), np.zeros(6)):
        assert np.all(np.isfinite(part.full()))


def test_stiffness_is_that_of_the_double_track():
    front, _ = axle_stiffness(ROMO)
    alpha = 1e-5
    side = float(MODEL._side_force(0, alpha))
    assert side / alpha == pytest.approx(front, rel=1e-4)
