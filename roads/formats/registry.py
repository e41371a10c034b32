"""Which module reads which file: by suffix, and where a suffix is shared, by what the file says of itself."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import RoadError

if TYPE_CHECKING:
    from os import PathLike

    from ..conditioning.wish import Wish
    from ..networks.network import Network
    from ..networks.routing import Cost, Place
    from ..road import Road

#: Suffixes of files that hold one road, and of files that hold a network.
ROADS = (".csv", ".txt", ".mat", ".gpx", ".geojson", ".json")
NETWORKS = (".xodr", ".xml", ".osm")
WRITERS = (".xodr", ".csv", ".geojson")


def read(
    path: str | PathLike[str],
    *,
    closed: bool | None = None,
    width: float | None = None,
    lane: float | None = None,
    road: str | None = None,
    start: Place | None = None,
    goal: Place | None = None,
    cost: Cost = "length",
    raw: bool = False,
    accuracy: float | tuple[float, float] | None = None,
    leg: int | None = None,
) -> Road:
    """Read a road file.

    Args:
        path: track CSV, edges CSV, cones, path table (.csv, .mat), GPX, GeoJSON, OpenDRIVE, CommonRoad, Lanelet2, SUMO.
        closed: True for a circuit, False for an open road, None to let the file (or the gap between its ends) tell.
        width: width of the road, m, for files that hold a line without borders.
        lane: width of the lane about the line, m, for path tables; without any width these get one lane of 3.5 m.
        road: id of one road of a network.
        start: where a route through a network begins: a position (x, y) in m, or the id of a road or lane.
        goal: where it ends.
        cost: what the route is to have least of; see `Network.route`.
        raw: take a recorded line (GPX, GeoJSON, path table) as it is, and not smoothed.
        accuracy: root mean square distance in m of recorded places from the true line, or of places and of heights; None: found from the recording.
        leg: which of the ways to read of a recorded drive that turns back on its own line or breaks off, from 1; None: the longest.

    Raises:
        RoadError: the file is missing, of unknown format or wrong inside, or an argument is missing; the message says where.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    plain = not raw and accuracy is None and leg is None
    if suffix in NETWORKS:
        if width is not None or lane is not None or not plain:
            raise RoadError(f"{path}: holds lanes with borders, leave width, lane, raw, accuracy and leg out, which are for files without")
        return _from_network(read_network(path), closed, road, start, goal, cost)
    if not (road is None and start is None and goal is None):
        raise RoadError(f"{path}: holds one road, a road's id or start and goal are for networks ({', '.join(NETWORKS)})")
    return _one_road(path, suffix, closed=closed, width=width, lane=lane, wish=None if plain else _wish(path, raw, accuracy, leg))


def _wish(path: Path, raw: bool, accuracy: float | tuple[float, float] | None, leg: int | None) -> Wish:
    from ..conditioning.wish import Wish

    plane, height = accuracy if isinstance(accuracy, tuple) else (accuracy, None)
    try:
        return Wish(raw, plane, height, leg)
    except RoadError as error:
        raise RoadError(f"{path}: {error}") from None


def read_network(path: str | PathLike[str]) -> Network:
    """Read a file that holds a network: OpenDRIVE (.xodr), CommonRoad (.xml), SUMO (.net.xml), Lanelet2 (.osm).

    Raises:
        RoadError: the file is missing, of another format or wrong inside.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".xodr":
        from .opendrive.reader import read_network as read_it
    elif suffix == ".osm":
        from .lanelet2 import read_network as read_it
    elif path.name.lower().endswith(".net.xml"):
        from .sumo import read_network as read_it
    elif suffix == ".xml":
        read_it = _by_root(path)
    else:
        raise RoadError(f"{path}: unknown network format {suffix!r}, expected one of {', '.join(NETWORKS)}")
    return read_it(path)


def _by_root(path: Path) -> Any:
    from .text import read_bytes

    head = read_bytes(path)[:4000]
    if b"<OpenDRIVE" in head:
        from .opendrive.reader import read_network as read_it
    elif b"<net" in head:
        from .sumo import read_network as read_it
    else:
        from .commonroad import read_network as read_it
    return read_it


def write(road: Road, path: str | PathLike[str]) -> None:
    """Write `road` in the format of the suffix (.xodr, .csv, .geojson), whole or not at all.

    Raises:
        RoadError: unknown format, or a road that the format cannot hold.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".csv":
        from .tables.track_csv import write as write_it
    elif suffix == ".xodr":
        from .opendrive.export import write as write_it
    elif suffix == ".geojson":
        from .centre_line import write_geojson as write_it
    else:
        raise RoadError(f"{path}: cannot write format {suffix!r}, expected one of {', '.join(WRITERS)}")
    write_it(road, path)


