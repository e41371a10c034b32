"""Small files of every format, made here: a left bend of 40 m radius between two straights, 7 m wide, two lanes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from roads import Road, RoadBuilder

#: Where the geographic samples lie: latitude and longitude of (0, 0).
ORIGIN = (48.08, 11.28)


def bend() -> Road:
    return RoadBuilder("bend").limit(50 / 3.6).straight(60).bend(40, np.radians(80), 15).straight(50).build(height=lambda s: 500.0 + 0.02 * s)


def points(count: int = 41) -> tuple[Road, np.ndarray, np.ndarray, np.ndarray]:
    """The road, and places (n, 2) of its reference, left and right edge."""
    road = bend()
    s = np.linspace(0.0, road.length, count)
    place, normal = road.reference.position(s), road.reference.normal(s)
    return road, place, place + 3.5 * normal, place - 3.5 * normal


def degrees(place: np.ndarray) -> np.ndarray:
    """Longitude and latitude (n, 2)."""
    from pyproj import Proj

    projection = Proj(proj="tmerc", lat_0=ORIGIN[0], lon_0=ORIGIN[1], k=1.0, ellps="WGS84")
    return np.column_stack(projection(place[:, 0], place[:, 1], inverse=True))


def gpx(folder: Path) -> Path:
    _, place, _, _ = points()
    rows = "\n".join(f'      <trkpt lat="{lat:.9f}" lon="{lon:.9f}"><ele>{500 + k}</ele></trkpt>' for k, (lon, lat) in enumerate(degrees(place)))
    head = '<?xml version="1.0"?>\n<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1">\n  <trk><name>bend</name><trkseg>\n'
    text = head + rows + "\n  </trkseg></trk>\n</gpx>\n"
    return _written(folder / "bend.gpx", text)


def geojson(folder: Path) -> Path:
    _, place, _, _ = points()
    line = {"type": "LineString", "coordinates": [[lon, lat, 500.0] for lon, lat in degrees(place).tolist()]}
    feature = {"type": "Feature", "properties": {"name": "bend"}, "geometry": line}
    return _written(folder / "bend.geojson", json.dumps({"type": "FeatureCollection", "features": [feature]}))


def edges(folder: Path) -> Path:
    _, _, left, right = points()
    rows = "\n".join(",".join(f"{value:.6f}" for value in (*a, *b, 500.0, 500.0)) for a, b in zip(left, right, strict=True))
    return _written(folder / "edges.csv", "# name: bend\nleft_x_m,left_y_m,right_x_m,right_y_m,left_z_m,right_z_m\n" + rows + "\n")


def cones(folder: Path) -> Path:
    _, _, left, right = points()
    rows = [f"{x:.3f},{y:.3f},{word}" for word, line in (("blue", left), ("yellow", right[::2])) for x, y in line]
    return _written(folder / "cones.csv", "x,y,color\n" + "\n".join(rows) + "\n")


def path_columns() -> dict[str, np.ndarray]:
    road, place, _, _ = points()
    s = np.linspace(0.0, road.length, len(place))
    v = 10.0 + 0.02 * s
    t = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (v[1:] + v[:-1]))])
    return {"t": t, "s": s, "x": place[:, 0], "y": place[:, 1], "psi": road.reference.heading(s), "v": v, "kappa": road.reference.curvature(s)}


def path_csv(folder: Path, names: tuple[str, ...] = ("s", "x", "y", "psi", "v", "kappa"), *, header: bool = True) -> Path:
    columns = path_columns()
    rows = "\n".join(";".join(f"{value:.9f}" for value in row) for row in np.column_stack([columns[name] for name in names]))
    head = "# " + "; ".join(f"{name}_{unit}" for name, unit in zip(names, _units(names), strict=True)) + "\n" if header else ""
    return _written(folder / f"path{len(names)}{header}.csv", head + rows + "\n")


def _units(names: tuple[str, ...]) -> list[str]:
    return [{"t": "s", "psi": "rad", "v": "mps", "kappa": "radpm"}.get(name, "m") for name in names]


def path_mat(folder: Path, kind: str = "vectors") -> Path:
    from scipy.io import savemat

    columns = path_columns()
    wanted = {name: columns[name] for name in ("s", "x", "y", "psi", "v", "kappa")}
    content = {"vectors": wanted, "matrix": {"path": np.column_stack(list(wanted.values()))}, "struct": {"path": wanted}}[kind]
    savemat(folder / f"{kind}.mat", content)
    return folder / f"{kind}.mat"


def lanelet2(folder: Path, *, local: bool = True) -> Path:
    """Two lanelets one after the other, and one beside the first that leads the other way; one way is drawn backwards."""
    _, middle, left, right = points()
    half = len(middle) // 2
    nodes: list[str] = []
    ids: dict[tuple[str, int], int] = {}
    for line, name in ((left, "l"), (middle, "m"), (right, "r")):
        for k, (place, (lon, lat)) in enumerate(zip(line, degrees(line), strict=True)):
            ids[name, k] = len(nodes) + 1
            tags = f'<tag k="local_x" v="{place[0]:.6f}"/><tag k="local_y" v="{place[1]:.6f}"/>' if local else ""
            nodes.append(f'  <node id="{ids[name, k]}" lat="{lat:.11f}" lon="{lon:.11f}">{tags}<tag k="ele" v="500"/></node>')

    def way(number: int, name: str, order: range) -> str:
        return f'  <way id="{number}">' + "".join(f'<nd ref="{ids[name, k]}"/>' for k in order) + '<tag k="type" v="line_thin"/></way>'

    first, second = range(half + 1), range(half, len(middle))
    ways = [way(1001, "m", first), way(1002, "m", second), way(1003, "r", first[::-1]), way(1004, "r", second), way(1005, "l", first)]

    def lanelet(number: int, left_way: int, right_way: int, rule: str = "") -> str:
        tags = '<tag k="type" v="lanelet"/><tag k="subtype" v="road"/><tag k="one_way" v="yes"/>'
        members = f'<member type="way" ref="{left_way}" role="left"/><member type="way" ref="{right_way}" role="right"/>'
        return f'  <relation id="{number}">{members}{rule}{tags}</relation>'

    rule = '<member type="relation" ref="3000" role="regulatory_element"/>'
    relations = [lanelet(2001, 1001, 1003, rule), lanelet(2002, 1002, 1004), lanelet(2003, 1001, 1005)]
    relations.append(
        '  <relation id="3000"><tag k="type" v="regulatory_element"/><tag k="subtype" v="speed_limit"/><tag k="sign_type" v="de274-50"/></relation>'
    )
    text = '<?xml version="1.0"?>\n<osm version="0.6">\n' + "\n".join([*nodes, *ways, *relations]) + "\n</osm>\n"
    return _written(folder / f"map{local}.osm", text)


def sumo(folder: Path) -> Path:
    """Two edges of two lanes and the junction between them."""
    text = """<?xml version="1.0" encoding="UTF-8"?>
