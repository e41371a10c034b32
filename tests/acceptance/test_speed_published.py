"""The speed against what was asked for and published: energy against time, savings at equal arrival, and eco beside other methods.

Published: TUM's minimum-time study with an energy limit (Berlin, formula car): 28 % less energy at the wheel for 2.1 % more time.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import energy_mgr
import roads
from benchmarks import tum_front
from energy_mgr import SpeedLimits, plan_path
from energy_mgr.planning import Plan
from energy_mgr.speed import SpeedProfile, fastest_profile, plan_speed
from energy_mgr.speed.result import energy_of
from powertrain import load_vehicle

from ..conftest import DATA
from .documents import RESULTS, differences, sentence

TRACKS = sorted((DATA / "roads" / "tum").glob("*.csv"))
SHORT = [track for track in TRACKS if track.stem in ("rounded_rectangle", "handling_track")]
CIRCUITS = [track for track in TRACKS if track not in SHORT]
QUICK = ("Norisring", "Oschersleben")
ROADS = ("commute", "rural", "descent")
ABSENT = f"no real tracks in {DATA.name}/roads/tum beside the checkout (set ENERGY_MGR_DATA)"
KWH = 3.6e6

# -- time against energy ------------------------------------------------------------------------------------------------------------------


@cache
def solvers(track: Path):
    return tum_front.solvers(track)


@pytest.mark.skipif(not SHORT, reason=ABSENT)
@pytest.mark.parametrize("track", SHORT, ids=lambda path: path.stem)
@pytest.mark.parametrize("car", ["as TUM", "no regen", "regen"])
def test_28_percent_less_energy_costs_no_more_time_than_published(track: Path, car: str, figure):
    solver = solvers(track)[car]
    # energy at the wheel is the published measure; with recuperation it is not what is saved
    measure = tum_front.battery if car == "regen" else tum_front.wheel
    found = tum_front.saved(solver, measure, tum_front.LESS)
    assert measure(solver.limits, found) <= (1.0 - tum_front.LESS) * measure(solver.limits, solver.fastest) * (1.0 + 1e-3)
    later = 100.0 * (found.journey_time / solver.fastest.journey_time - 1.0)
    figure(f"{track.stem}, {car}: 28 % less energy, later by", (later, found.gap), "{:.2f} %, proven gap {:.1e}", published="2.1 % (Berlin)")
    assert found.journey_time <= 1.021 * solver.fastest.journey_time
    assert found.gap < 1e-2


@pytest.mark.skipif(not SHORT, reason=ABSENT)
def test_energy_falls_and_prices_fall_along_the_front():
    solver = solvers(SHORT[-1])["no regen"]
    front = solver.front(9, slowest=1.1 * solver.least_time)
    assert np.all(np.diff(front.journey_time) > 0.0)
    assert np.all(np.diff(front.energy) < 0.0)
    # the price of a second is the slope of the front, which is hollow: a chord's slope lies between the prices at its ends
    slopes = -np.diff(front.energy) / np.diff(front.journey_time)
    assert np.all(slopes[1:] <= front.price[1:-1] * 1.001)
    assert np.all(slopes >= front.price[1:] * 0.999)


# -- savings at equal arrival -------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=ROADS)
def plan(request: pytest.FixtureRequest) -> Plan:
    return energy_mgr.plan(request.param, corridor="road")


def test_path_and_speed_save_what_was_asked_for_at_equal_arrival(plan: Plan):
    compared = plan.comparison
    assert compared.both is not None
    assert compared.reference is not None
    assert compared.both.journey_time == pytest.approx(compared.reference.journey_time, abs=1e-3)
    saved = compared.reference.energy_kwh - compared.both.energy_kwh
    if plan.road.name == "descent":
        assert saved >= 0.02
        return
    # asked for: 20 and 10 %; rural gives 8.1 %, see below
    assert saved >= {"commute": 0.20, "rural": 0.08}[plan.road.name] * compared.reference.energy_kwh


def test_no_speed_on_this_path_saves_ten_percent_on_rural(figure):
    # the bound is proven: what is missing to 10 % is not the solver's
    compared = energy_mgr.plan("rural", corridor="road").comparison
    assert compared.both is not None
    assert compared.reference is not None
    most = 100.0 * (1.0 - compared.both.profile.lower_bound / compared.reference.ledger.total)
    figure("rural: most that any speed on the sequential path saves, proven", most, "{:.3f} %", asked="10 %")
    assert not differences(sentence(RESULTS, "the lower bound proves", "to be the most"), most)
    assert compared.both.profile.lower_bound > 0.9 * compared.reference.ledger.total
    assert compared.both.profile.gap < 1e-4


def test_path_and_speed_each_save_and_both_save_most(plan: Plan):
    # a tenth more time than the lane centre needs: at its least time there is only one speed to drive it at
    later = energy_mgr.plan(plan.road, corridor="road", journey_time=1.1 * plan.comparison.journey_time).comparison
    runs = [later.reference, later.path_only, later.speed_only, later.both]
    assert None not in runs
    reference, path_only, speed_only, both = (run.ledger.total for run in runs if run is not None)
    assert both < min(path_only, speed_only)
    assert max(path_only, speed_only) < reference


# -- eco beside the other methods ---------------------------------------------------------------------------------------------------------


@cache
def problem(where: str | Path) -> tuple[SpeedLimits, float]:
    """Limits of the ROMO at 2 m, and an arrival time 8 % later than the least."""
    road = roads.open_road(where) if isinstance(where, str) else roads.read(where)
    limits = SpeedLimits.along(road, plan_path(road, 1.05, extent="road"), load_vehicle("romo"))
    return limits, 1.08 * fastest_profile(limits).journey_time


@cache
def eco(where: str | Path) -> SpeedProfile:
    limits, allowed = problem(where)
    return plan_speed(limits, "eco", journey_time=allowed)


def check_beside(where: str | Path, method, figure, *, above: float, below: float) -> None:
    """`eco` takes at most `above` more than a method, at most `below` less, and its proven bound holds for what the other found."""
    limits, allowed = problem(where)
    ours, theirs = eco(where), plan_speed(limits, method, journey_time=allowed)
    assert (ours.status, theirs.status) == ("solved", "solved")
    assert max(ours.journey_time, theirs.journey_time) <= allowed + 1e-5
    found, other = energy_of(limits, ours).total, energy_of(limits, theirs).total
    name = where if isinstance(where, str) else where.stem
    figure(f"{name}: eco above {method}, proven gap", (100.0 * (found - other) / abs(other), ours.gap), "{:+.6f} %, {:.1e}", asked="0.2 %")
    assert found <= other + above * abs(other)
    assert found >= other - below * abs(other)
    assert ours.lower_bound <= other + 1e-6 * abs(other)
    assert ours.gap < 1e-3


# asked for: 0.2 % of IPOPT on the true losses; found: 1e-7
@pytest.mark.parametrize("where", ROADS)
def test_eco_takes_what_ipopt_takes_on_the_true_losses(where: str, figure):
    check_beside(where, "nlp", figure, above=1e-6, below=1e-6)


@pytest.mark.skipif(not CIRCUITS, reason=ABSENT)
@pytest.mark.parametrize("where", [pytest.param(x, id=x.stem, marks=() if x.stem in QUICK else pytest.mark.slow) for x in CIRCUITS])
def test_eco_takes_what_ipopt_takes_on_tracks(where: Path, figure):
    check_beside(where, "nlp", figure, above=1e-6, below=1e-6)


@pytest.mark.parametrize("where", ROADS)
def test_eco_takes_what_cone_programmes_take(where: str, figure):
    check_beside(where, "socp", figure, above=1e-6, below=1e-5)


# dynamic programming knows nothing of derivatives; its grid costs it up to 0.1 %
@pytest.mark.slow
@pytest.mark.parametrize("where", ROADS)
def test_eco_takes_no_more_than_dynamic_programming(where: str, figure):
    check_beside(where, "dp", figure, above=0.0, below=2e-3)


@pytest.mark.slow
@pytest.mark.skipif(not CIRCUITS, reason=ABSENT)
@pytest.mark.parametrize("where", CIRCUITS, ids=lambda path: path.stem)
def test_eco_takes_no_more_than_dynamic_programming_on_tracks(where: Path, figure):
    check_beside(where, "dp", figure, above=0.0, below=2e-3)
