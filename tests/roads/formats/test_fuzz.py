"""Damaged files give a road or one clear error: never another exception, never a warning, never a hang, never a gigabyte.

A few hundred per format in every run of the tests; `python -m tests.roads.formats.test_fuzz 10000` for as many as you like.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import roads
from roads import RoadError
from roads.gallery.shelf import find

from ...timing import slowness
from .. import samples
from ..mutate import mutants

#: No file may take longer, s of processor time on a machine as fast as those that the bound was chosen on, nor the whole process grow beyond, bytes.
#: (A file of the tests takes milliseconds; the limit is the promise made.)
LONGEST, LARGEST = 5.0, 1 << 30


def look_through(path: Path) -> None:
    """Read a network, and make every lane and road of it and one route."""
    network = roads.read_network(path)
    makers: list[Callable[[], object]] = [lambda: [link.borders for link in network.links.values()]]
    makers += [lambda name=name: network.road(name) for name in network.roads]
    makers.append(lambda: network.route(network.roads[0], network.roads[-1]))
    for make in makers:
        try:
            make()
        except RoadError as error:
            _check(error, path)


def _check(error: RoadError, path: Path) -> None:
    assert str(path) in str(error), error
    assert str(error).isprintable()


def line(path: Path) -> None:
    roads.read(path, width=7.0)


def path_table(path: Path) -> None:
    roads.read(path, width=7.0, lane=3.5)


def seeds(folder: Path) -> dict[str, tuple[Callable[[Path], None], str, list[bytes]]]:
    """For each format: what reads it, its suffix, good files."""
    track = folder / "track.csv"
    roads.write(samples.bend().resampled(4.0), track)
    return {
        "OpenDRIVE": (look_through, ".xodr", [find(name).read_bytes() for name in ("handling", "roundabout")]),
        "CommonRoad": (look_through, ".xml", [samples.commonroad(folder, version).read_bytes() for version in ("2018b", "2020a")]),
        "Lanelet2": (look_through, ".osm", [samples.lanelet2(folder, local=local).read_bytes() for local in (True, False)]),
        "SUMO": (look_through, ".net.xml", [samples.sumo(folder).read_bytes()]),
        "GPX": (line, ".gpx", [samples.gpx(folder).read_bytes()]),
        "GeoJSON": (line, ".geojson", [samples.geojson(folder).read_bytes()]),
        "track CSV": (lambda path: roads.read(path) and None, ".csv", [track.read_bytes()]),
        "edges CSV": (lambda path: roads.read(path) and None, ".csv", [samples.edges(folder).read_bytes()]),
        "path CSV": (path_table, ".csv", _path_tables(folder)),
        "cones": (lambda path: roads.read(path) and None, ".csv", [samples.cones(folder).read_bytes()]),
        "path .mat": (path_table, ".mat", [samples.path_mat(folder, kind).read_bytes() for kind in ("vectors", "matrix", "struct")]),
    }


def _path_tables(folder: Path) -> list[bytes]:
    with_header, without = (samples.path_csv(folder, header=header).read_bytes() for header in (True, False))
    return [with_header, without, with_header.replace(b".", b",")]


def attack(name: str, folder: Path, count: int) -> tuple[int, float]:
    """Read `count` damaged files; returns how many of them made a road, and the longest time, s."""
    read, suffix, good = seeds(folder)[name]
    for data in good:
        (folder / f"good{suffix}").write_bytes(data)
        read(folder / f"good{suffix}")
    bound = LONGEST * slowness()
    path, made, longest = folder / f"bad{suffix}", 0, 0.0
    for k, data in enumerate(good):
        share = count // len(good)
        for number, mutant in enumerate(mutants(data, share, np.random.default_rng([20261122, k]))):
            path.write_bytes(mutant)
            start = time.process_time()
            try:
                read(path)
                made += 1
            except RoadError as error:
                _check(error, path)
            except Exception as error:
                raise AssertionError(f"{name}, seed {k}, mutant {number}: {type(error).__name__}: {error}") from error
            longest = max(longest, time.process_time() - start)
            assert longest < bound, f"{name}, seed {k}, mutant {number}: {longest:.1f} s"
    return made, longest


@pytest.mark.parametrize(
    "name", ["OpenDRIVE", "CommonRoad", "Lanelet2", "SUMO", "GPX", "GeoJSON", "track CSV", "edges CSV", "path CSV", "cones", "path .mat"]
)
def test_damaged_files_give_a_road_or_one_error(name: str, tmp_path: Path):
    made, _ = attack(name, tmp_path, 300)
    # the mutator reaches the inside of the reader: some files are still good
    assert made >= 5


if __name__ == "__main__":
    warnings.simplefilter("error")
    total = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    with tempfile.TemporaryDirectory() as where:
        for format_name in sys.argv[2:] or list(seeds(Path(where))):
            begun = time.perf_counter()
            good_ones, slowest = attack(format_name, Path(where), total)
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
            assert peak < LARGEST, f"{format_name}: {peak / 2**20:.0f} MiB"
            print(
                f"{format_name:10}  {total} files, {good_ones} roads, {total - good_ones} errors, slowest {slowest:.2f} s, "
                f"peak {peak / 2**20:.0f} MiB, {time.perf_counter() - begun:.0f} s",
                flush=True,
            )
