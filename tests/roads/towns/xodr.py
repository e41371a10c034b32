"""A town as the text of an OpenDRIVE file."""

from __future__ import annotations

from .curves import Element
from .records import End, Lane, Street, Town, Width


def text(town: Town) -> str:
    sign = -1.0 if town.left_hand else 1.0
    parts = ['<?xml version="1.0"?>', "<OpenDRIVE>", f'<header revMajor="1" revMinor="6" name="{town.name}"/>']
    parts += [_road(road, sign) for road in town.roads.values()]
    for junction in town.junctions:
        rows = []
        for k, one in enumerate(junction.connections):
            lanes = "".join(f'<laneLink from="{_number(a, sign)}" to="{_number(b, sign)}"/>' for a, b in one.lanes)
            rows.append(
                f'<connection id="{k}" incomingRoad="{one.incoming}" connectingRoad="{one.road}" contactPoint="{one.contact}">{lanes}</connection>'
            )
        parts.append(f'<junction id="{junction.id}" name="">' + "\n".join(rows) + "</junction>")
    return "\n".join([*parts, "</OpenDRIVE>"]) + "\n"


def _number(lane: int, sign: float) -> int:
    return int(sign) * lane


def _road(road: Street, sign: float) -> str:
    ends = _end("predecessor", road.before) + _end("successor", road.after)
    rule = ' rule="LHT"' if sign < 0 else ""
    plan, s = [], 0.0
    for element in road.elements:
        plan.append(_geometry(element, s, sign))
        s += element.length
    low, high = road.heights
    c, d = (3 * (high - low) / s**2, -2 * (high - low) / s**3) if low != high else (0.0, 0.0)
    height = f'<elevationProfile><elevation s="0" a="{float(low)!r}" b="0" c="{float(c)!r}" d="{float(d)!r}"/></elevationProfile>'
    offsets = "".join(_cubic("laneOffset", "s", row, sign) for row in road.offsets)
    sections = "\n".join(_section(section.s, section.left, section.right, sign) for section in road.sections)
    return (
        f'<road id="{road.id}" name="" length="{float(s)!r}" junction="{road.junction}"{rule}><link>{ends}</link>{road.more}\n'
        f"<planView>{''.join(plan)}</planView>{height}\n<lanes>{offsets}{sections}</lanes></road>"
    )


def _end(tag: str, end: End | None) -> str:
    if end is None:
        return ""
    contact = f' contactPoint="{end.contact}"' if end.contact else ""
    return f'<{tag} elementType="{end.kind}" elementId="{end.id}"{contact}/>'


def _geometry(element: Element, s: float, sign: float) -> str:
    numbers = element.numbers
    if element.kind == "line":
        shape = "<line/>"
    elif element.kind == "arc":
        shape = f'<arc curvature="{float(sign * numbers[0])!r}"/>'
    elif element.kind == "spiral":
        shape = f'<spiral curvStart="{float(sign * numbers[0])!r}" curvEnd="{float(sign * numbers[1])!r}"/>'
    elif element.kind == "poly3":
        shape = "<poly3 " + " ".join(f'{key}="{float(sign * value)!r}"' for key, value in zip("abcd", numbers, strict=True)) + "/>"
    else:
        u = " ".join(f'{key}U="{float(value)!r}"' for key, value in zip("abcd", numbers[:4], strict=True))
        v = " ".join(f'{key}V="{float(sign * value)!r}"' for key, value in zip("abcd", numbers[4:8], strict=True))
        shape = f'<paramPoly3 pRange="{"arcLength" if numbers[8] else "normalized"}" {u} {v}/>'
    x, y, hdg = element.start.x, sign * element.start.y, sign * element.start.hdg
    return (
        f'<geometry s="{float(s)!r}" x="{float(x)!r}" y="{float(y)!r}" hdg="{float(hdg)!r}" length="{float(element.length)!r}">{shape}</geometry>\n'
    )


def _cubic(tag: str, key: str, row: Width, sign: float = 1.0) -> str:
    s, *numbers = row
    return f'<{tag} {key}="{float(s)!r}" ' + " ".join(f'{name}="{float(sign * value)!r}"' for name, value in zip("abcd", numbers, strict=True)) + "/>"


def _section(s: float, left: list[Lane], right: list[Lane], sign: float) -> str:
    sides = {1: left, -1: right}
    made = {side: [_lane(side * (k + 1), lane, sign) for k, lane in enumerate(lanes)] for side, lanes in sides.items()}
    if sign < 0:
        made = {1: made[-1], -1: made[1]}
    one = "<left>" + "".join(made[1][::-1]) + "</left>" if made[1] else ""
    other = "<right>" + "".join(made[-1]) + "</right>" if made[-1] else ""
    return f'<laneSection s="{float(s)!r}">{one}<center><lane id="0" type="none"/></center>{other}</laneSection>'


def _lane(number: int, lane: Lane, sign: float) -> str:
    ends = "".join(f'<{tag} id="{_number(k, sign)}"/>' for tag, ids in (("predecessor", lane.before), ("successor", lane.after)) for k in ids)
    widths = "".join(_cubic("width", "sOffset", row) for row in lane.widths)
    return f'<lane id="{_number(number, sign)}" type="{lane.kind}"><link>{ends}</link>{widths}{lane.more}</lane>\n'
