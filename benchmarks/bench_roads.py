"""Road files beside pyxodr, nearest points beside a KD-tree of dense samples, smoothing by the number of points.

The town is made here: `TILES` copies of a real junction network where the shared data are there (12 MB), else of the shipped roundabout.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest

import roads
from roads.conditioning.bounded import smooth_points
from roads.gallery.shelf import find

DATA = Path(os.environ.get("ENERGY_MGR_DATA", Path(__file__).parents[2] / "shared" / "data")) / "roads" / "opendrive"
TILES = 24
NUMBERED = re.compile(r'((?:\bid|incomingRoad|connectingRoad|elementId|signalId|junction)=")([^"]+)(")')


def tiled(source: Path, out: Path) -> Path:
    """`source` side by side with itself, ids made unique."""
    text = source.read_text()
    head, body = text[: text.index("<road ")], text[text.index("<road ") : text.rindex("</OpenDRIVE>")]
    parts = []
    for tile in range(TILES):
        x, y = 2000.0 * (tile % 6), 2000.0 * (tile // 6)

        def moved(match: re.Match[str], x: float = x, y: float = y) -> str:
            return f'{match[1]}x="{float(match[2]) + x!r}" y="{float(match[3]) + y!r}"'

        def numbered(match: re.Match[str], tile: int = tile) -> str:
            is_lane = re.fullmatch(r"-?\d", match[2]) and match[1].startswith("id")
            return match[0] if is_lane or match[2] == "-1" else f"{match[1]}{match[2]}t{tile}{match[3]}"

        tile_text = re.sub(r'(<geometry [^>]*?)x="([^"]+)" y="([^"]+)"', moved, body)
        parts.append(NUMBERED.sub(numbered, tile_text))
    out.write_text(head + "".join(parts) + "</OpenDRIVE>\n")
    return out


@pytest.fixture(scope="module")
def town(tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = DATA / "multi_intersections.xodr"
    return tiled(source if source.exists() else find("roundabout"), tmp_path_factory.mktemp("town") / "town.xodr")


def read_all(path: Path) -> int:
    """Read a network and make the borders and the centre of every lane."""
    network = roads.read_network(path)
    return sum(len(link.borders[0]) + len(link.centre) > 0 for link in network.links.values())


def read_pyxodr(path: Path, resolution: float) -> int:
    """The same by pyxodr."""
    from pyxodr.road_objects.network import RoadNetwork

    lanes = 0
    for road in RoadNetwork(str(path), resolution=resolution).get_roads():
        for section in road.lane_sections:
            for lane in section.lanes:
                lanes += len(lane.boundary_line) + len(lane.centre_line) > 0
    return lanes


def group(path: Path, what: str) -> str:
    return f"{what}, {path.stat().st_size / 1e6:.1f} MB"


def bench_town_ours(benchmark, town):
    benchmark.group = group(town, "OpenDRIVE town")
    lanes = benchmark.pedantic(read_all, (town,), rounds=5, warmup_rounds=1)
    benchmark.extra_info.update(method="ours, borders within 0.1 mm", ours=True, found=f"{lanes} lanes for cars")


def bench_town_pyxodr(benchmark, town):
    benchmark.group = group(town, "OpenDRIVE town")
    lanes = benchmark.pedantic(read_pyxodr, (town, 0.1), rounds=1)
    benchmark.extra_info.update(method="pyxodr at 0.1 m, borders within 53 mm", found=f"{lanes} lanes of all kinds")


@pytest.fixture(scope="module")
def junctions() -> Path:
    source = DATA / "multi_intersections.xodr"
    return source if source.exists() else find("roundabout")


def bench_junctions_ours(benchmark, junctions):
    benchmark.group = group(junctions, "OpenDRIVE junctions")
    lanes = benchmark.pedantic(read_all, (junctions,), rounds=20, warmup_rounds=2)
    benchmark.extra_info.update(method="ours, borders within 0.1 mm", ours=True, found=f"{lanes} lanes for cars")


@pytest.mark.parametrize(("resolution", "within"), [(0.1, "53 mm"), (0.01, "5 mm")])
def bench_junctions_pyxodr(benchmark, junctions, resolution, within):
    benchmark.group = group(junctions, "OpenDRIVE junctions")
    lanes = benchmark.pedantic(read_pyxodr, (junctions, resolution), rounds=3)
    benchmark.extra_info.update(method=f"pyxodr at {resolution:g} m, borders within {within}", found=f"{lanes} lanes of all kinds")


def bench_centre_line(benchmark, tmp_path_factory):
    benchmark.group = "track CSV of 50,000 points"
    x = 3.0 * np.arange(50_000)
    points = np.column_stack([x, 80.0 * np.sin(x / 300.0), np.full(len(x), 3.5), np.full(len(x), 3.5)])
    path = tmp_path_factory.mktemp("line") / "long.csv"
    np.savetxt(path, points, delimiter=",", header="x_m,y_m,w_tr_right_m,w_tr_left_m", fmt="%.4f")
    road = benchmark.pedantic(roads.read, (path,), rounds=5, warmup_rounds=1)
    benchmark.extra_info.update(method="ours", ours=True, found=f"{road.length / 1000.0:.0f} km")


@pytest.fixture(scope="module")
def beside() -> tuple[roads.PlanarCurve, np.ndarray]:
    """A road, and a million places along it up to 5 m beside."""
    curve = roads.open_road("rural").reference
    rng = np.random.default_rng(1)
    s = np.sort(rng.uniform(0.0, curve.length, 1_000_000))
    curve.locate(curve.position(s[:1]))
    return curve, curve.position(s) + rng.uniform(-5.0, 5.0, len(s))[:, None] * curve.normal(s)


def bench_locate_ours(benchmark, beside):
    benchmark.group = "nearest places of 1e6 points"
    curve, points = beside
    benchmark.pedantic(curve.locate, (points,), rounds=5, warmup_rounds=1)
    benchmark.extra_info.update(method="ours, exact", ours=True, found="stations within 1e-9 m")


def bench_locate_scrambled(benchmark, beside):
    benchmark.group = "nearest places of 1e6 points"
    curve, points = beside
    benchmark.pedantic(curve.locate, (np.random.default_rng(2).permutation(points),), rounds=3)
    benchmark.extra_info.update(method="ours, in random order", found="the same")


def bench_locate_tree(benchmark, beside):
    from scipy.spatial import cKDTree

    benchmark.group = "nearest places of 1e6 points"
    curve, points = beside
    tree = cKDTree(curve.position(np.arange(0.0, curve.length, 0.01)))
    benchmark.pedantic(tree.query, (points,), {"workers": -1}, rounds=3)
    benchmark.extra_info.update(method="SciPy's KD-tree of samples 1 cm apart, all cores", found="stations within 5 mm")


def bench_tracker(benchmark, beside):
    benchmark.group = "nearest place, one call of a controller"
    curve, points = beside
    tracker = roads.Tracker(curve)
    places = points[::100].tolist()

    def follow() -> None:
        for x, y in places:
            tracker(x, y)

    benchmark.pedantic(follow, rounds=10, warmup_rounds=1)
    benchmark.extra_info.update(method="ours, 10,000 calls", ours=True, found=f"{tracker.reacquired} searches over all")


@pytest.mark.parametrize("count", [2300, 23_000])
def bench_smoothing(benchmark, count):
    benchmark.group = f"smoothing {count} points within 0.3 m"
    curve = roads.open_road("handling").reference
    rng = np.random.default_rng(3)
    s = np.linspace(0.0, curve.length, count, endpoint=False)
    # the same road at 3 m between points, however many there are
    scale = 3.0 * count / curve.length
    noisy = scale * curve.position(s) + rng.normal(0.0, 0.1, (count, 2))
    made = benchmark.pedantic(smooth_points, (noisy, 0.3), {"closed": True}, rounds=5, warmup_rounds=1)
    off = float(np.max(np.hypot(*(made - noisy).T)))
    assert off <= 0.3
    benchmark.extra_info.update(method="ours", ours=True, found=f"largest deviation {off:.3f} m")
