"""`energy-mgr front`, and the rules of a drive on the command line."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from energy_mgr import DriveRules, plan, plan_front
from energy_mgr.cli.main import main


def test_front_prints_and_writes_drives_that_trade_time_for_energy(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "front.csv"
    assert main(["front", "handling", "--count", "5", "--step", "4", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "handling: " in printed
    assert "price W" in printed
    rows = list(csv.DictReader(out.read_text().splitlines()))
    time, energy = (np.array([float(row[name]) for row in rows]) for name in ("time_s", "energy_kwh"))
    assert len(rows) == 5
    assert np.all(np.diff(time) > 0.0)
    assert np.all(np.diff(energy) < 0.0)


def test_front_draws_a_picture(tmp_path: Path):
    out = tmp_path / "front.svg"
    assert main(["front", "handling", "--count", "3", "--step", "8", "--out", str(out)]) == 0
    assert "<svg" in out.read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["front", "commute", "--out", "x.txt"], "unknown kind of file '.txt'"),
        (["front", "commute", "--slowest", "10"], "slowest time 10.0 s, expected the least possible"),
        (["front", "commute", "--slowest", "nan"], "slowest time nan s"),
        (["plan", "commute", "--window", "80:x"], "expected a station and two times, S:T1:T2"),
        (["plan", "commute", "--stop", "9999"], "station 9999 m, expected 0 to 2500.0 m"),
        (["plan", "commute", "--window", "100:0:1"], "ends at 1.00 s, the earliest arrival from the start is"),
        (["plan", "commute", "--window", "100:40:50", "--window", "100:55:60"], "leave no time: one opens at 55 s, another ends at 50 s"),
        (["plan", "commute", "--jerk", "-1"], "jerk -1.0 m/s^3, expected more than 0"),
        (["plan", "commute", "--grip", "nan"], "friction nan"),
        (["plan", "commute", "--speed", "fast", "--jerk", "1"], "speed fast knows no limit of jerk and no windows"),
        (["plan", "commute", "--price", "3000", "--time", "200"], "expected speed eco or dp, no arrival time, method sequential"),
        (["plan", "commute", "--method", "joint", "--path", "lane"], "expected optimal and eco"),
        (
            ["plan", "commute", "--method", "joint", "--stop", "800"],
            "knows no rules but the speeds at the ends, expected method sequential for stops",
        ),
        (["plan", "commute", "--start-speed", "30"], "start speed 30 m/s at s = 0.0 m, expected 0 to 13.89 m/s there (limit `posted`)"),
        (["plan", "handling", "--jerk", "1"], "a limit of jerk needs an open road"),
        (["plan", "commute", "--step", "0"], "0.0 m between stations"),
        (["plan", "commute", "--soc", "1.5"], "state of charge 1.5, expected 0 to 1"),
    ],
)
def test_what_makes_no_sense_ends_in_one_line(arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    where = [] if "--out" in arguments else ["--out", str(tmp_path / ("f.csv" if arguments[0] == "front" else "plan"))]
    assert main([*arguments, *where]) == 2
    error = capsys.readouterr().err.strip().splitlines()
    assert words in error[-1]


def test_a_plan_keeps_the_rules_that_it_is_given(tmp_path: Path):
    out = tmp_path / "plan"
    code = main(
        ["plan", "commute", "--stop", "800", "--window", "1500:120:130", "--grip", "0.8", "--friction-brakes", "--step", "4", "--out", str(out)]
    )
    assert code == 0
    found = json.loads((out / "plan.json").read_text())
    assert found["speed"]["method"] == "eco"
    assert found["speed"]["gap"] < 0.05
    rules = DriveRules(stops=[800.0], windows=[(1500.0, 120.0, 130.0)], grip=0.8, friction_brakes=True, step=4.0)
    made = plan("commute", rules=rules)
    lam = made.trajectory
    knots = made.chosen.path
    assert lam.point(float(np.interp(800.0, knots.knot_road_s, knots.knot_s))).v == pytest.approx(0.0, abs=1e-6)
    assert 119.9 <= lam.point(float(np.interp(1500.0, knots.knot_road_s, knots.knot_s))).t <= 130.1


def test_a_priced_plan_lies_on_the_front():
    made = plan("commute", price=3000.0, rules=DriveRules(step=5.0))
    _, limits, front = plan_front("commute", count=25, rules=DriveRules(step=5.0))
    assert np.array_equal(limits.s, made.chosen.limits.s)
    # the front is convex: between its points it lies below their chords
    chord = np.interp(made.journey_time, front.journey_time, front.energy)
    assert made.chosen.ledger.total <= chord * (1 + 1e-6)
    assert np.interp(made.journey_time, front.journey_time[1:], front.price[1:]) == pytest.approx(3000.0, rel=0.05)


def test_joint_saves_more_and_is_no_worse(tmp_path: Path):
    assert main(["plan", "handling", "--method", "joint", "--out", str(tmp_path / "p")]) == 0
    found = json.loads((tmp_path / "p" / "plan.json").read_text())["decomposition"]
    assert found["joint_percent"] > found["both_percent"]
