"""Maps whose sections, lanes, links and points were mutated give roads or clear errors: no other exception, no warning, no hang, in any command.

Some hundred in every run of the tests, more in the experiments; `python -m tests.roads.formats.test_mutated_maps 10000` for as many as you like.
"""

from __future__ import annotations

import contextlib
import io
import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import roads
from roads import RoadError
from roads.check import check
from roads.gallery.shelf import find

from ...timing import slowness
from .. import samples
from ..mutate_maps import mutants
from ..networks import strips
from ..networks.reachable import CAREFUL, Reach
from ..towns import lanelets, layout, xodr

#: No map may take longer, s of processor time on a machine as fast as those that the bound was chosen on, nor ask for more memory, bytes.
LONGEST, LARGEST = 10.0, 1 << 30
#: So many routes are sought through each, and one of so many goes through the commands too.
ROUTES, COMMANDS = 3, 12
#: At most so many roads of a map are made one by one (`check` makes them all).
MOST = 6


def drive_through(path: Path, rng: np.random.Generator, *, commands: bool) -> int:
    """Whatever a user does with a map; returns how many routes were made.

    Raises:
        RoadError: the map cannot be read.
    """
    network = roads.read_network(path)
    for finding in check(path):
        assert str(finding).isprintable()
    names, ids = list(network.roads), list(network.links)
    made = 0
    for k in rng.permutation(len(names))[:MOST].tolist():
        made += _tried(path, lambda k=k: network.road(names[k])) * 0
    for k in range(ROUTES if ids else 0):
        start, goal = (ids[int(at)] for at in rng.integers(len(ids), size=2))
        made += _tried(path, lambda start=start, goal=goal: network.route(start, goal))
        # and between whole roads, and places about as large as the map
        _tried(path, lambda k=k: network.route(names[k % len(names)], names[-1 - k % len(names)], cost="time"))
        _tried(path, lambda: network.route(*(tuple(place) for place in rng.uniform(-150.0, 250.0, (2, 2)).tolist())))
    if commands:
        start, goal = (ids[0], ids[-1]) if ids else ("0", "1")
        for words in (["check", str(path)], ["info", str(path)], ["route", str(path), "--from", start, "--to", goal]):
            _command(words)
    return made


def _tried(path: Path, make: Callable[[], object]) -> bool:
    try:
        make()
    except RoadError as error:
        _names_the_file(error, path)
        return False
    return True


def _names_the_file(error: RoadError, path: Path) -> None:
    assert str(path) in str(error), error
    assert str(error).isprintable()


def _command(words: list[str]) -> None:
    from energy_mgr.cli.main import main

    out, complaint = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(complaint):
        code = main(["roads", *words])
    assert code in (0, 1, 2), code
    assert "Traceback" not in complaint.getvalue()
    assert "report" not in complaint.getvalue(), complaint.getvalue()


def seeds(folder: Path) -> dict[str, tuple[str, list[bytes]]]:
    """For each kind of map its suffix and good files."""
    towns = [layout.town(np.random.default_rng(seed), 2, 1, dirt=0.1, left_hand=seed == 2) for seed in (1, 2, 3)]
    # one crossing: `check` makes every lanelet a road of its own
    (folder / "crossing.xodr").write_text(xodr.text(layout.town(np.random.default_rng(5), 1, 1, dirt=0.1)))
    reach = Reach(strips.opendrive(folder / "crossing.xodr"), CAREFUL)
    return {
        "town": (".xodr", [xodr.text(town).encode() for town in towns]),
        "gallery": (".xodr", [find(name).read_bytes() for name in ("roundabout", "handling")]),
        "CommonRoad": (".xml", [samples.commonroad(folder, version).read_bytes() for version in ("2018b", "2020a")]),
        "lanelets": (".xml", [lanelets.text(reach, np.random.default_rng(4)).encode()]),
        "Lanelet2": (".osm", [samples.lanelet2(folder, local=local).read_bytes() for local in (True, False)]),
        "SUMO": (".net.xml", [samples.sumo(folder).read_bytes()]),
    }


@contextlib.contextmanager
def bounded_memory(most: int = LARGEST) -> Iterator[None]:
    """What asks for more than `most` bytes beyond what the process holds is refused, instead of taking the machine with it (on Linux)."""
    if not Path("/proc/self/statm").exists():
        yield
        return
    held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (held + most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def attack(name: str, folder: Path, count: int, *, keep: Path | None = None, seed: int = 20261128) -> tuple[int, int, float, list[str]]:
    """Drive through `count` mutants.

    Args:
        name: kind of map, a key of `seeds`.
        folder: where files are written.
        count: how many mutants.
        keep: where to keep those that fail, going on; None ends at the first one.
        seed: of the mutations.

    Returns:
        How many were read, routes made, the longest time in s, and what failed.
    """
    suffix, good = seeds(folder)[name]
    path, bound = folder / f"map{suffix}", LONGEST * slowness()
    read, routes, longest, failed = 0, 0, 0.0, []
    for k, data in enumerate(good):
        rng = np.random.default_rng([seed, k])
        for number, (wounds, mutant) in enumerate(mutants(data, count // len(good), rng)):
            path.write_bytes(mutant)
            start = time.process_time()
            try:
                with bounded_memory():
                    routes += drive_through(path, np.random.default_rng(number), commands=number % COMMANDS == 0)
                read += 1
            except RoadError as error:
                _names_the_file(error, path)
            except Exception as error:
                words = f"{name}, seed {k}, mutant {number} ({wounds}): {type(error).__name__}: {error}"
                if keep is None:
                    raise AssertionError(words) from error
                failed.append(words)
                (keep / f"{name}-{k}-{number}{suffix}").write_bytes(mutant)
            took = time.process_time() - start
            longest = max(longest, took)
            if took > bound:
                words = f"{name}, seed {k}, mutant {number} ({wounds}): {took:.1f} s"
                assert keep is not None, words
                failed.append(words)
                (keep / f"slow-{name}-{k}-{number}{suffix}").write_bytes(mutant)
    return read, routes, longest, failed


NAMES = ["town", "gallery", "CommonRoad", "lanelets", "Lanelet2", "SUMO"]


@pytest.mark.parametrize("name", NAMES)
def test_mutated_maps_give_roads_or_one_error(name: str, tmp_path: Path):
    read, routes, _, _ = attack(name, tmp_path, 40)
    # mutations leave most maps readable, and the routes reach what follows reading
    assert read > 12
    assert routes > 5


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_many_mutated_maps_give_roads_or_one_error(name: str, tmp_path: Path):
    read, _, _, _ = attack(name, tmp_path, 260, seed=17)
    assert read > 100


if __name__ == "__main__":
    warnings.simplefilter("error")
    total = int(sys.argv[1]) if len(sys.argv) > 1 else 2_000
    kept = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(tempfile.mkdtemp())
    kept.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as where:
        for kind in sys.argv[4:] or NAMES:
            begun = time.perf_counter()
            good_ones, made_routes, slowest, wrong = attack(kind, Path(where), total, keep=kept, seed=int(sys.argv[3]) if len(sys.argv) > 3 else 1)
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
            print(
                f"{kind:10}  {total} maps, {good_ones} read, {made_routes} routes, {len(wrong)} failed, slowest {slowest:.2f} s, "
                f"peak {peak / 2**20:.0f} MiB, {time.perf_counter() - begun:.0f} s",
                flush=True,
            )
            for line in wrong:
                print("   ", line[:400])
