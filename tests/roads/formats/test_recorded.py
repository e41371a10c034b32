"""GPX and GeoJSON as receivers and phones write them."""

import json
from pathlib import Path

import numpy as np
import pytest

import roads
from roads import RoadError, open_road
from roads.check import check

from ..conditioning.drives import Receiver, driven, gpx, recorded


def drive(tmp_path: Path, **receiver: float) -> Path:
    return gpx(recorded(open_road("rural"), Receiver(**receiver), 0, (1200.0, 20.0)), tmp_path / "drive.gpx")


def edited(path: Path, *changes: tuple[str, str]) -> Path:
    text = path.read_text()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after, 1)
    path.write_text(text)
    return path


def test_times_become_a_recorded_drive(tmp_path: Path):
    road = roads.read(drive(tmp_path))
    t, s = driven(open_road("rural"), 1.0, (1200.0, 20.0))
    assert road.recorded is not None
    assert road.recorded.duration == pytest.approx(t[-1], abs=0.01)
    assert road.recorded.s[-1] == pytest.approx(road.length)
    assert np.interp(t, road.recorded.t, road.recorded.s) == pytest.approx(s, abs=3.0)
    ((place, stood),) = [stop for stop in road.recorded.stops if stop[1] > 5.0]
    assert place == pytest.approx(1200.0, abs=3.0)
    assert stood == pytest.approx(20.0, abs=3.0)


def test_recorded_speeds_are_used(tmp_path: Path):
    path = drive(tmp_path)
    text = path.read_text().replace(
        "</time>", "</time><extensions><a:TrackPointExtension><a:speed>14.0</a:speed></a:TrackPointExtension></extensions>"
    )
    path.write_text(text.replace("<gpx ", '<gpx xmlns:a="http://www.garmin.com/xmlschemas/TrackPointExtension/v2" '))
    road = roads.read(path)
    assert road.recorded is not None
    # as even as they were told, scaled to the way in the time there was
    assert np.ptp(road.recorded.v) < 0.01
    assert road.recorded.v[0] == pytest.approx(road.length / road.recorded.duration, rel=1e-3)
    path.write_text(path.read_text().replace("14.0", "36.0"))
    other = roads.read(path)
    assert any("the speeds are not used" in str(finding) for finding in other.findings)
    assert other.recorded is not None
    assert np.ptp(other.recorded.v) > 5.0


def test_a_line_without_borders_is_one_lane_with_a_word(tmp_path: Path):
    road = roads.read(drive(tmp_path))
    assert (road.left - road.right) == pytest.approx(3.5)
    assert [lane.direction for lane in road.lanes] == [1]
    assert [str(finding.severity) for finding in check(drive(tmp_path))][-1] == "note"
    assert any("without borders" in str(finding) for finding in check(drive(tmp_path)))
    assert not any("without borders" in str(finding) for finding in roads.read(drive(tmp_path), width=7.0).findings)


def test_single_heights_that_are_missing_are_those_between(tmp_path: Path):
    path = drive(tmp_path)
    whole = roads.read(path)
    lines = path.read_text().splitlines()
    for k in (2, 3, 50):
        before, _, rest = lines[k].partition("<ele>")
        lines[k] = before + rest.partition("</ele>")[2]
    path.write_text("\n".join(lines))
    road = roads.read(path)
    assert np.abs(road.height_at(np.arange(0.0, 2900.0, 5.0)) - whole.height_at(np.arange(0.0, 2900.0, 5.0))).max() < 0.5
    (warning,) = [finding for finding in road.findings if finding.severity == "warning"]
    assert ":3" in warning.place
    assert "3 of" in warning.message


def test_some_times_that_are_missing_are_told(tmp_path: Path):
    path = drive(tmp_path)
    first = path.read_text().partition("<time>")[2].partition("</time>")[0]
    road = roads.read(edited(path, (f"<time>{first}</time>", "")))
    assert road.recorded is None
    assert any("1 of" in str(finding) and "no time" in str(finding) for finding in road.findings)


