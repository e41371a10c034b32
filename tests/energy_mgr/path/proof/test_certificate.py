import numpy as np
import pytest

from energy_mgr.path.proof.certificate import Prover
from energy_mgr.path.proof.curvature_proof import prove_curvature
from energy_mgr.path.proof.pieces import Pieces
from roads import Corridor, Narrowing, PlanarCurve, Road, RoadBuilder
from roads.border_line import border_lines
from roads.geometry.cubic import PiecewiseCubic, interpolate


def along(reference: PlanarCurve, offset, count: int = 400) -> PiecewiseCubic:
    """A path at offsets from the reference (a function of the station), its parameter the station."""
    s = np.linspace(0.0, reference.length, count + 1)
    points = reference.position(s) + np.asarray(offset(s))[:, None] * reference.normal(s)
    if reference.closed:
        points[-1] = points[0]
    return interpolate(s, points, closed=reference.closed)


@pytest.fixture(scope="module")
def ring() -> Road:
    angle = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    return Road.from_points("ring", 40 * np.column_stack([np.cos(angle), np.sin(angle)]), -4.0, 4.0, closed=True)


@pytest.mark.parametrize(
    ("offset", "inside"), [(2.9990, True), (2.9999, False), (3.01, False), (-2.999, True), (-3.0001, False), (4.5, False), (-9.0, False)]
)
def test_circle_beside_a_circular_border_is_proven_up_to_its_clearance(ring: Road, offset: float, inside: bool):
    found = Prover(ring.corridor("road", 1.0)).prove(along(ring.reference, lambda s: offset + 0.0 * s))
    assert found.inside is inside
    if inside:
        # the bound is no more than the sags above the truth, 1 m less the distance
        assert abs(offset) - 3.0 <= found.beyond <= abs(offset) - 3.0 + 1e-3
    else:
        assert len(found.where) > 0


@pytest.mark.parametrize("at", [50.0, 50.043, 50.1])
def test_spike_between_samples_of_a_decimetre_is_found(at: float):
    road = RoadBuilder("straight").straight(100).build(lanes=((1, -3.0, 3.0),))
    corridor = road.corridor("road", 1.0)
    knots = np.array([0.0, at - 0.05, at, at + 0.05, 100.0])
    bump = np.array([[0.0, 1.9], [at - 0.05, 1.9], [at, 2.01], [at + 0.05, 1.9], [100.0, 1.9]])
    spike = PiecewiseCubic(knots, _straight_pieces(knots, bump))
    found = Prover(corridor).prove(spike)
    assert not found.inside
    assert np.min(np.abs(found.where - at)) < 0.1
    assert Prover(corridor).prove(PiecewiseCubic(knots, _straight_pieces(knots, bump - [0.0, 0.02]))).inside


def _straight_pieces(knots: np.ndarray, points: np.ndarray) -> np.ndarray:
    slope = np.diff(points, axis=0).T / np.diff(knots)
    zero = np.zeros_like(slope)
    return np.stack([zero, zero, slope, points[:-1].T])


def test_path_that_jumps_over_the_border_and_back_is_not_proven():
    # both ends far outside a narrow strip: no sample of the path comes near the border
    road = RoadBuilder("straight").straight(100).build(lanes=((1, -3.0, 3.0),))
    knots = np.array([0.0, 50.0, 50.001, 99.999, 100.0])
    points = np.array([[0.0, 0.0], [50.0, 0.0], [50.001, 20.0], [99.999, 20.0], [100.0, 0.0]])
    found = Prover(road.corridor("road", 1.0)).prove(PiecewiseCubic(knots, _straight_pieces(knots, points)))
    assert not found.inside


def test_path_that_loses_the_road_is_not_proven():
    # runs through the strip at twice the speed of the stations: inside everywhere, but of no known place
    road = RoadBuilder("straight").straight(100).build(lanes=((1, -3.0, 3.0),))
    knots = np.array([0.0, 50.0, 100.0])
    points = np.array([[0.0, 0.0], [90.0, 0.0], [100.0, 0.0]])
    assert not Prover(road.corridor("road", 1.0)).prove(PiecewiseCubic(knots, _straight_pieces(knots, points))).inside


