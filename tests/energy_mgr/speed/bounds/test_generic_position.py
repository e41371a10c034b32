"""Limits on a sloped, banked, slippery road in generic position, for a car that nothing is symmetric in, against a slow look at the road itself."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from energy_mgr import SpeedLimits, plan_path
from energy_mgr.path import Path
from energy_mgr.speed import BatteryPower, Comfort, FrictionBrakes, Grip, Lateral, Motors, Posted, SpeedCap, Stop
from energy_mgr.speed.bounds.limits import Window
from powertrain import driving_resistance, force_limits, motor_losses
from powertrain.drive.supply import converter_input
from powertrain.vehicle import GRAVITY
from roads import Road
from tests.roads.generic import generic

from ..rig import VAN, changed, driven_share

CAR = changed(VAN, limits={"acceleration_max_mps2": 1.7, "deceleration_max_mps2": 2.6, "lateral_acceleration_max_mps2": 3.3})
MU, BRAKE, START, END = 0.7, 8000.0, 3.1, 4.7
Floats = np.ndarray
both = pytest.mark.parametrize("closed", [False, True])


@cache
def planned(closed: bool) -> tuple[Road, Path]:
    road = generic(3, closed=closed)
    return road, plan_path(road, 1.1, extent="road")


def limits_on(closed: bool, *, battery: bool = True) -> SpeedLimits:
    road, path = planned(closed)
    parts = [Posted(), Lateral(), Comfort(), Motors(), Grip(MU), FrictionBrakes(BRAKE), SpeedCap([131.3, 160.9], [9.5, np.inf])]
    ends = {} if closed else {"start_speed": START, "end_speed": END}
    made = SpeedLimits.along(road, path, CAR, parts=parts, step=5.3, **ends)
    if not battery:
        return made
    share = np.linspace(0.0, 1.0, len(made.ds))
    return BatteryPower(30e3 + 25e3 * share, 22e3 - 9e3 * share).added(made)


class Looked:
    """What lies along the path at 80 places in each interval, (intervals, 80), its ends among them, looked up in the road."""

    def __init__(self, closed: bool, limits: SpeedLimits) -> None:
        road, path = planned(closed)
        self.closed = closed
        self.s = limits.s[:-1, None] + limits.ds[:, None] * np.linspace(0.0, 1.0, 80)
        own = path.road_station(self.s)
        self.kappa, self.bank, self.mu = path.curve.curvature(self.s), road.bank_at(own), MU * road.friction_at(own)
        self.height, self.posted = road.height_at(own), road.speed_limit_at(np.mod(own, road.length) if closed else own)

    def least(self, values: Floats) -> Floats:
        """At each station the least of `values` in the two intervals beside; those at the ends of an open road have one."""
        least = np.min(values, axis=1)
        beside = [[least[k % len(least)] for k in (at - 1, at) if self.closed or 0 <= k < len(least)] for at in range(len(least) + 1)]
        return np.array([min(pair) for pair in beside])


def halved(keeps: Callable[[Floats], Floats], shape: tuple[int, ...], most: float) -> Floats:
    """The largest numbers up to `most` that keep a bound, by halving."""
    low, high = np.zeros(shape), np.full(shape, most)
    for _ in range(60):
        middle = 0.5 * (low + high)
        good = keeps(middle)
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return low


@both
def test_speeds_are_the_least_that_any_place_in_both_intervals_beside_allows(closed: bool):
    limits = limits_on(closed)
    here = Looked(closed, limits)
    felt = GRAVITY * np.sin(here.bank)
    room = CAR.limits.lateral_acceleration_max_mps2 - np.sign(here.kappa) * felt
    lateral = here.least(np.sqrt(room / np.maximum(np.abs(here.kappa) * np.cos(here.bank), 1e-6)))
    # looked at every 7 cm here, every 10 cm there, where the sample just outside an interval counts as well
    assert limits.speeds["lateral"] == pytest.approx(lateral, rel=1e-2)
    posted = here.least(here.posted)
    assert np.all(limits.speeds["posted"] <= posted)
    # a change within a sample's distance of a station counts on both of its sides
    assert np.count_nonzero(limits.speeds["posted"] < posted) <= 2

    def holds(v: Floats) -> Floats:
        across = here.kappa * v**2 * np.cos(here.bank) + felt
        return np.abs(across) <= here.mu * (GRAVITY * np.cos(here.bank) - here.kappa * v**2 * np.sin(here.bank))

    gripping = here.least(halved(holds, here.s.shape, 300.0))
    # least friction and sharpest bend of an interval count together, hence no more than at any place
    assert np.all(limits.speeds["grip"] <= gripping * (1.0 + 1e-3))
    assert np.median(limits.speeds["grip"] / gripping) > 0.95
    inner = 0.5 * (limits.s[1:] + limits.s[:-1])
    # a cap is no matter of the road: it ends at the seam
    cap = np.where((inner > 131.3) & (inner < 160.9), 9.5, np.inf)
    assert np.array_equal(limits.speeds["cap"], np.minimum(np.append(cap[0], cap), np.append(cap, cap[-1])))
    assert np.array_equal(limits.v_max, np.min(list(limits.speeds.values()), axis=0))
    assert limits.energy_max[[0, -1]] == pytest.approx([min(limits.v_max[[0, -1]]) ** 2 / 2] * 2 if closed else [START**2 / 2, END**2 / 2])


@both
@pytest.mark.parametrize("sign", [1, -1])
def test_accelerations_are_what_each_force_leaves_on_the_slope_that_asks_most(closed: bool, sign: int):
    limits = limits_on(closed)
    here = Looked(closed, limits)
    v = np.random.default_rng(6).uniform(2.0, 9.0, len(limits.ds))
    mean = np.diff(here.height[:, [0, -1]])[:, 0] / limits.ds
    rise = np.diff(here.height, axis=1) / np.diff(here.s, axis=1)
    # kinks of height count for 2 % at most
    slope = np.clip(np.max(rise, axis=1) if sign > 0 else np.min(rise, axis=1), mean - 0.02, mean + 0.02)
    count, ratio = CAR.drive.motor_count, CAR.motor_ratio
    idle = float(converter_input(CAR.electrics, CAR.electrics.auxiliary_w))
    power = limits.forces[-2 if sign > 0 else -1].power

    def within(force: Floats) -> Floats:
        drawn = sign * force * v + count * sum(motor_losses(CAR, sign * force / (count * ratio), v * ratio)) + idle
        return sign * drawn <= power

    # braking harder than some force gives back less: below 12 kN, where the motor's torque ends, it does not
    electric = halved(within, v.shape, 12e3)
    motors = np.minimum(force_limits(CAR, v)[0 if sign > 0 else 1], electric) + (0.0 if sign > 0 else BRAKE)
    at = np.argmax(np.abs(here.kappa), axis=1)
    bend = here.kappa[np.arange(len(v)), at] * v**2 / GRAVITY
    bank = 0.5 * (here.bank[:, 0] + here.bank[:, -1])
    across, load = bend * np.cos(bank) + np.sin(bank), np.min(here.mu, axis=1) * (np.cos(bank) - bend * np.sin(bank))
    weight = CAR.chassis.mass_kg * GRAVITY * (driven_share(CAR) if sign > 0 else 1.0)
    tyres = weight * np.sqrt(np.maximum(load**2 - across**2, 0.0))
    expected = (np.minimum(motors, tyres) - sign * driving_resistance(CAR, v, slope)) / CAR.effective_mass
    found = limits.ceiling(v, sign)
    # friction may change by 0.005 over the 10 cm from sample to sample there, 7 cm here
    # the root of the ellipse is steep near its end, and its corner rounded by 1 % of the weight
    clear = tyres > 0.15 * weight
    assert found[clear] == pytest.approx(expected[clear], abs=6e-2)
    assert np.count_nonzero(clear) > 0.6 * len(v)
    assert np.count_nonzero(clear & (tyres < motors)) > 3
    assert np.count_nonzero(clear & (motors < tyres)) > 3
    assert np.all(found[~clear] < expected[~clear] + 0.1)


@both
def test_lines_above_the_ceilings_are_above_them_at_all_speeds_and_touch_that_of_grip(closed: bool):
    limits = limits_on(closed)
    v = np.random.default_rng(6).uniform(2.0, 7.0, len(limits.ds))
    fastest = np.full_like(v, 12.0)
    seen = 0
    for limit in limits.forces:
        line = limit.majorant(CAR, v, fastest, limit.data)
        if line is None:
            continue
        seen += 1
        for share in np.linspace(0.0, 1.0, 25):
            u = share * fastest
            # that of power is the chord of torque and power together
            both_of = [one.ceiling(CAR, u, one.data) for one in limits.forces if one.of == "motors" and one.sign == limit.sign]
            own = np.min(both_of, axis=0) if limit.name == "motor power" else limit.ceiling(CAR, u, limit.data)
            assert np.all(line[0] + line[1] * u**2 >= own - 1e-6)
        if limit.of == "tyres":
            # rounding takes a quarter of a hundredth squared over the share of the weight that is left
            top = line[0] + line[1] * v**2
            own = limit.ceiling(CAR, v, limit.data)
            weight = CAR.chassis.mass_kg * GRAVITY * limit.share
            inside = own > 0.1 * weight
            assert np.count_nonzero(inside) > 20
            assert own[inside] == pytest.approx(top[inside], abs=weight * 1e-4 / 0.4)
    assert seen == 6


def test_a_stretch_is_the_rest_of_the_way():
    limits = limits_on(False)
    limits = Stop(float(limits.s[60])).added(limits)
    windows = (Window(float(limits.s[30]), 4.0, 9.0), Window(float(limits.s[50]), 11.0, 31.0))
    limits = replace(limits, windows=windows)
    start, last = float(limits.s[21] + 0.4 * limits.ds[21]), 64
    cut = limits.stretch(start, last, 5.3, 2.9, 6.5)
    assert cut.s == pytest.approx(np.append(start, limits.s[22 : last + 1]))
    assert (cut.start_speed, cut.end_speed) == (5.3, 2.9)
    assert [tuple(window) for window in cut.windows] == [(windows[0].s, 0.0, 2.5), (windows[1].s, 4.5, 24.5)]
    assert cut.z == pytest.approx(np.append(np.interp(start, limits.s, limits.z), limits.z[22 : last + 1]))
    v = np.linspace(2.0, 8.0, len(limits.ds))
    for sign in (1, -1):
        assert cut.ceiling(v[21:last], sign) == pytest.approx(limits.ceiling(v, sign)[21:last], rel=1e-12)
    for name, bound in limits.speeds.items():
        assert np.array_equal(cut.speeds[name], bound[21 : last + 1]), name