def test_a_time_that_is_none_is_an_error_with_its_line(tmp_path: Path):
    path = edited(drive(tmp_path), ("2026-05-04T00:00:01", "yesterday"))
    with pytest.raises(RoadError, match=r"drive.gpx: line 4: time is 'yesterday"):
        roads.read(path)


def test_further_tracks_are_told(tmp_path: Path):
    path = edited(drive(tmp_path), ("</trk></gpx>", '</trk><trk><trkseg><trkpt lat="1" lon="1"/></trkseg></trk></gpx>'))
    assert any("2 tracks and 0 routes" in str(finding) for finding in roads.read(path).findings)


def test_raw_accuracy_and_leg_reach_the_line(tmp_path: Path):
    path = drive(tmp_path, plane=2.0)
    places = len(recorded(open_road("rural"), Receiver(plane=2.0), 0, (1200.0, 20.0)))
    assert places <= len(roads.read(path, raw=True).s) < 1.2 * places
    loose, tight = roads.read(path, accuracy=3.0), roads.read(path, accuracy=(0.8, 5.0))
    assert loose.reference.squared_curvature() < tight.reference.squared_curvature()
    with pytest.raises(RoadError, match="leg 2 of a drive that has 1"):
        roads.read(path, leg=2)
    with pytest.raises(RoadError, match="leave width, lane, raw, accuracy and leg out"):
        roads.read(Path("x.xodr"), raw=True)


@pytest.mark.parametrize("key", ["coordTimes", "coordinateProperties"])
def test_geojson_tells_times_as_converters_write_them(tmp_path: Path, key: str):
    x = np.arange(50) * 1e-4
    times = [f"2026-05-04T10:00:{k:02d}Z" for k in range(50)]
    properties = {"coordTimes": times} if key == "coordTimes" else {"coordinateProperties": {"times": times}}
    geometry = {"type": "LineString", "coordinates": [[11.0 + value, 48.0 + 0.1 * value, 500.0] for value in x]}
    path = tmp_path / "drive.geojson"
    path.write_text(json.dumps({"type": "Feature", "properties": properties, "geometry": geometry}))
    road = roads.read(path)
    assert road.recorded is not None
    assert road.recorded.duration == 49.0
    assert road.recorded.v[5:-5] == pytest.approx(road.length / 49.0, rel=0.01)


def table(tmp_path: Path, receiver: Receiver, *, names: str = "t,x,y,z") -> Path:
    recording = recorded(open_road("rural"), receiver, 0, (1200.0, 20.0))
    assert recording.time is not None
    assert recording.height is not None
    rows = np.column_stack([recording.time, recording.points, recording.height])
    path = tmp_path / "drive.csv"
    path.write_text(names + "\n" + "\n".join(",".join(f"{value:.4f}" for value in row) for row in rows))
    return path


def test_a_path_table_recorded_with_noise_is_smoothed(tmp_path: Path):
    path = table(tmp_path, Receiver(2.0, 1.0))
    road = roads.read(path)
    assert any("line smoothed" in str(finding) for finding in road.findings)
    assert road.recorded is not None
    assert road.recorded.duration == pytest.approx(driven(open_road("rural"), 1.0, (1200.0, 20.0))[0][-1], abs=1.0)
    assert road.length == pytest.approx(open_road("rural").length, rel=0.02)
    raw = roads.read(path, raw=True)
    assert raw.length > 1.01 * road.length
    assert "t" in raw.columns


def test_a_path_table_with_exact_places_keeps_them_and_its_speeds(tmp_path: Path):
    s = np.arange(0.0, 1000.0, 5.0)
    v = 15.0 + 5.0 * np.sin(s / 100.0)
    rows = np.column_stack([s, 300.0 * np.sin(s / 300.0), 300.0 * (1.0 - np.cos(s / 300.0)), v])
    path = tmp_path / "line.csv"
    path.write_text("s,x,y,v\n" + "\n".join(",".join(f"{value:.6f}" for value in row) for row in rows))
    road = roads.read(path)
    assert len(road.s) == len(s)
    assert road.recorded is not None
    assert road.recorded.v == pytest.approx(v, abs=1e-5)
    assert road.recorded.duration == pytest.approx(float(np.sum(5.0 * 2.0 / (v[1:] + v[:-1]))), rel=1e-3)
