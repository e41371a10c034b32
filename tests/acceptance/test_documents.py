"""README.md and docs/results.md say what the code computes: the plans of the shipped roads, and figures that both documents print.

The tables of joint plans and of drives in closed loop are held by `test_joint_savings` and `test_closed_loop`, which take minutes.
"""

import re
from functools import cache

import pytest

import energy_mgr
from energy_mgr.planning import Plan, saving_percent

from .documents import README, RESULTS, differences, figures, numbers, printed_comparison, read, sentence, table, units

ROADS = ("commute", "rural", "descent")
EXPERIMENTS = {"commute": "E2", "rural": "E3", "descent": "E4"}


@cache
def plan(road: str) -> Plan:
    return energy_mgr.plan(road, corridor="road")


def saved(plan: Plan, which: str) -> float:
    """As the documents print it: % of the baseline, or kWh where the baseline gains energy."""
    run, reference = getattr(plan.comparison, which), plan.comparison.reference
    assert reference is not None
    percent = saving_percent(run, reference)
    return reference.energy_kwh - run.energy_kwh if percent is None else percent


def test_readme_prints_what_make_plan_prints():
    compared, printed = plan("commute").comparison, printed_comparison()
    ways = {"lane centre, V1 (baseline)": "reference", "path only": "path_only", "speed only": "speed_only", "path and speed": "both"}
    assert list(printed) == list(ways)
    for way, which in ways.items():
        run = getattr(compared, which)
        kwh = compared.reference.energy_kwh - run.energy_kwh
        assert not differences(printed[way], run.journey_time, run.energy_kwh, kwh, saved(plan("commute"), which)), way


@pytest.mark.parametrize("road", ROADS)
def test_savings_of_the_shipped_roads_are_the_documented_ones(road: str, figure):
    made, row = plan(road), figures(RESULTS, "road")[road]
    columns = {"path only (V2)": "path_only", "speed only": "speed_only", "path, then speed": "both"}
    form = "{:.4f} kWh" if road == "descent" else "{:.2f} %"
    found = {column: figure(f"{road}: {column}, saved at equal time", saved(made, which), form) for column, which in columns.items()}
    assert not [words for column, value in found.items() for words in differences(row[column], value)]


def test_savings_by_speed_only_with_more_time_are_the_documented_ones(figure):
    found = []
    for road in ROADS:
        later = energy_mgr.plan(road, corridor="road", journey_time=1.05 * plan(road).comparison.journey_time)
        found.append(figure(f"{road}, speed only, with 5 % more time", saved(later, "speed_only")))
    assert not differences(sentence(RESULTS, "baseline slowed by V2, speed only saves", "kWh."), *found)


# -- what documents say twice -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("road", ROADS)
def test_savings_at_equal_time_are_the_same_wherever_they_are_printed(road: str):
    own = figures(RESULTS, "road")[road]
    expected = numbers(" ".join(own[column] for column in ("path only (V2)", "path, then speed", "jointly")))
    for document, key, column in ((RESULTS, "experiment", "ours"), (README, "Reproduced results", "here")):
        rows = {name: row for name, row in figures(document, key).items() if name.startswith(EXPERIMENTS[road]) and "closed loop" not in name}
        assert [abs(value) for row in rows.values() for value in numbers(row[column])] == expected, document
    if road == "commute":
        assert numbers(sentence(README, "path and speed as one problem:", ".venv")) == expected[:0:-1]


def test_summary_of_the_closed_loop_is_that_of_its_tables():
    driven, summary = {road: figures(RESULTS, road) for road in ROADS}, figures(RESULTS, "closed loop")

    def change(what: str, sign: float = -1.0) -> list[float]:
        """% on the first two roads, kWh on `descent`, where energies are near zero."""
        columns = ("change %", "change %", "change kWh")
        return [sign * numbers(driven[road][what][column])[0] for road, column in zip(ROADS, columns, strict=True)]

    assert not differences(summary["saving, published method"]["ours"], *change("path, heuristic"))
    assert not differences(summary["saving, ours"]["ours"], *change("ours, physical"))
    assert not differences(summary["physical cost, published allocation"]["ours"], *change("lane, physical", 1.0))
    offsets = [numbers(driven[road]["ours, physical"]["offset rms, max m"]) for road in ROADS]
    assert numbers(summary["offset"]["ours"])[:2] == [max(column) for column in zip(*offsets, strict=True)]
    readme = figures(README, "Reproduced results")["E2, E3, E4, closed loop, ours"]
    assert not differences(readme["here"], *numbers(summary["saving, ours"]["ours"]), digits=0.0)
    lane_change = numbers(figures(RESULTS, "E1")["ours, physical"]["drives kJ"])
    assert not differences(figures(README, "Reproduced results")["E1, double lane change, energy"]["here"].split(",")[1], *lane_change)
    assert not differences(summary["E1 in closed loop"]["ours"].split(":")[0], *lane_change)


def test_each_section_of_the_results_names_the_commands_that_print_its_figures():
    command = re.compile(r"`(?:pytest|make bench|energy-mgr|python -m)\b[^`]*`")
    title, *sections = re.split(r"\n#+ ", read(RESULTS))
    assert "figures" in title
    assert not [section.splitlines()[0] for section in sections if not command.search(section)]
    for key, column in (("experiment", "command or test"), ("what", "command"), ("Path", "command")):
        rows = figures(RESULTS, key)
        assert all(row[column].startswith(("pytest ", "make bench", "energy-mgr ", "python -m ", "the same")) for row in rows.values()), key
    assert all(row["command"] for row in figures(README, "Reproduced results").values())


def test_a_table_is_found_by_its_first_heading_or_by_the_heading_above_it():
    text = "# Some\n\n| a | `b` |\n|---|---|\n| x | **1.5** |\n| x | -2e-3 kWh |\n\n## Other\n\nwords\n\n| c | d |\n|---|---|\n| y | 1,512 of V2 |\n"
    assert table(text, "a") == table(text, "Some") == {"x": {"b": "1.5"}, "x 2": {"b": "-2e-3 kWh"}}
    assert table(text, "Other") == {"y": {"d": "1,512 of V2"}}
    assert (numbers("-2e-3 kWh"), units("-2e-3 kWh"), numbers("1,512 of V2, 0.3 -> 0.4, 5-7")) == ([-2e-3], [1e-3], [1512.0, 0.3, 0.4, 5.0, 7.0])
    with pytest.raises(AssertionError, match="no table 'e'"):
        table(text, "e")


def test_a_number_is_held_to_its_last_digits_and_to_how_many_there_are():
    assert not differences("15.6 %, 0.01", 15.69, 0.004)
    assert differences("15.6 %", 15.71) == ["'15.6 %' says 15.6, computed is 15.71"]
    assert differences("15.6 %", -15.6)
    assert not differences("15.6 %", 15.79, digits=2.0)
    assert not differences("150", 151.4, share=0.01)
    assert differences("15.6", 15.6, 1.0) == ["'15.6' has 1 numbers, 2 are computed"]
