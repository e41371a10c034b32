"""Path and speed as one problem: what docs/results.md says that it saves beyond path, then speed, on shipped roads and real tracks."""

from functools import cache

import pytest

import energy_mgr
from energy_mgr.planning import Plan, Run

from ..conftest import DATA
from .documents import RESULTS, differences, figures

pytestmark = pytest.mark.slow
SHIPPED = ("commute", "rural", "descent")
TRACKS = ("Norisring", "Oschersleben")
#: Solvers end within 1e-6 of the cost; where the optimum is flat a path may lie some centimetres elsewhere, which moves its length and bends so much.
FLAT = 2e-3


@cache
def plan(road: str, corridor: str) -> Plan:
    file = DATA / "roads" / "tum" / f"{road}.csv"
    if road in TRACKS and not file.is_file():
        pytest.skip(f"no real tracks in {DATA.name}/roads/tum beside the checkout (set ENERGY_MGR_DATA)")
    return energy_mgr.plan(file if road in TRACKS else road, corridor=corridor, method="joint")  # pyright: ignore[reportArgumentType]


def runs(road: str, corridor: str) -> tuple[Run, Run, Run]:
    """Lane centre, sequential and joint."""
    compared = plan(road, corridor).comparison
    assert compared.reference is not None
    assert compared.both is not None
    assert compared.joint is not None
    return compared.reference, compared.both, compared.joint


@pytest.mark.parametrize("road", SHIPPED)
def test_joint_plans_save_what_is_documented_beside_the_lane_centre(road: str, figure):
    reference, _, joint = runs(road, "road")
    saved = reference.energy_kwh - joint.energy_kwh
    value, form = (saved, "{:.4f} kWh") if road == "descent" else (100.0 * saved / reference.energy_kwh, "{:.2f} %")
    assert not differences(figures(RESULTS, "road")[road]["jointly"], figure(f"{road}: jointly, saved at equal time", value, form))


@pytest.mark.parametrize("road", [*SHIPPED, "handling", *TRACKS])
def test_joint_plans_save_what_is_documented_beside_path_then_speed(road: str, figure):
    row = figures(RESULTS, "joint plan of")[road]
    more, bends, way = [], [], []
    for corridor in row["corridor"].split(" / "):
        _, both, joint = runs(road, corridor)
        more.append(100.0 * (both.energy_kwh - joint.energy_kwh) / abs(both.energy_kwh))
        bends = [run.path.curve.squared_curvature() for run in (both, joint)]
        way = [run.path.curve.length for run in (both, joint)]
        assert joint.journey_time == pytest.approx(both.journey_time, abs=1e-2)
        figure(f"{road}: corridor {corridor}, jointly: more saved", more[-1], "{:.2f} %")
    figure(f"{road}: corridor road, path then speed -> jointly", (*bends, *way), "{:.3f} -> {:.3f} 1/m, {:.1f} -> {:.1f} m")
    wrong = differences(row["more saved, %"], *more)
    # columns of the corridor `road`, which is the last one
    wrong += differences(row["integral of squared curvature, 1/m"], *bends, share=FLAT) + differences(row["way, m"], *way)
    assert not wrong
