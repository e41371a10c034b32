"""What is written reads back within a millimetre."""

from pathlib import Path

import numpy as np
import pytest

import roads
from roads import Road, RoadError
from roads.gallery.shelf import find

from .. import samples


def farthest(a: Road, b: Road) -> float:
    """Largest distance of the roads' references and edges at equal shares of their lengths, m."""
    s = np.linspace(0.0, a.length, 2001, endpoint=not a.closed)
    t = s * (b.length / a.length)
    worst = [np.max(np.hypot(*(a.reference.position(s) - b.reference.position(t)).T))]
    for side in ("right", "left"):
        lines = []
        for road, at in ((a, s), (b, t)):
            border = np.interp(at, road.s, getattr(road, side), period=road.length if road.closed else None)
            lines.append(road.reference.position(at) + border[:, None] * road.reference.normal(at))
        worst.append(np.max(np.hypot(*(lines[0] - lines[1]).T)))
    worst.append(np.max(np.abs(a.height_at(s) - b.height_at(t))))
    return float(np.max(worst))


def routes() -> dict[str, Road]:
    town = roads.read_network(find("roundabout"))
    noisy = samples.bend().resampled(3.0)
    made = {name: roads.open_road(name) for name in ("commute", "rural", "descent", "handling")}
    return made | {"spline": noisy, "cut": made["rural"][300.5:1200.25], "back": made["rural"].reversed(), "ring": town.route("west/0/1", "north")}


@pytest.mark.parametrize("suffix", [".xodr", ".geojson", ".csv"])
@pytest.mark.parametrize("name", ["commute", "rural", "descent", "handling", "spline", "cut", "back", "ring"])
def test_round_trip_is_within_a_millimetre(tmp_path: Path, name: str, suffix: str):
    road = routes()[name]
    if name == "ring" and suffix == ".csv":
        with pytest.raises(RoadError, match="lanes of constant width from start to end only"):
            roads.write(road, tmp_path / "a.csv")
        return
    roads.write(road, tmp_path / f"a{suffix}")
    copy = roads.read(tmp_path / f"a{suffix}")
    assert copy.closed == road.closed
    assert len(copy.lanes) == len(road.lanes)
    assert sorted(lane.direction for lane in copy.lanes) == sorted(lane.direction for lane in road.lanes)
    # where the edge of a route steps aside at once, a micrometre of station moves the step
    if name != "ring":
        assert farthest(road, copy) < 1e-3
    s = np.linspace(0.3, road.length - 0.3, 1777)
    limits = road.speed_limit_at(s), copy.speed_limit_at(s * copy.length / road.length)
    assert np.mean(~np.isclose(*limits)) < 0.002
    assert list(tmp_path.iterdir()) == [tmp_path / f"a{suffix}"]


def test_a_second_round_changes_nothing(tmp_path: Path):
    road = roads.open_road("rural")
    roads.write(road, tmp_path / "a.xodr")
    roads.write(roads.read(tmp_path / "a.xodr"), tmp_path / "b.xodr")
    assert farthest(roads.read(tmp_path / "a.xodr"), roads.read(tmp_path / "b.xodr")) < 2e-4


def test_bank_friction_and_missing_limits_survive(tmp_path: Path):
    s = np.arange(0.0, 200.0, 2.0)
    points = np.column_stack([s, 0.0 * s])
    limit = np.where(s < 100.0, 13.0, np.inf)
    road = Road.from_points("x", points, -3.5, 3.5, bank=0.1 * np.sin(s / 40.0), friction=np.where(s < 50, 1.0, 0.4), speed_limit=limit)
    for suffix, holds in ((".csv", "friction"), (".xodr", "bank")):
        roads.write(road, tmp_path / f"a{suffix}")
        copy = roads.read(tmp_path / f"a{suffix}")
        assert farthest(road, copy) < 1e-3
        assert np.array_equal(np.isinf(copy.speed_limit_at(s)), np.isinf(limit))
        assert np.allclose(copy.bank_at(s), road.bank_at(s), atol=1e-5)
        if holds == "friction":
            assert np.allclose(copy.friction_at(s), road.friction_at(s))


def test_geographic_origin_survives(tmp_path: Path):
    road = roads.read(samples.gpx(tmp_path), width=7.0)
    for suffix in (".xodr", ".geojson"):
        roads.write(road, tmp_path / f"b{suffix}")
        copy = roads.read(tmp_path / f"b{suffix}")
        assert copy.origin == pytest.approx(road.origin, abs=1e-12)
        assert farthest(road, copy) < 1e-3
    text = (tmp_path / "b.geojson").read_text()
    assert "crs" not in text
    assert '"coordinates": [[11.28' in text


def test_written_opendrive_opens_in_an_independent_reader(tmp_path: Path):
    network = pytest.importorskip("pyxodr.road_objects.network", reason="pyxodr is not installed")
    for name in ("commute", "ring"):
        road = routes()[name]
        roads.write(road, tmp_path / f"{name}.xodr")
        (found,) = network.RoadNetwork(str(tmp_path / f"{name}.xodr"), resolution=0.02).get_roads()
        _, off = road.reference.locate(found.reference_line[:, :2])
        assert np.max(np.abs(off)) < 1e-3


def test_what_opendrive_cannot_hold_is_refused(tmp_path: Path):
    road = Road.from_points("x", [[0.0, 0.0], [50.0, 0.0], [100.0, 0.0]], -5.0, 5.0, lane_edges=[(1, -3.5, 0.0), (-1, 0.0, 3.5)])
    with pytest.raises(RoadError, match=r"x has 1.500 m beside its lanes at s = .*; OpenDRIVE holds lanes side by side"):
        roads.write(road, tmp_path / "a.xodr")
    assert not list(tmp_path.iterdir())
