"""Newton's equations of a chain against dense linear algebra, definite and not."""

import numpy as np
import pytest

from energy_mgr.speed.thriftiest.band import _negative, bordered, bordered_convex


def system(rng: np.random.Generator, wide: int, count: int, rows: int, raised: float):
    """A random band with `raised` added to its diagonal, dense rows, and the whole matrix [[A, G'], [G, -D]]."""
    band = rng.normal(size=(wide + 1, count))
    band[-1] = np.abs(band[-1]) + raised
    for k in range(1, wide + 1):
        band[wide - k, :k] = 0.0
    a = np.diag(band[-1])
    for k in range(1, wide + 1):
        a += np.diag(band[wide - k, k:], k) + np.diag(band[wide - k, k:], -k)
    dense, diagonal = rng.normal(size=(rows, count)), rng.uniform(1e-6, 1e-3, rows)
    return band, a, dense, diagonal, np.block([[a, dense.T], [dense, -np.diag(diagonal)]])


@pytest.mark.parametrize("wide", [1, 2])
@pytest.mark.parametrize("rows", [0, 1, 3])
def test_where_the_band_is_definite_the_dense_system_is_solved(wide: int, rows: int, rng: np.random.Generator):
    band, _, dense, diagonal, whole = system(rng, wide, 40, rows, 10.0)
    rhs, excess = rng.normal(size=40), rng.normal(size=rows)
    x, y = bordered(band, rhs, dense, diagonal, excess) or pytest.fail("not solved")
    assert whole @ np.append(x, y) == pytest.approx(np.append(rhs, -excess), abs=1e-9)


@pytest.mark.parametrize("wide", [1, 2])
def test_a_band_that_is_indefinite_only_along_what_a_row_forbids_is_solved_as_it_is(wide: int, rng: np.random.Generator):
    band, a, dense, diagonal, _ = system(rng, wide, 40, 1, 6.0)
    # the eigenvector of the least eigenvalue is what the row forbids; everywhere else the curvature is positive
    values, vectors = np.linalg.eigh(a)
    lowered = 0.5 * (values[0] + values[1])
    band[-1] -= lowered
    a = a - lowered * np.eye(40)
    dense = vectors[:, :1].T
    rhs, excess = rng.normal(size=40), np.array([0.2])
    x, y = bordered(band, rhs, dense, diagonal, excess) or pytest.fail("not solved")
    whole = np.block([[a, dense.T], [dense, -np.diag(diagonal)]])
    assert whole @ np.append(x, y) == pytest.approx(np.append(rhs, -excess), abs=1e-9)


def test_where_the_step_would_go_uphill_it_is_refused_and_the_raised_band_goes_down(rng: np.random.Generator):
    band, a, _, _, _ = system(rng, 1, 40, 0, 6.0)
    values, vectors = np.linalg.eigh(a)
    band[-1] -= values[0] + 0.3
    nothing = np.zeros((0, 40)), np.zeros(0), np.zeros(0)
    rhs = vectors[:, 0]  # along the direction of negative curvature
    assert bordered(band, rhs, *nothing) is None
    solved, shift = bordered_convex(band, rhs, *nothing, 0.0)
    assert solved is not None
    assert shift > 0.0
    assert solved[0] @ rhs > 0.0


def test_numbers_that_are_none_give_nothing():
    band = np.array([[0.0, 1.0], [np.nan, 1.0]])
    nothing = np.zeros((0, 2)), np.zeros(0), np.zeros(0)
    assert bordered(band, np.ones(2), *nothing) is None
    assert bordered_convex(band, np.ones(2), *nothing, 0.0)[0] is None


@pytest.mark.parametrize("wide", [1, 2])
def test_negative_eigenvalues_are_counted(wide: int, rng: np.random.Generator):
    for raised in np.linspace(-3.0, 3.0, 41):
        band, a, *_ = system(rng, wide, 30, 0, float(raised))
        assert _negative(band) == np.count_nonzero(np.linalg.eigvalsh(a) < 0.0)


@pytest.mark.parametrize("wide", [1, 2])
def test_negative_eigenvalues_are_counted_past_pivots_of_zero(wide: int, rng: np.random.Generator):
    wrong = 0
    for _ in range(300):
        band = rng.integers(-2, 3, size=(wide + 1, 8)).astype(float)
        for k in range(1, wide + 1):
            band[wide - k, :k] = 0.0
        a = np.diag(band[-1])
        for k in range(1, wide + 1):
            a += np.diag(band[wide - k, k:], k) + np.diag(band[wide - k, k:], -k)
        values = np.linalg.eigvalsh(a)
        # a singular matrix may be counted either way
        wrong += np.min(np.abs(values)) > 1e-9 and _negative(band) != np.count_nonzero(values < 0.0)
    assert wrong <= 1


def test_two_directions_that_only_one_row_would_have_to_forbid_are_refused(rng: np.random.Generator):
    band, a, _, diagonal, _ = system(rng, 1, 40, 1, 6.0)
    values, vectors = np.linalg.eigh(a)
    band[-1] -= 0.5 * (values[1] + values[2])
    assert bordered(band, rng.normal(size=40), vectors[:, :1].T, diagonal, np.zeros(1)) is None
