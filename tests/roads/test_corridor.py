import numpy as np
import pytest

from roads import Narrowing, Road, RoadBuilder, RoadError


@pytest.fixture(scope="module")
def street() -> Road:
    return RoadBuilder("street").straight(100).build(lanes=((1, -3.0, 3.0),))


@pytest.fixture(scope="module")
def ring() -> Road:
    angle = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    return Road.from_points("ring", 40 * np.column_stack([np.cos(angle), np.sin(angle)]), -4.0, 4.0, closed=True)


def test_narrowing_holds_over_its_whole_stretch_and_nowhere_else(street: Road):
    corridor = street.corridor("road", 0.0).narrowed(Narrowing(20.0, 30.0, right=-1.0), Narrowing(25.0, 40.3, left=1.5))
    s = np.array([0.0, 19.99, 20.0, 24.99, 25.0, 30.0, 30.01, 40.3, 40.31, 100.0])
    right, left = corridor.borders(s)
    assert right.tolist() == pytest.approx([-3, -3, -1, -1, -1, -1, -3, -3, -3, -3])
    assert left.tolist() == pytest.approx([3, 3, 3, 3, 1.5, 1.5, 1.5, 1.5, 3, 3])


@pytest.mark.parametrize(("start", "end"), [(240.0, 10.0), (-11.33, 10.0), (240.0, 261.33), (240.0, 251.2), (250.0, 1.0)])
def test_narrowing_of_a_circuit_may_cross_its_seam(ring: Road, start: float, end: float):
    corridor = ring.corridor("road", 0.0).narrowed(Narrowing(start, end, left=1.0))
    first, length = start % ring.length, ring.length
    span = (end - start) % length
    inside = first + span * np.array([1e-6, 0.3, 0.7, 1 - 1e-6])
    assert np.allclose(corridor.borders(inside)[1], 1.0)
    assert np.allclose(corridor.borders(np.array([first - 0.1, first + span + 0.1]))[1], 4.0)


def test_narrowing_of_a_whole_circuit_is_everywhere(ring: Road):
    assert np.all(ring.corridor("road").narrowed(Narrowing(5.0, 5.0 + 2 * ring.length, right=-1.0)).right == -1.0)


def test_narrowing_never_widens(street: Road):
    corridor = street.corridor("road").narrowed(Narrowing(20.0, 30.0, right=-9.0, left=9.0))
    assert np.all(corridor.right == -3.0)
    assert np.all(corridor.left == 3.0)


@pytest.mark.parametrize(("start", "end"), [(30.0, 20.0), (30.0, 30.0), (120.0, 130.0), (-20.0, -10.0)])
def test_narrowing_beside_the_road_is_refused(street: Road, start: float, end: float):
    with pytest.raises(RoadError, match=f"street: narrowing from {start} m to {end} m, expected"):
        street.corridor("road").narrowed(Narrowing(start, end, left=1.0))
    with pytest.raises(RoadError, match="expected finite numbers"):
        Narrowing(float("nan"), 1.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_disc_just_touches_the_border_of_a_bend_that_grows_wider(turn: float, side: float):
    radius, margin, slope = 25.0, 1.0, 0.2
    s = np.linspace(0.0, 1.5 * radius, 121)
    points = radius * np.column_stack([np.sin(s / radius), turn * (1.0 - np.cos(s / radius))])
    wide = 4.0 + slope * (s - 0.75 * radius)
    road = Road.from_points("bend", points, *((-6.0, wide) if side > 0.0 else (-wide, 6.0)))

    def beside(at: np.ndarray, offset: np.ndarray) -> np.ndarray:
        around = radius - turn * offset  # from the centre of the bend
        return np.column_stack([around * np.sin(at / radius), turn * (radius - around * np.cos(at / radius))])

    fine, at = np.linspace(8.0, 30.0, 20_001), np.linspace(13.0, 24.0, 12)
    border = beside(fine, side * np.interp(fine, s, wide))
    discs = beside(at, road.corridor("road", margin).offsets(at)[int(side > 0.0)])
    gap = np.min(np.hypot(*(discs[:, None] - border).transpose(2, 0, 1)), axis=1)
    # under the disc the border is taken as straight beside the road; the bend is left out of that to second order: 1/25 m * (1 m * 0.2)^2 = 1.6 mm
    assert np.max(np.abs(gap - margin)) < 3e-3
