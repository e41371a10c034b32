"""The published comparison E2 to E4 ([T 3.5] to [T 3.7] of the source) on the archetypes, and plans on real race tracks."""

import numpy as np
import pytest

import energy_mgr
import roads
from energy_mgr.planning import Plan

from ..conftest import DATA

TRACKS = sorted((DATA / "roads" / "tum").glob("*.csv"))


@pytest.fixture(scope="module", params=["commute", "rural", "descent"])
def plan(request: pytest.FixtureRequest) -> Plan:
    return energy_mgr.plan(request.param, corridor="road")


def check(plan: Plan) -> None:
    """What every plan must keep; the limits are re-evaluated every 0.1 m in the tests of the speed."""
    assert plan.chosen.path.report.status == "solved"
    assert plan.chosen.profile.status == "solved"
    assert plan.chosen.path.report.max_violation_m <= 1e-3
    assert plan.journey_time == pytest.approx(plan.baseline.journey_time, abs=0.1)
    s = np.arange(0.0, plan.chosen.path.curve.length, 0.1)
    assert np.max(np.abs(plan.chosen.path.curve.curvature(s)) * plan.chosen.profile.speed_at(s) ** 2) <= 4.0 * 1.001
    assert plan.energy_kwh < plan.baseline.energy_kwh


def test_shipped_roads_are_planned_within_all_limits(plan: Plan):
    check(plan)


def test_savings_are_larger_than_the_published_ones(plan: Plan):
    # published, path only with scaled limits: E2 11.35 %, E3 3.77 %, E4 0.006 kWh (its percentage is of a net energy near zero)
    published = {"commute": 11.35, "rural": 3.77}
    if plan.road.name in published:
        assert plan.saving_percent is not None
        assert plan.saving_percent > published[plan.road.name]
    else:
        assert plan.baseline.energy_kwh - plan.energy_kwh > 0.006


def test_path_alone_reproduces_the_published_saving_in_size():
    # the published road is unknown; its archetype gives 15.6 % for 11.35 %, and the specification expects 7 to 28 % on synthetic roads
    path_only = energy_mgr.planning.saving_percent(
        *(getattr(energy_mgr.plan("commute", corridor="road").comparison, which) for which in ("path_only", "reference"))
    )
    assert path_only is not None
    assert 7.0 < path_only < 28.0


@pytest.mark.skipif(not TRACKS, reason=f"no real tracks in {DATA.name}/roads/tum beside the checkout (set ENERGY_MGR_DATA)")
@pytest.mark.parametrize("track", TRACKS, ids=lambda path: path.stem)
def test_real_tracks_are_planned_within_all_limits(track):
    road = roads.read(track)
    assert road.closed
    check(energy_mgr.plan(road, corridor="road"))
