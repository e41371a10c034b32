import numpy as np
import pytest

import roads
from roads.gallery.archetypes import ARCHETYPES


@pytest.mark.parametrize("make", ARCHETYPES)
def test_stored_file_is_what_the_builder_makes(make):
    made = make()
    stored = roads.open_road(made.name)
    assert np.max(np.abs(made.reference.position(made.s) - stored.reference.position(stored.s))) < 1e-5
    assert np.allclose(stored.speed_limit, made.speed_limit, atol=1e-6)
    assert np.allclose(stored.height, made.height, atol=1e-5)


def test_archetypes_have_the_features_of_the_published_roads():
    commute, rural, descent = (roads.open_road(name) for name in ("commute", "rural", "descent"))
    assert [round(road.length) for road in (commute, rural, descent)] == [2500, 3000, 3000]
    assert np.ptp(commute.height) == 0.0
    assert 20.0 < np.ptp(rural.height) <= 40.0
    assert descent.height[0] - descent.height[-1] == pytest.approx(120.0, abs=1e-6)
    # integral of squared curvature of the published descent, calibrated in the specification to about 0.72 1/m over 2 km
    assert 0.5 < descent.lane_centre().squared_curvature() < 0.9
