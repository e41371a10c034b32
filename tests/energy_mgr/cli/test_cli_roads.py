"""`energy-mgr roads`, and plans of roads out of networks, as a person uses them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import roads
from energy_mgr.cli.main import main
from energy_mgr.consumption import route_energy
from powertrain import load_vehicle

from ...roads import samples


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = main(["roads", *arguments])
    shown = capsys.readouterr()
    return code, shown.out, shown.err


def test_info_describes_roads_and_networks(capsys: pytest.CaptureFixture[str]):
    code, out, _ = run(capsys, "info", "rural")
    assert code == 0
    assert "rural: 3000.00 m, open, traffic keeps right" in out
    assert "speed limit  60 to 80 km/h" in out
    code, out, _ = run(capsys, "info", "roundabout")
    assert "20 roads, 1.440 km, 24 lanes for cars" in out
    assert "ring past north" in out
    code, out, _ = run(capsys, "info", "roundabout", "--road", "east")
    assert "roundabout east: 281.89 m" in out


def test_check_lists_findings_and_tells_by_its_exit_code(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    assert run(capsys, "check", "commute")[:2] == (0, "0 errors, 0 warnings, 0 notes\n")
    (tmp_path / "bad.csv").write_text("0,0,3,3\n1,nan,3,3\n")
    code, out, _ = run(capsys, "check", str(tmp_path / "bad.csv"))
    assert code == 1
    assert f"error: {tmp_path / 'bad.csv'}:2: column 2 is 'nan', expected a finite number" in out
    rows = [(2.0 * k, 0.0, 3.5, 3.5, 10.0 * (k > 20)) for k in range(40)]
    (tmp_path / "step.csv").write_text("# x_m,y_m,w_tr_right_m,w_tr_left_m,z_m\n" + "\n".join(",".join(map(str, row)) for row in rows))
    code, out, _ = run(capsys, "check", str(tmp_path / "step.csv"))
    assert code == 0
    assert "warning: " in out
    assert "slope of" in out


def test_convert_writes_what_it_says(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    out = tmp_path / "part.xodr"
    code, text, _ = run(capsys, "convert", "rural", str(out), "--start-at", "500", "--end-at", "900", "--reverse", "--spacing", "1")
    assert code == 0
    assert "(400.0 m)" in text
    made, rural = roads.read(out), roads.open_road("rural")
    assert np.allclose(made.reference.position(0.0), rural.reference.position(900.0), atol=1e-3)
    code, text, _ = run(capsys, "convert", str(samples.gpx(tmp_path)), str(tmp_path / "a.geojson"), "--width", "6", "--smooth", "0.5")
    assert "smoothed: largest deviation" in text
    assert roads.read(tmp_path / "a.geojson").origin is not None
    code, text, _ = run(capsys, "convert", str(samples.path_csv(tmp_path)), str(tmp_path / "b.xodr"), "--lane", "3.5", "--width", "7")
    assert "not kept: columns s, psi, v, kappa" in text
    code, _, err = run(capsys, "convert", str(out), str(out))
    assert code == 2
    assert "is the file that is read" in err


@pytest.mark.parametrize("suffix", [".png", ".svg"])
@pytest.mark.parametrize("road", ["handling", "roundabout", "rural"])
def test_show_draws(capsys: pytest.CaptureFixture[str], tmp_path: Path, road: str, suffix: str):
    out = tmp_path / "new" / f"a{suffix}"
    assert run(capsys, "show", road, "--out", str(out))[0] == 0
    assert out.stat().st_size > 10_000
    assert [file.name for file in out.parent.iterdir()] == [out.name]


def test_route_shows_its_lanes_and_writes_the_road(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    out = tmp_path / "route.xodr"
    code, text, _ = run(capsys, "route", "roundabout", "--from", "west/0/1", "--to", "100,-1.75", "--cost", "energy", "--out", str(out))
    assert code == 0
    assert "ring past south/0/-1" in text
    assert roads.read(out).length == pytest.approx(roads.open_road("roundabout", start="west/0/1", goal=(100.0, -1.75)).length, abs=1e-3)


ERRORS = {
    "no file": (("info", "nowhere.xodr"), "nowhere.xodr: no such file"),
    "no road": (("info", "nowhere"), "no shipped road, expected a road file or one of commute"),
    "no id": (("info", "roundabout", "--road", "x"), "no road 'x', expected one of"),
    "no way": (("route", "roundabout", "--from", "east/0/-1", "--to", "west"), "no way from east/0/-1 to west along the lanes' directions"),
    "half a route": (("route", "roundabout", "--from", "east"), "give both --from and --to"),
    "several roads": (("convert", "roundabout", "a.csv"), "holds 20 roads, give the id of one or start and goal"),
    "no picture": (("show", "commute", "--out", "a.gif"), "unknown kind of picture '.gif', expected one of .png, .svg, .pdf"),
    "no format": (("convert", "commute", "a.gpx"), "cannot write format '.gpx'"),
    "no bound": (("convert", "commute", "a.csv", "--smooth", "0"), "largest deviation 0.0 m, expected more than 0"),
    "beyond": (("convert", "commute", "a.csv", "--end-at", "9999"), "stretch None:9999.0 m, expected increasing stations between 0 and 2500.000 m"),
}


@pytest.mark.parametrize("name", ERRORS)
def test_errors_are_one_line(capsys: pytest.CaptureFixture[str], name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    arguments, words = ERRORS[name]
    code, _, err = run(capsys, *arguments)
    assert code == 2
    assert words in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_plan_takes_routes_and_lines(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    assert main(["plan", "roundabout", "--from", "west/0/1", "--to", "east", "--out", str(tmp_path / "a")]) == 0
    assert "roundabout: west/0/1 to east: 642 m" in capsys.readouterr().out
    assert main(["plan", str(samples.geojson(tmp_path)), "--width", "7", "--out", str(tmp_path / "b")]) == 0
    assert "bend: 181 m" in capsys.readouterr().out
    assert main(["plan", str(samples.geojson(tmp_path)), "--out", str(tmp_path / "c")]) == 0
    assert "note: " in (said := capsys.readouterr().out)
    assert "one lane of 3.5 m is assumed" in said


def test_energy_of_a_stretch_is_that_of_the_car():
    cost = route_energy(load_vehicle("romo"))
    s = np.linspace(0.0, 1000.0, 101)
    flat, up, down = (cost(s, slope * s, np.full(101, 50 / 3.6)) for slope in (0.0, 0.06, -0.06))
    assert 0.0 < flat < up
    assert down < 0.0
    # twice the way costs twice as much, and standing stations cost nothing
    assert cost(np.append(s, s[1:] + 1000.0), np.zeros(201), np.full(201, 50 / 3.6)) == pytest.approx(2.0 * flat, rel=1e-9)
    assert cost(np.sort(np.append(s, s)), np.zeros(202), np.full(202, 50 / 3.6)) == pytest.approx(flat, rel=1e-9)
    # a limit that changes is driven on both sides of the change
    limit = np.where(s < 500.0, 30 / 3.6, 50 / 3.6)
    assert cost(s, 0.0 * s, limit) == pytest.approx(0.5 * (cost(s, 0.0 * s, np.full(101, 30 / 3.6)) + flat), rel=1e-9)


def test_info_and_check_say_what_was_assumed(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    path = samples.path_csv(tmp_path)
    path.write_text(path.read_text() + "4999;1;0;0;0;0\n")
    for command in ("info", "check"):
        code, out, _ = run(capsys, command, str(path))
        assert code == 0
        assert f"warning: {path}:43: its station 4999 is" in out
        assert f"note: {path}: holds a line without borders: one lane 3.5 m wide about it is assumed" in out
