"""Lanes as the lanelets of a CommonRoad file, whose borders end as drawn by hand: points twice, last segments that turn aside or back."""

from __future__ import annotations

import numpy as np

from ..networks.reachable import Reach

#: Lengths of the last segment of a border, m; nothing says where it points.
LAST = (0.0, 0.0, 1e-4, 0.01, 0.1, 0.3)


def text(reach: Reach, rng: np.random.Generator, *, dirt: float = 0.5) -> str:
    """All lanes of `reach` worth driving; `dirt` is the share of borders that end badly."""
    # a sliver without width is a lane in OpenDRIVE, two lines of one course are none
    worth = [name for name, strip in reach.real.items() if np.mean(strip.width) > 0.5]
    number = {name: k + 1 for k, name in enumerate(worth)}
    parts = ['<?xml version="1.0"?>', '<commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Town-1">']
    for name in worth:
        strip = reach.real[name]
        after = "".join(f'<successor ref="{number[other.name]}"/>' for other in reach.following(strip) if other.name in number)
        beside = "".join(
            f'<{tag} ref="{number[other]}" drivingDir="same"/>'
            for tag, other in (("adjacentLeft", strip.on_left), ("adjacentRight", strip.on_right))
            if other in number
        )
        # a lane that ends in a point has no direction left to be spoiled
        spoilt = dirt * bool(min(strip.width[0], strip.width[-1]) > 2.0)
        left, right = (_bound(tag, line, rng, spoilt) for tag, line in (("leftBound", strip.left), ("rightBound", strip.right)))
        parts.append(f'<lanelet id="{number[name]}">{left}{right}{after}{beside}</lanelet>')
    return "\n".join([*parts, "</commonRoad>"]) + "\n"


def _bound(tag: str, line: np.ndarray, rng: np.random.Generator, dirt: float) -> str:
    """Every fourth point; then the ends are spoiled, which themselves stay where they are."""
    points = [*line[:-1:4], line[-1]]
    most = 0.1 * float(np.hypot(*(line[-1] - line[0])))
    if rng.random() < dirt:
        points.insert(-1, _near(points[-1], rng, most))
    if rng.random() < 0.5 * dirt:
        points.insert(1, _near(points[0], rng, most))
    rows = "".join(f"<point><x>{float(x)!r}</x><y>{float(y)!r}</y></point>" for x, y in points)
    return f"<{tag}>{rows}</{tag}>\n"


def _near(point: np.ndarray, rng: np.random.Generator, most: float) -> np.ndarray:
    angle = rng.uniform(-np.pi, np.pi)
    return point + min(float(rng.choice(LAST)), most) * np.array([np.cos(angle), np.sin(angle)])
