"""Lanes side by side of files whose lanes are told one by one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import roads

#: Four lanes of 3 m on the x axis, from south to north: number, whether it leads east.
LANES = ((1, True), (2, True), (3, False), (4, False))


def _bound(name: str, y: float, east: bool) -> str:
    x = np.linspace(0.0, 100.0, 11)[:: 1 if east else -1]
    return f"<{name}>" + "".join(f"<point><x>{place:.3f}</x><y>{y:.3f}</y></point>" for place in x) + f"</{name}>"


def _two_each_way(folder: Path) -> Path:
    body = ""
    for number, east in LANES:
        south, north = 3.0 * (number - 1), 3.0 * number
        left, right = (north, south) if east else (south, north)
        body += f'<lanelet id="{number}">{_bound("leftBound", left, east)}{_bound("rightBound", right, east)}'
        for side, other in (("Left", number + 1 if east else number - 1), ("Right", number - 1 if east else number + 1)):
            if other in dict(LANES):
                way = "same" if dict(LANES)[other] == east else "opposite"
                body += f'<adjacent{side} ref="{other}" drivingDir="{way}"/>'
        body += "</lanelet>"
    path = folder / "two.xml"
    path.write_text(f'<?xml version="1.0"?>\n<commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Two-1">{body}</commonRoad>\n')
    return path


def test_lanes_beyond_an_oncoming_one_are_seen_in_order_and_with_their_direction(tmp_path: Path):
    network = roads.read_network(_two_each_way(tmp_path))
    for number, east in LANES:
        link = network.links[str(number)]
        # from right to left as the lane itself is driven
        order = [other for other, _ in LANES] if east else [other for other, _ in LANES[::-1]]
        assert link.beside == tuple(str(other) for other in order)
        assert link.against == tuple(dict(LANES)[other] != east for other in order)
    made = network.route("1", "1")
    # the corridor of the lanes that lead east ends where the oncoming ones begin, 4.5 m to the left of the middle of lane 1
    assert [lane.direction for lane in made.lanes] == [1, 1, -1, -1]
    assert np.allclose(made.corridor("own").borders(np.array([50.0])), [[-1.5], [4.5]], atol=1e-6)
