import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from roads.geometry.crossing import mutual_crossings, self_crossings


def brute(line: np.ndarray, closed: bool) -> set[tuple[int, int]]:
    """Every pair of segments, by orientation tests in plain Python."""
    points = [*line.tolist(), line[0].tolist()] if closed else line.tolist()
    count = len(points) - 1

    def side(a: list[float], b: list[float], c: list[float]) -> float:
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    found = set()
    for i in range(count):
        for j in range(i + 2, count):
            if closed and i == 0 and j == count - 1:
                continue
            a, b, c, d = points[i], points[i + 1], points[j], points[j + 1]
            if side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0:
                found.add((i, j))
    return found


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(4, 60), closed=st.booleans(), stretch=st.floats(0.1, 50))
def test_same_crossings_as_trying_every_pair(seed: int, count: int, closed: bool, stretch: float):
    rng = np.random.default_rng(seed)
    line = np.cumsum(rng.normal(size=(count, 2)) * rng.exponential(stretch, size=(count, 1)), axis=0)
    assert {(i, j) for i, j, _ in self_crossings(line, closed=closed)} == brute(line, closed)


def test_mutual_crossing_is_found_where_it_is():
    s = np.arange(0.0, 100.0, 3.0)
    first, second = np.column_stack([s, 0 * s]), np.column_stack([s, 0.1 * (s - 50.0)])
    [(i, j, place)] = list(mutual_crossings(first, second))
    assert (i, j) == (16, 16)
    assert np.allclose(place, [50.0, 0.0])