<net version="1.16">
    <location netOffset="0.00,0.00" convBoundary="0,0,200,100" origBoundary="0,0,200,100" projParameter="!"/>
    <edge id=":J_0" function="internal">
        <lane id=":J_0_0" index="0" speed="10.00" length="14.2" shape="100.00,-4.80 104.00,-4.50 108.00,-3.00 111.00,0.00 112.50,4.00 112.80,8.00"/>
    </edge>
    <edge id=":J_w0" function="walkingarea"><lane id=":J_w0_0" index="0" allow="pedestrian" speed="2" length="3" shape="1,1 2,2"/></edge>
    <edge id="a" from="S" to="J" priority="1">
        <lane id="a_0" index="0" speed="13.89" length="100.00" shape="0.00,-4.80 100.00,-4.80"/>
        <lane id="a_1" index="1" speed="13.89" length="100.00" shape="0.00,-1.60 100.00,-1.60"/>
    </edge>
    <edge id="b" from="J" to="E" priority="1">
        <lane id="b_0" index="0" speed="8.33" length="92.00" width="3.50" shape="112.80,8.00,0.0 112.80,100.00,4.0"/>
        <lane id="b_1" index="1" speed="8.33" length="92.00" disallow="passenger" shape="109.45,8.00 109.45,100.00"/>
    </edge>
    <connection from="a" to="b" fromLane="0" toLane="0" via=":J_0_0" dir="l" state="M"/>
    <connection from=":J_0" to="b" fromLane="0" toLane="0" dir="l" state="M"/>
</net>
"""
    return _written(folder / "small.net.xml", text)


def commonroad(folder: Path, version: str = "2020a") -> Path:
    """Two lanelets side by side with a limit, and one after the right one."""
    _, middle, left, right = points(21)

    def bound(name: str, line: np.ndarray) -> str:
        return f"<{name}>" + "".join(f"<point><x>{x:.6f}</x><y>{y:.6f}</y></point>\n" for x, y in line) + f"</{name}>"

    def lanelet(number: int, left_line: np.ndarray, right_line: np.ndarray, more: str) -> str:
        return f'  <lanelet id="{number}">\n{bound("leftBound", left_line)}{bound("rightBound", right_line)}{more}</lanelet>\n'

    limit = '<trafficSignRef ref="50"/>' if version == "2020a" else "<speedLimit>13.5</speedLimit>"
    body = lanelet(1, middle[:11], right[:11], f'<successor ref="2"/><adjacentLeft ref="3" drivingDir="opposite"/>{limit}')
    body += lanelet(2, middle[10:], right[10:], '<predecessor ref="1"/>')
    body += lanelet(3, middle[10::-1], left[10::-1], '<adjacentLeft ref="1" drivingDir="opposite"/>')
    sign = "<trafficSignElement><trafficSignID>274</trafficSignID><additionalValue>13.5</additionalValue></trafficSignElement>"
    body += f'  <trafficSign id="50">{sign}</trafficSign>\n' if version == "2020a" else ""
    text = f'<?xml version="1.0"?>\n<commonRoad commonRoadVersion="{version}" benchmarkID="ZAM_Bend-1">\n{body}</commonRoad>\n'
    return _written(folder / f"bend{version}.xml", text)


def _written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path
