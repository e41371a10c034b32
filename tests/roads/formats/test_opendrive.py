"""OpenDRIVE files made here, feature by feature; real files and other readers are in the acceptance tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import roads
from roads import RoadError

HEAD = '<?xml version="1.0"?>\n<OpenDRIVE>\n<header revMajor="1" revMinor="{minor}"/>\n'
LINE = '<geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry>'


def lane(number: int, width: str = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>', kind: str = "driving", more: str = "", **attributes: str) -> str:
    extra = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f'<lane id="{number}" type="{kind}"{extra}>{width}{more}</lane>'


def section(left: str = "", right: str = "", s: float = 0.0) -> str:
    sides = (f"<left>{left}</left>" if left else "") + '<center><lane id="0" type="none"/></center>' + (f"<right>{right}</right>" if right else "")
    return f'<laneSection s="{s}">{sides}</laneSection>'


def road(
    plan: str = LINE, lanes: str | None = None, length: float = 100.0, more: str = "", identity: str = "1", link: str = "", rule: str = ""
) -> str:
    lanes = section(lane(1), lane(-1)) if lanes is None else lanes
    return f'<road id="{identity}" length="{length}" junction="-1"{rule}>{link}<planView>{plan}</planView>{more}<lanes>{lanes}</lanes></road>\n'


def write(folder: Path, *parts: str, minor: int = 7) -> Path:
    path = folder / "made.xodr"
    path.write_text(HEAD.format(minor=minor) + "".join(parts) + "</OpenDRIVE>\n")
    return path


def read(folder: Path, *parts: str, **options) -> roads.Road:
    return roads.read(write(folder, *parts), **options)


def test_versions_1_4_to_1_8_read_and_others_do_not(tmp_path: Path):
    for minor in range(4, 9):
        assert roads.read(write(tmp_path, road(), minor=minor)).length == pytest.approx(100.0)
    path = write(tmp_path, road())
    path.write_text(path.read_text().replace('revMajor="1"', 'revMajor="2"'))
    with pytest.raises(RoadError, match=r"made\.xodr:3: <header> revMajor is '2', expected 1"):
        roads.read(path)


def test_arc_and_spiral_are_where_they_must_be(tmp_path: Path):
    arc = '<geometry s="0" x="5" y="6" hdg="0.5" length="40"><arc curvature="-0.05"/></geometry>'
    made = read(tmp_path, road(arc, length=40.0))
    s = np.linspace(0.0, 40.0, 81)
    # a circle of 20 m to the right of (5, 6)
    centre = np.array([5.0 + 20.0 * np.sin(0.5), 6.0 - 20.0 * np.cos(0.5)])
    assert np.allclose(np.hypot(*(made.reference.position(s) - centre).T), 20.0, atol=1e-4)
    assert made.reference.curvature(20.0) == pytest.approx(-0.05, abs=1e-4)
    spiral = '<geometry s="0" x="0" y="0" hdg="0" length="50"><spiral curvStart="0" curvEnd="0.04"/></geometry>'
    made = read(tmp_path, road(spiral, length=50.0))
    from roads.geometry.clothoid import clothoid

    assert np.allclose(made.reference.position([50.0]), clothoid(np.array([50.0]), 0.0, 0.04 / 50.0)[0], atol=1e-4)


@pytest.mark.parametrize("extent", ["arcLength", "normalized"])
def test_parametric_cubics_in_both_ranges(tmp_path: Path, extent: str):
    """A parabola v = u^2 / 40 over 20 m of u."""
    from scipy.integrate import quad

    length = quad(lambda u: np.hypot(1.0, u / 20.0), 0.0, 20.0)[0]
    scale = 20.0 if extent == "normalized" else 20.0 / length
    shape = f'<paramPoly3 pRange="{extent}" aU="0" bU="{scale}" cU="0" dU="0" aV="0" bV="0" cV="{scale**2 / 40}" dV="0"/>'
    made = read(tmp_path, road(f'<geometry s="0" x="0" y="0" hdg="0" length="{length}">{shape}</geometry>', length=length))
    assert made.length == pytest.approx(length, abs=1e-4)
    points = made.reference.position(np.linspace(0.0, made.length, 50))
    assert np.allclose(points[:, 1], points[:, 0] ** 2 / 40.0, atol=1e-3)
    assert np.allclose(points[-1], [20.0, 10.0], atol=1e-3)


def test_poly3_ends_where_its_length_says(tmp_path: Path):
    made = read(tmp_path, road('<geometry s="0" x="0" y="0" hdg="0" length="25"><poly3 a="0" b="0" c="0.02" d="0"/></geometry>', length=25.0))
    points = made.reference.position(np.linspace(0.0, 25.0, 60))
    assert made.length == pytest.approx(25.0, abs=1e-3)
    assert np.allclose(points[:, 1], 0.02 * points[:, 0] ** 2, atol=1e-3)


def test_lane_offset_widths_and_borders(tmp_path: Path):
    taper = '<width sOffset="0" a="3" b="0" c="0" d="0"/><width sOffset="20" a="3" b="0" c="0.0025" d="-0.00002"/>'
    offset = '<laneOffset s="0" a="0.5" b="0.01" c="0" d="0"/>'
    made = read(tmp_path, road(lanes=offset + section(lane(1), lane(-1, taper) + lane(-2))))
    s = np.linspace(0.0, 100.0, 401)
    width = np.where(s < 20.0, 3.0, 3.0 + 0.0025 * (s - 20.0) ** 2 - 0.00002 * (s - 20.0) ** 3)
    right, left = made.corridor("road").borders(s)
    assert np.allclose(left, 0.5 + 0.01 * s + 3.5, atol=1e-3)
    assert np.allclose(right, 0.5 + 0.01 * s - width - 3.5, atol=1e-3)
    border = lane(-1, '<border sOffset="0" a="-4" b="-0.01" c="0" d="0"/>')
    made = read(tmp_path, road(lanes=section("", border)))
    assert np.allclose(made.corridor("road").borders(s)[0], -4.0 - 0.01 * s, atol=1e-3)


def test_height_bank_and_limits(tmp_path: Path):
    more = (
        '<elevationProfile><elevation s="0" a="100" b="0.02" c="0" d="0"/><elevation s="50" a="101" b="0.02" c="-0.0004" d="0"/></elevationProfile>'
    )
    more += '<lateralProfile><superelevation s="0" a="0.1" b="0" c="0" d="0"/></lateralProfile>'
    kinds = '<type s="0" type="town"><speed max="50" unit="km/h"/></type><type s="40" type="rural"><speed max="60" unit="mph"/></type>'
    kinds += '<type s="70" type="rural"><speed max="no limit"/></type>'
    made = read(tmp_path, road(more=kinds + more))
    s = np.linspace(0.0, 100.0, 301)
    assert np.allclose(made.height_at(s), np.where(s < 50, 100 + 0.02 * s, 101 + 0.02 * (s - 50) - 0.0004 * (s - 50) ** 2), atol=1e-3)
    assert np.allclose(made.bank, 0.1)
    # widths are measured on the bank, offsets in plan
    assert np.allclose(made.right, -3.5 * np.cos(0.1), atol=1e-9)
    assert np.allclose(made.speed_limit_at([0.0, 39.9, 40.1, 69.9, 70.1]), [50 / 3.6, 50 / 3.6, 60 * 0.44704, 60 * 0.44704, np.inf])
    network = roads.read_network(write(tmp_path, road(more=more)))
    left, right = network.links["1/0/-1"].borders
    # the left side is the higher one; the lane on the right falls from the reference line outwards
    assert np.allclose(left[:, 2] - right[:, 2], 3.5 * np.sin(0.1))


def test_lane_limits_override_the_roads(tmp_path: Path):
    own = '<speed sOffset="0" max="30" unit="km/h"/><speed sOffset="60" max="10" unit="m/s"/>'
    kinds = '<type s="0" type="town"><speed max="50" unit="km/h"/></type>'
    path = write(tmp_path, road(more=kinds, lanes=section(lane(1, more=own), lane(-1, more=own))))
    made = roads.read(path)
    assert np.allclose(made.speed_limit_at([0.0, 59.0, 61.0]), [30 / 3.6, 30 / 3.6, 10.0])
    # driven the other way the same ground has the same limit
    back = roads.read_network(path).links["1/0/1"]
    assert np.allclose(back.limit_at(np.array([0.0, 39.0, 41.0])), [10.0, 10.0, 30 / 3.6])


def test_left_hand_traffic(tmp_path: Path):
    made = read(tmp_path, road(rule=' rule="LHT"'))
    assert made.left_hand
    assert made.driving_lane().right[0] == 0.0
    network = roads.read_network(tmp_path / "made.xodr")
    assert network.links["1/0/1"].centre[-1, 0] > network.links["1/0/1"].centre[0, 0]


def test_road_that_leads_only_against_its_line_is_turned_round(tmp_path: Path):
    made = read(tmp_path, road(lanes=section(lane(1) + lane(2), "")))
    assert made.reference.position(0.0)[0] == pytest.approx(100.0)
    assert [lane.direction for lane in made.lanes] == [1, 1]
    # driven towards -x the right side is at positive y
    assert made.driving_lane().name == "2"


def test_lane_directions_of_version_1_8(tmp_path: Path):
    made = read(tmp_path, road(lanes=section(lane(1, direction="reversed"), lane(-1, direction="both"))))
    assert [lane.direction for lane in made.lanes] == [0, 1]
    assert list(roads.read_network(tmp_path / "made.xodr").links) == ["1/0/-1", "1/0/-1~", "1/0/1"]


def test_medians_and_pavements_bound_the_carriageway(tmp_path: Path):
    made = read(tmp_path, road(lanes=section(lane(2) + lane(1, kind="median"), lane(-1) + lane(-2, kind="shoulder") + lane(-3, kind="sidewalk"))))
    assert (made.right[0], made.left[0]) == (-3.5, 0.0)
    network = roads.read_network(tmp_path / "made.xodr")
    assert network.links["1/0/-1"].beside == ("1/0/-1",)


def test_a_lane_that_ends_is_left_in_time(tmp_path: Path):
    ends = '<width sOffset="0" a="3.5" b="0" c="-0.0042" d="0.000056"/>'
    first = section("", lane(-1, more='<link><successor id="-1"/></link>') + lane(-2, ends))
    second = section("", lane(-1, more='<link><predecessor id="-1"/></link>'), s=50.0)
    made = read(tmp_path, road(lanes=first + second))
    drive = made.driving_lane()
    assert len(made.lanes) == 2
    assert np.isnan(made.lanes[0].right[-1])
    # the inner lane leads on from start to end, and is the one to drive
    assert np.allclose(drive.left, 0.0)
    path = write(tmp_path, road(lanes=first.replace('id="-1"', 'id="-9"', 1).replace("-9", "-1") + second))
    steps = roads.read_network(path).steps("1/0/-2", "1/1/-1")
    assert [step.link.id for group in steps for step in group] == ["1/0/-2", "1/0/-1", "1/1/-1"]
    route = roads.read_network(path).route("1/0/-2", "1/1/-1")
    offset = route.reference.position(np.linspace(0.0, route.length, 200))[:, 1]
    assert offset[0] == pytest.approx(-5.25, abs=1e-6)
    assert offset[-1] == pytest.approx(-1.75, abs=1e-6)
    assert np.all(np.diff(offset) > -1e-6)


FINDINGS = {
    "gap": (LINE + '<geometry s="100" x="101" y="0" hdg="0" length="10"><line/></geometry>', "starts 1.0000 m and 0.0000 rad away"),
    "kink": (LINE + '<geometry s="100" x="100" y="0" hdg="1" length="10"><line/></geometry>', "starts 0.0000 m and 1.0000 rad away"),
    "tight": (
        '<geometry s="0" x="0" y="0" hdg="0" length="9"><arc curvature="50"/></geometry>',
        "curvature is 50 1/m, expected a radius of at least 0.1 m",
    ),
    "empty": ('<geometry s="0" x="0" y="0" hdg="0" length="9"/>', "holds nothing, expected line, arc"),
    "unknown": ('<geometry s="0" x="0" y="0" hdg="0" length="9"><bezier/></geometry>', "holds bezier, expected line, arc"),
    "nan": ('<geometry s="0" x="nan" y="0" hdg="0" length="9"><line/></geometry>', "x is 'nan', expected a finite number"),
    "missing": ('<geometry s="0" x="0" y="0" length="9"><line/></geometry>', "has no hdg"),
    "negative": ('<geometry s="0" x="0" y="0" hdg="0" length="-9"><line/></geometry>', "length is -9 m, expected more than 0"),
    "still": (
        '<geometry s="0" x="0" y="0" hdg="0" length="9"><paramPoly3 aU="0" bU="0" cU="0" dU="0" aV="0" bV="0" cV="0" dV="0"/></geometry>',
        "cubic stands still",
    ),
    "huge": ('<geometry s="0" x="0" y="0" hdg="0" length="9e8"><line/></geometry>', "is 9e+08 m long, expected at most"),
    "none": ("", "has no geometry"),
}


@pytest.mark.parametrize("name", FINDINGS)
def test_bad_geometry_is_refused_with_its_line(tmp_path: Path, name: str):
    plan, words = FINDINGS[name]
    with pytest.raises(RoadError, match=r"made\.xodr:[0-9]+") as caught:
        read(tmp_path, road(plan))
    assert words in str(caught.value)


LANES = {
    "gap in ids": (section("", lane(-1) + lane(-3)), "expected -1 to -2 without gaps"),
    "twice": (section("", lane(-1) + lane(-1)), "used twice"),
    "wrong side": (section("", lane(1)), "expected a negative whole number"),
    "no section": ("", "has no laneSection"),
    "records go back": (
        section("", lane(-1, '<width sOffset="5" a="3" b="0" c="0" d="0"/><width sOffset="1" a="3" b="0" c="0" d="0"/>')),
        "sOffset goes back",
    ),
    "no lane for cars": (section("", lane(-1, kind="sidewalk")), "has no drivable lane"),
}


@pytest.mark.parametrize("name", LANES)
def test_bad_lanes_are_refused(tmp_path: Path, name: str):
    lanes, words = LANES[name]
    with pytest.raises(RoadError, match=r"made\.xodr:[0-9]+") as caught:
        read(tmp_path, road(lanes=lanes))
    assert words in str(caught.value)


def test_a_bad_road_spares_the_others_and_is_found(tmp_path: Path):
    path = write(tmp_path, road(), road(FINDINGS["gap"][0], identity="2"))
    network = roads.read_network(path)
    assert network.roads == ["1"]
    errors = [finding for finding in network.check() if finding.severity == "error"]
    assert len(errors) == 1
    assert "road 2: geometry 1 starts" in errors[0].message


def test_small_gaps_are_warnings(tmp_path: Path):
    near = LINE + '<geometry s="100" x="100.01" y="0" hdg="0.02" length="10"><line/></geometry>'
    findings = roads.read_network(write(tmp_path, road(near, length=111.0))).findings
    assert [finding.severity for finding in findings] == ["warning", "warning"]
    assert "its geometries end at 110 m" in findings[0].message or "its geometries end at 110 m" in findings[1].message


def test_road_linked_to_itself_is_closed(tmp_path: Path):
    circle = f'<geometry s="0" x="0" y="0" hdg="0" length="{2 * np.pi * 50}"><arc curvature="0.02"/></geometry>'
    made = read(tmp_path, road(circle, length=2 * np.pi * 50))
    assert made.closed
    assert made.length == pytest.approx(2 * np.pi * 50, rel=1e-6)
    with pytest.raises(RoadError, match="is closed by its file, open was asked for"):
        read(tmp_path, road(circle, length=2 * np.pi * 50), closed=False)


def test_namespace_and_comments_do_not_matter(tmp_path: Path):
    path = write(tmp_path, road())
    path.write_text(
        path.read_text()
        .replace("<OpenDRIVE>", '<OpenDRIVE xmlns="http://code.asam.net/simulation/standard/opendrive_schema">')
        .replace("<lanes>", "<!-- x --><lanes>")
    )
    assert roads.read(path).length == pytest.approx(100.0)
