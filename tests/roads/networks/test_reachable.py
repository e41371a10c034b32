"""The independent search itself, on roads whose answers are plain to see; and that faults of a route are found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import roads

from ..formats.test_opendrive import lane, road, section, write
from . import driven, strips
from .reachable import Judge


def linked(number: int, before: int | None = None, after: int | None = None, width: str = "", kind: str = "driving") -> str:
    ends = "".join(f'<{tag} id="{to}"/>' for tag, to in (("predecessor", before), ("successor", after)) if to is not None)
    return lane(number, width or '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>', kind, more=f"<link>{ends}</link>")


def judged(folder: Path, lanes: str, length: float = 100.0) -> Judge:
    plan = f'<geometry s="0" x="0" y="0" hdg="0" length="{length}"><line/></geometry>'
    return Judge(strips.opendrive(write(folder, road(plan, lanes, length))))


@pytest.mark.parametrize(("length", "answer"), [(11.0, False), (12.0, None), (13.5, True)])
def test_a_change_takes_twelve_metres(tmp_path: Path, length: float, answer: bool | None):
    assert judged(tmp_path, section("", lane(-1) + lane(-2)), length)("1/0/-1", "1/0/-2") is answer


@pytest.mark.parametrize(("length", "answer"), [(21.0, False), (24.0, None), (26.0, True)])
def test_two_changes_take_twice_that(tmp_path: Path, length: float, answer: bool | None):
    assert judged(tmp_path, section("", lane(-1) + lane(-2) + lane(-3)), length)("1/0/-3", "1/0/-1") is answer


def test_a_change_goes_on_across_sections_but_not_where_a_lane_ends(tmp_path: Path):
    both = [linked(-1, -1, -1) + linked(-2, -2, -2)] * 5
    rows = "".join(section("", lanes, s=4.0 * k) for k, lanes in enumerate(both))
    assert judged(tmp_path, rows, 20.0)("1/0/-1", "1/4/-2") is True
    # where the second lane is linked to none, four metres are left at a time
    broken = "".join(section("", linked(-1, -1, -1) + linked(-2), s=4.0 * k) for k in range(5))
    assert judged(tmp_path, broken, 20.0)("1/0/-1", "1/4/-2") is False


def test_sections_of_no_length_lead_on_and_renumber(tmp_path: Path):
    ghost = lane(-1, '<width sOffset="0" a="0" b="0" c="0" d="0"/>', "none")
    rows = section("", linked(-1, after=-2)) + section("", ghost + linked(-2, -1, -1), s=50.0) + section("", linked(-1, -2), s=50.001)
    judge = judged(tmp_path, rows)
    assert judge("1/0/-1", "1/2/-1") is True
    assert judged(tmp_path, rows.replace('<successor id="-2"/>', ""))("1/0/-1", "1/2/-1") is not True


def test_a_lane_that_narrows_is_left_unless_it_is_alone(tmp_path: Path):
    taper = '<width sOffset="0" a="3.5" b="-0.035" c="0" d="0"/>'
    after = section("", linked(-1, -1) + linked(-2, -2), s=100.0)
    judge = judged(tmp_path, section("", linked(-1, after=-1) + linked(-2, after=-2, width=taper)) + after, 200.0)
    # not through its end, but by way of the neighbour, and back over there
    assert not judge.careful.open["1/0/-2"][-1]
    assert judge("1/0/-2", "1/1/-2") is True
    ahead = section("", linked(-1) + linked(-2, -2), s=100.0)
    lost = judged(tmp_path, section("", linked(-1) + linked(-2, after=-2, width=taper)) + ahead, 200.0)
    assert lost("1/0/-2", "1/1/-2") is False
    alone = judged(tmp_path, section("", linked(-1, after=-1, width=taper)) + after, 200.0)
    assert alone("1/0/-1", "1/1/-1") is True


def test_what_lies_between_lanes_parts_them(tmp_path: Path):
    assert judged(tmp_path, section("", lane(-1) + lane(-2, kind="median") + lane(-3)))("1/0/-1", "1/0/-3") is False
    assert judged(tmp_path, section(lane(1), lane(-1)))("1/0/1", "1/0/-1") is False
    assert judged(tmp_path, section(lane(1), lane(-1, kind="bidirectional")))("1/0/1", "1/0/-1~") is True


@pytest.mark.parametrize(("y", "hdg", "answer"), [(2.5, 0.0, True), (3.5, 0.0, False), (0.0, 0.6, True), (0.0, 0.8, False)])
def test_lanes_that_do_not_meet_lead_nowhere(tmp_path: Path, y: float, hdg: float, answer: bool):
    there = f'<geometry s="0" x="100" y="{y}" hdg="{hdg}" length="50"><line/></geometry>'
    # the lane's border on the reference line, so that the turn moves its middle by a metre at most
    first = road(lanes=section("", linked(-1, after=-1)), link='<link><successor elementType="road" elementId="2" contactPoint="start"/></link>')
    path = write(tmp_path, first, road(there, section("", linked(-1, before=-1)), 50.0, identity="2"))
    assert Judge(strips.opendrive(path))("1/0/-1", "2/0/-1") is answer


def test_faults_of_a_route_are_found(tmp_path: Path):
    path = write(tmp_path, road(lanes=section("", lane(-1) + lane(-2))))
    town = driven.opened(path, strips.opendrive(path))
    start, goal = town.strips["1/0/-1"], town.strips["1/0/-2"]
    good = town.network.route("1/0/-1", "1/0/-2")
    assert town.ground.fault(good, start, goal) is None
    assert "ends 3.50 m from" in str(town.ground.fault(town.network.route("1/0/-1", "1/0/-1"), start, goal))
    s = np.linspace(0.0, 100.0, 51)

    def through(y: np.ndarray, half: float = 1.7) -> roads.Road:
        return roads.Road.from_points("x", np.column_stack([s, y]), -half, half)

    eased = -1.75 - 3.5 * np.clip((s - 40.0) / 20.0, 0.0, 1.0)
    assert town.ground.fault(through(eased), start, goal) is None
    assert "border outside" in str(town.ground.fault(through(eased + 3.0 * np.exp(-(((s - 20.0) / 6.0) ** 2))), start, goal))
    assert "within a metre" in str(town.ground.fault(through(np.where(s < 50.0, -1.75, -5.25)), start, goal))
    # the other way along the same lanes
    back = driven.Ground({name: strip_back(strip) for name, strip in town.strips.items()}, Judge(town.strips), 0.0)
    assert "outside" in str(back.fault(good, start, goal))


def strip_back(strip: strips.Strip) -> strips.Strip:
    return replace(strip, left=strip.right[::-1], right=strip.left[::-1])
