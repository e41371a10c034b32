"""Columns of trajectories at uneven stations, over the seam of a circuit and with unequal ends, against differences and plain sums."""

from functools import cache

import numpy as np
import pytest

from energy_mgr import SpeedLimits, Trajectory, plan_path
from energy_mgr.path import Path
from energy_mgr.speed import SpeedCap, SpeedProfile
from energy_mgr.speed.result import energy_of
from powertrain import driving_resistance, load_vehicle, motor_losses
from roads import Road
from tests.roads.generic import generic

VAN = load_vehicle("van")
Floats = np.ndarray
both = pytest.mark.parametrize("closed", [False, True])


@cache
def made(closed: bool) -> tuple[Road, Path, SpeedLimits, SpeedProfile, Trajectory]:
    """A drive at speeds of its own, at stations 0.6 m to 5 m apart."""
    road = generic(2, closed=closed)
    path = plan_path(road, 1.1, extent="road")
    through = np.cumsum(np.random.default_rng(4).uniform(0.6, 9.0, 200))
    caps = tuple(through[through < path.curve.length - 0.7].tolist())
    cap = SpeedCap(caps, np.full(len(caps), np.inf))
    ends = {} if closed else {"start_speed": 3.0, "end_speed": 5.0}
    limits = SpeedLimits.along(road, path, VAN, extra=[cap], step=4.7, **ends)
    v = 6.0 + 1.7 * np.sin(limits.s / 17.0 + 1.0) + np.random.default_rng(5).uniform(-0.3, 0.3, len(limits.s))
    v[-1] = v[0] if closed else v[-1]
    profile = SpeedProfile(limits.s, v, "solved", 0, 0.0)
    return road, path, limits, profile, Trajectory.of(path, limits, profile, energy_of(limits, profile))


@both
def test_columns_are_the_roads_the_paths_and_the_profiles(closed: bool):
    road, path, _, profile, drive = made(closed)
    s = drive.s
    assert np.max(np.diff(s)) > 3.0 * np.min(np.diff(s))
    own = np.interp(s, path.knot_s, path.knot_road_s)
    assert np.column_stack([drive.x, drive.y]) == pytest.approx(path.curve.position(s), abs=1e-9)
    assert drive.kappa == pytest.approx(path.curve.curvature(s), abs=1e-12)
    assert drive.z == pytest.approx(road.height_at(own), abs=1e-9)
    assert drive.bank == pytest.approx(road.bank_at(own), abs=1e-12)
    assert np.array_equal(drive.v, profile.v)
    assert drive.psi[-1] - drive.psi[0] == pytest.approx(2 * np.pi if closed else float(np.diff(path.curve.heading(s[[0, -1]]))[0]))


@both
def test_acceleration_time_jerk_and_slope_follow_interval_by_interval(closed: bool):
    drive = made(closed)[-1]
    s, v, z, n = drive.s, drive.v, drive.z, len(drive.s) - 1
    gain, time = [], []
    for k in range(n):
        time.append((s[k + 1] - s[k]) / (0.5 * (v[k] + v[k + 1])))
        gain.append((v[k + 1] - v[k]) / time[k])
    assert drive.a == pytest.approx([*gain, gain[0] if closed else gain[-1]], abs=1e-12)
    assert drive.t == pytest.approx([sum(time[:k]) for k in range(n + 1)], abs=1e-9)
    for at in range(n + 1):
        if not closed and at in (0, n):
            assert drive.jerk[at] == drive.jerk[1 if at == 0 else n - 1]
            continue
        before, after = (at - 1) % n, at % n
        assert drive.jerk[at] == pytest.approx((gain[after] - gain[before]) / (0.5 * time[after] + 0.5 * time[before]), abs=1e-9)
        back, ahead = s[before + 1] - s[before], s[after + 1] - s[after]
        parabola = np.polyfit([-back, 0.0, ahead], [z[before], z[at], z[after + 1]], 2)
        assert drive.slope[at] == pytest.approx(parabola[1], abs=1e-9)