def test_path_that_is_no_number_is_not_proven():
    road = RoadBuilder("straight").straight(100).build(lanes=((1, -3.0, 3.0),))
    path = along(road.reference, lambda s: 0.0 * s, 20)
    broken = path.coefficients.copy()
    broken[1, 1, 7] = np.nan
    found = Prover(road.corridor("road", 1.0)).prove(PiecewiseCubic(path.breaks, broken), 0.1)
    assert not found.inside
    assert not found.gentle


def test_road_that_crosses_itself_is_proven_by_its_own_borders_only():
    # a loop of 270 degrees over itself: at the crossing the other branch's borders cut right through the path
    road = RoadBuilder("loop").straight(60).arc(25, 1.5 * np.pi).straight(80).build(lanes=((1, -3.0, 3.0),))
    assert Prover(road.corridor("road", 1.0)).prove(along(road.reference, lambda s: 0.0 * s)).inside


def test_border_of_changing_width_is_kept_by_distance_not_by_offset():
    # a wedge of 45 degrees: at offset distance d the border is d / sqrt(2) away
    s = np.linspace(0.0, 60.0, 61)
    left = 2.0 + np.clip(s - 20.0, 0.0, 20.0)
    road = Road.from_points("wedge", np.column_stack([s, 0 * s]), -5.0, left)
    prover = Prover(road.corridor("road", 1.0))
    knots = np.array([0.0, 20.0, 60.0])

    def path(lateral: float) -> PiecewiseCubic:
        return PiecewiseCubic(knots, _straight_pieces(knots, np.array([[0.0, lateral], [20.0, lateral], [60.0, lateral]])))

    assert prover.prove(path(0.9990)).inside
    assert not prover.prove(path(1.001)).inside

    steep = np.array([[0.0, 0.9], [20.0, 0.9], [60.0, 40.0 * 0.4 + 0.9]])
    corner = Prover(road.corridor("road", 1.2))
    assert not corner.prove(PiecewiseCubic(knots, _straight_pieces(knots, steep))).inside


@pytest.mark.parametrize(("bound", "gentle"), [(0.0251, True), (0.0249, False)])
def test_bound_on_curvature_is_that_of_the_circle(ring: Road, bound: float, gentle: bool):
    found = Prover(ring.corridor("road", 1.0)).prove(along(ring.reference, lambda s: 0.0 * s), bound)
    assert found.gentle is gentle
    assert found.certified is gentle
    assert found.curvature == pytest.approx(1 / 40, rel=1e-3)


def test_curvature_that_peaks_between_two_breaks_is_bounded():
    # o = 20 (u, 8 u^3 - 12 u^2 + 4 u) with u = th / 20: curvature changes sign within the piece and peaks off its ends
    a = 20.0 * np.array([[0.0, 8.0 / 20.0**3], [0.0, -12.0 / 20.0**2], [1.0 / 20.0, 4.0 / 20.0], [0.0, 0.0]])[:, :, None]
    piece = PiecewiseCubic(np.array([0.0, 20.0]), a)
    curve = PlanarCurve.of_pieces(piece)
    peak = float(np.max(np.abs(curve.curvature(np.linspace(0.0, curve.length, 100_001)))))
    corridor = Corridor("wide", RoadBuilder("s").straight(20).build().reference, np.array([0.0, 20.0]), np.full(2, -50.0), np.full(2, 50.0), 0.0)
    assert not Prover(corridor).prove(piece, 0.999 * peak).gentle
    assert Prover(corridor).prove(piece, 1.01 * peak).gentle


def test_curvature_that_peaks_where_neither_ends_nor_middle_of_a_piece_lie_is_bounded():
    # o = 20 (u - 0.0003 u^2 + 0.098 u^3, -0.0172 u^2 - 0.00083 u^3) with u = th / 20, found by search: largest at a quarter of the piece, by four
    # thousandths more than its ends and its middle show
    length, rows = 20.0, np.array([[0.098, -0.00083], [-0.0003, -0.0172], [1.0, 0.0], [0.0, 0.0]])
    u = np.linspace(0.0, 1.0, 100_001)
    first = rows[2][:, None] + 2.0 * rows[1][:, None] * u + 3.0 * rows[0][:, None] * u**2
    second = 2.0 * rows[1][:, None] + 6.0 * rows[0][:, None] * u
    peak = float(np.max(np.abs(first[0] * second[1] - first[1] * second[0]) / np.hypot(*first) ** 3)) / length
    piece = PiecewiseCubic(np.array([0.0, length]), length * (rows / length ** np.arange(3, -1, -1)[:, None])[:, :, None])
    parts = Pieces(np.array([0.0]), np.array([length]))
    assert not prove_curvature(piece, parts, 0.998 * peak)[0]
    proven, bound, _ = prove_curvature(piece, parts, 1.002 * peak)
    assert proven
    assert bound >= peak * (1.0 - 1e-9)  # the peak is that of samples a hundred-thousandth of the piece apart