def not_kept(road: Road, path: str | PathLike[str]) -> list[str]:
    """What `road` has and the format of `path` does not hold, in words."""
    found = [f"columns {', '.join(road.columns)}"] if road.columns else []
    if Path(path).suffix.lower() == ".xodr" and road.drive is not None:
        found.append("the lane to drive (a reader finds it anew)")
    if Path(path).suffix.lower() == ".csv":
        from .tables.track_csv import drives_another_lane

        found += ["the lane to drive (a reader drives the middle between the edges)"] if drives_another_lane(road) else []
        found += ["latitude and longitude of the origin"] if road.origin is not None else []
    return found


def _one_road(path: Path, suffix: str, *, closed: bool | None, width: float | None, lane: float | None, wish: Wish | None) -> Road:
    if suffix in (".gpx", ".geojson", ".json"):
        if lane is not None:
            raise RoadError(f"{path}: holds a line, give width alone; lane is for path tables")
        if suffix == ".gpx":
            from .gpx import read as read_line
        else:
            from .centre_line import read_geojson as read_line
        return read_line(path, closed=closed, width=width, wish=wish)
    if suffix == ".mat":
        from .tables.path_table import read as read_path

        return read_path(path, closed=closed, lane=lane, width=width, wish=wish)
    if suffix in (".csv", ".txt"):
        return _from_table(path, closed=closed, width=width, lane=lane, wish=wish)
    raise RoadError(f"{path}: unknown road format {suffix!r}, expected one of {', '.join(ROADS + NETWORKS)}")


def _from_table(path: Path, *, closed: bool | None, width: float | None, lane: float | None, wish: Wish | None) -> Road:
    """A header tells cones, edges, paths and tracks apart; without one, four columns and no widths asked for mean a track."""
    from .tables import cones, edges_csv, path_table, track_csv
    from .tables.table import read_rows

    rows = read_rows(path)
    if (columns := cones.columns_of(rows)) is not None:
        if width is not None or lane is not None or wish is not None:
            raise RoadError(f"{path}: cones are the edges, leave width, lane, raw, accuracy and leg out, which are for files without borders")
        return cones.of_rows(rows, columns, closed=closed)
    table = rows.table()
    if table.names and edges_csv.columns_of(table.names) is not None:
        if wish is not None:
            raise RoadError(f"{path}: holds edges, leave raw, accuracy and leg out, which are for files without borders")
        return edges_csv.of_table(table, closed=closed)
    count = table.rows.shape[1]
    if table.names:
        # a line with whatever beside it, but not widths: these are a track's, perhaps misspelled
        is_path = path_table.names_a_line(table.names) and not any(name.startswith("w") for name in table.names)
    else:
        is_path = lane is not None or width is not None or count == 2 or 5 <= count <= 7
    if is_path:
        return path_table.of_table(table, closed=closed, lane=lane, width=width, wish=wish)
    if width is not None or lane is not None or wish is not None:
        raise RoadError(f"{path}: a track holds its widths, leave width, lane, raw, accuracy and leg out, which are for files without borders")
    return track_csv.of_table(table, closed=closed)


def _from_network(network: Network, closed: bool | None, road: str | None, start: Place | None, goal: Place | None, cost: Cost) -> Road:
    if start is not None or goal is not None:
        if road is not None or start is None or goal is None:
            raise RoadError(f"{network.path}: give either a road's id or both start and goal")
        made = network.route(start, goal, cost=cost)
    elif road is not None:
        made = network.road(road)
    elif len(network.roads) == 1:
        made = network.road(network.roads[0])
    else:
        longest = sorted(network.roads, key=lambda name: -network.lengths[name])
        shown = ", ".join(f"{name} ({network.lengths[name]:.0f} m)" for name in longest[:8])
        raise RoadError(f"{network.path}: holds {len(longest)} roads, give the id of one or start and goal of a route; the longest: {shown}")
    if closed is not None and closed != made.closed:
        raise RoadError(
            f"{network.path}: {made.name} is {'closed' if made.closed else 'open'} by its file, {'closed' if closed else 'open'} was asked for"
        )
    return made