@both
def test_between_stations_columns_are_each_others_derivatives(closed: bool):
    drive = made(closed)[-1]
    rng = np.random.default_rng(6)
    share = rng.uniform(0.05, 0.95, len(drive.s) - 1)
    s = drive.s[:-1] + share * np.diff(drive.s)
    # and laps before and after
    s = np.concatenate([s, s - drive.length, s + 2.0 * drive.length]) if closed else s
    h = 1e-4
    here, ahead, behind = drive.at(s), drive.at(s + h), drive.at(s - h)
    slope = {name: (getattr(ahead, name) - getattr(behind, name)) / (2.0 * h) for name in here._fields}
    assert here.v * slope["v"] == pytest.approx(here.a, abs=1e-6)
    assert slope["t"] * here.v == pytest.approx(1.0, abs=1e-6)
    assert slope["z"] == pytest.approx(here.slope, abs=1e-7)
    heading = np.arctan2(slope["y"], slope["x"])
    assert np.cos(heading - here.psi) == pytest.approx(1.0, abs=1e-9)
    # where the planned curve's curvature has a kink within the step the line's parameter is not quite its length
    speed = np.hypot(slope["x"], slope["y"])
    assert slope["psi"] / speed == pytest.approx(here.kappa, abs=1e-6)
    assert speed == pytest.approx(1.0, abs=5e-3)
    assert drive.at_time(here.t) == pytest.approx(s, abs=1e-6)
    for at in (3, 40):
        assert drive.point(float(s[at])) == pytest.approx(tuple(values[at] for values in here), abs=1e-9)
    jerk = drive.jerk[:-1] + share * np.diff(drive.jerk)
    assert here.jerk[: len(share)] == pytest.approx(jerk, abs=1e-9)
    assert here.bank[: len(share)] == pytest.approx(drive.bank[:-1] + share * np.diff(drive.bank), abs=1e-12)


@both
def test_stations_are_met_from_both_sides(closed: bool):
    drive = made(closed)[-1]
    inner = drive.s[1:-1]
    before, after = drive.at(inner - 1e-9), drive.at(inner + 1e-9)
    for name in ("x", "y", "z", "psi", "kappa", "v", "t", "jerk", "slope", "bank"):
        column = getattr(drive, name)[1:-1]
        assert getattr(before, name) == pytest.approx(column, abs=1e-7), name
        assert getattr(after, name) == pytest.approx(column, abs=1e-7), name
    assert after.a == pytest.approx(drive.a[1:-1], abs=1e-12)
    assert before.power == pytest.approx(drive.power[:-2], rel=1e-12)


@both
def test_power_and_time_are_the_integrals_over_the_drive(closed: bool):
    _, _, limits, _, drive = made(closed)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    count, ratio = VAN.drive.motor_count, VAN.motor_ratio
    share = 0.5 * (1.0 + nodes)
    ds = np.diff(drive.s)[:, None]
    v = np.sqrt(drive.v[:-1, None] ** 2 * (1.0 - share) + drive.v[1:, None] ** 2 * share)
    time = np.sum(0.5 * weights * ds / v, axis=1)
    assert np.diff(drive.t) == pytest.approx(time, rel=1e-9)
    slope = (np.diff(limits.z) / np.diff(limits.s))[:, None]
    force = VAN.effective_mass * drive.a[:-1, None] + driving_resistance(VAN, v, slope)
    losses = count * sum(motor_losses(VAN, force / (count * ratio), v * ratio))
    energy = np.sum(0.5 * weights * ds / v * (force * v + losses), axis=1)
    # the account leaves out auxiliaries, and takes the force that air leaves on the mean as that of the whole interval
    assert drive.power[:-1] * time == pytest.approx(energy, abs=2e-3 * float(np.max(np.abs(energy))))
    assert drive.power[-1] == drive.power[0 if closed else -2]
    assert float(np.sum(drive.power[:-1] * time)) == pytest.approx(float(np.sum(energy)), rel=1e-3)