@pytest.mark.parametrize("sag", [2e-2, 1e-4])
def test_border_lines_lie_within_their_sag(sag: float, rng: np.random.Generator):
    s = np.linspace(0.0, 80.0, 41)
    road = RoadBuilder("bend").straight(20).bend(12, 1.5, 8).straight(30).build()
    s = np.linspace(0.0, road.length, 30)
    wavy = Road.from_points("wavy", road.reference.position(s), -3.0 - rng.uniform(0, 1, 30), 3.0 + rng.uniform(0, 1, 30))
    corridor = wavy.corridor("road", 1.0)
    for line, which in zip(border_lines(corridor, sag), (0, 1), strict=True):
        fine = np.linspace(0.0, wavy.length, 4001)
        true = wavy.reference.position(fine) + np.asarray(corridor.borders(fine)[which])[:, None] * wavy.reference.normal(fine)
        at = np.clip(np.searchsorted(line.s, fine, side="right") - 1, 0, len(line.keep) - 1)
        a, b = line.points[at], line.points[at + 1]
        share = np.clip(np.sum((true - a) * (b - a), axis=1) / np.maximum(np.sum((b - a) ** 2, axis=1), 1e-18), 0, 1)
        gap = np.hypot(*(true - a - share[:, None] * (b - a)).T)
        assert np.all(gap <= line.sag[at] + 1e-9)
        assert np.max(line.sag) <= sag * (1 + 1e-9)


def test_path_that_swings_out_between_two_stations_is_not_proven():
    # one cubic that runs 25 m ahead and back within 2 m of stations, through a wall that stands beside other stations than its own
    road = RoadBuilder("straight").straight(100).build(lanes=((1, -3.0, 3.0),))
    corridor = road.corridor("road", 1.0).narrowed(Narrowing(20.0, 24.0, left=-1.0))
    knots = np.array([0.0, 10.0, 12.0, 100.0])
    straight = _straight_pieces(knots, np.array([[0.0, 0.5], [10.0, 0.5], [12.0, 0.5], [100.0, 0.5]]))
    swing = straight.copy()
    # x from 10 to 12 with a bow of 25 m in between: 4 * 25 * u (1 - u)
    swing[:, 0, 1] = [0.0, -25.0, 51.0, 10.0]
    assert not Prover(corridor).prove(PiecewiseCubic(knots, swing), start=0.0, end=14.0).inside
    assert Prover(corridor).prove(PiecewiseCubic(knots, straight), start=0.0, end=14.0).inside


@pytest.mark.parametrize("margin", [0.0, 0.01, 0.03])
def test_path_outside_a_border_with_little_margin_is_not_proven(margin: float):
    road = RoadBuilder("straight").straight(100).build(lanes=((1, -3.0, 3.0),))
    prover = Prover(road.corridor("road", margin))
    assert not prover.prove(along(road.reference, lambda s: 3.02 + 0.0 * s)).inside
    assert not prover.prove(along(road.reference, lambda s: 3.0005 + margin + 0.0 * s)).inside
    assert prover.prove(along(road.reference, lambda s: 2.998 - margin + 0.0 * s)).inside


def test_wall_in_a_folding_bend_keeps_its_margin():
    road = RoadBuilder("tight").straight(20).arc(10, 1.5).straight(20).build(lanes=((1, -4.0, 12.0),))
    corridor = road.corridor("road", 1.0).narrowed(Narrowing(26.0, 29.0, left=2.0))
    prover = Prover(corridor)
    for gap in (0.03, 0.3, 0.9):
        # a path that runs up to the wall's edge inside the bend
        stop = 26.0 - gap
        assert not prover.prove(along(road.reference, lambda s: 4.0 * np.clip((s - 10.0) / 12.0, 0.0, 1.0)), start=0.0, end=stop).inside
