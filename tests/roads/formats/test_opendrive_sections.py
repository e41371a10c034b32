"""OpenDRIVE roads of several lane sections: what ends with the section before, and what counts from the start of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import roads

from .test_opendrive import lane, read, road, section, write


def test_a_section_ends_with_the_lane_offset_of_its_own_stretch(tmp_path: Path):
    """At 50 m one lane ends on the right, and the offset steps by its width, so that the other lane goes straight on."""
    offsets = '<laneOffset s="0" a="3.5" b="0" c="0" d="0"/><laneOffset s="50" a="0" b="0" c="0" d="0"/>'
    lanes = offsets + section("", lane(-1) + lane(-2)) + section("", lane(-1), s=50.0)
    links = roads.read_network(write(tmp_path, road(lanes=lanes))).links
    for name, height in (("1/0/-1", (3.5, 0.0)), ("1/0/-2", (0.0, -3.5)), ("1/1/-1", (0.0, -3.5))):
        for border, y in zip(links[name].borders, height, strict=True):
            # the road is the x axis: every place of a border lies as far left as the file says, those at the end of the section as well
            assert np.allclose(border[:, 1], y, atol=1e-9)


def test_friction_of_a_lane_counts_from_the_start_of_its_section(tmp_path: Path):
    wet = '<material sOffset="10" friction="0.5"/>'
    made = read(tmp_path, road(lanes=section("", lane(-1)) + section("", lane(-1, more=wet), s=50.0)))
    # from 60 m on, but for the interval in which the value is led over
    assert made.friction_at(np.array([0.0, 11.0, 49.0, 51.0])) == pytest.approx(1.0)
    assert made.friction_at(np.array([60.0, 80.0, 100.0])) == pytest.approx(0.5)
