import pickle
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from energy_mgr import PlanningError, Trajectory, TrajectoryPoint

from ...timing import least_time
from .test_trajectory import circle, clothoid, on_clothoid, straight

RING = circle()


# -- laps and ends -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("laps", [-2, -1, 1, 3])
def test_on_a_circuit_the_place_comes_again_while_time_and_heading_go_on(laps: int):
    ring = circle()
    s = np.array([0.3, 20.0, 100.0])
    once, again = ring.at(s), ring.at(s + laps * ring.length)
    for name in ("x", "y", "z", "kappa", "v", "a", "power", "jerk", "slope", "bank"):
        assert getattr(again, name) == pytest.approx(getattr(once, name), rel=1e-9, abs=1e-11), name
    assert again.t - once.t == pytest.approx(laps * ring.journey_time)
    assert again.psi - once.psi == pytest.approx(laps * 2 * np.pi)
    assert again.s == pytest.approx(s + laps * ring.length)
    assert ring.at_time(again.t) == pytest.approx(again.s, abs=1e-9)
    assert ring.at_time(float(again.t[0])) == pytest.approx(again.s[0], abs=1e-9)


def test_the_seam_of_a_circuit_is_no_place_of_its_own():
    ring = circle()
    for name in TrajectoryPoint._fields:
        before, after = (getattr(ring.point(ring.length + d), name) for d in (-1e-9, 1e-9))
        if name not in ("a", "power"):  # which are constant between stations
            assert before == pytest.approx(after, abs=1e-7), name
    assert ring.point(ring.length).x == ring.x[-1]


@pytest.mark.parametrize("s", [-1e-9, 35.000001, np.nan, np.inf])
def test_stations_beyond_the_ends_of_a_road_are_refused_with_the_range(s: float):
    trajectory = on_clothoid(np.linspace(0.0, 35.0, 9), name="ramp")
    for ask in (trajectory.point, trajectory.at, lambda s: trajectory.at([1.0, s, 2.0])):
        with pytest.raises(PlanningError, match=r"^ramp: station \S+ m is not on the trajectory, expected 0 to 35 m$"):
            ask(s)
    for ask in (trajectory.at_time, lambda t: trajectory.at_time([0.1, t])):
        with pytest.raises(PlanningError, match=r"^ramp: time \S+ s is not on the trajectory, expected 0 to 3\.5 s$"):
            ask(s)


@pytest.mark.parametrize("s", [np.nan, np.inf, -np.inf, 1e300])
def test_on_a_circuit_what_is_no_station_is_refused(s: float):
    ring = circle()
    for ask in (ring.point, lambda s: ring.at([1.0, s]), ring.at_time, lambda t: ring.at_time([1.0, t])):
        with pytest.raises(PlanningError, match="is not on the trajectory"):
            ask(s)


def test_words_are_no_stations():
    with pytest.raises(PlanningError, match="expected numbers"):
        circle().at(["here", "there"])  # pyright: ignore[reportArgumentType, reportCallIssue]


@given(s=st.floats(-500.0, 500.0))
@settings(deadline=None)
def test_one_station_and_many_are_answered_alike(s: float):
    one, many = RING.point(s), RING.at(np.array([[s, s], [s, s]]))
    assert all(type(value) is float for value in one)
    for name, value in zip(TrajectoryPoint._fields, one, strict=True):
        assert getattr(many, name).shape == (2, 2)
        # functions of math and of NumPy may differ in the last digit
        assert getattr(many, name)[1, 0] == pytest.approx(value, rel=1e-14, abs=1e-14)


def test_no_stations_have_no_places():
    assert RING.at(np.zeros(0)).x.shape == (0,)


@pytest.mark.timing
def test_a_controller_at_250_hz_gets_its_place_in_time():
    trajectory = straight(np.full(5000, 10.0))
    trajectory.point(0.0)
    grid = np.linspace(0.0, 5000.0, 5000)
    # thirteen numbers for what NumPy takes to look up ten in tables; two to five are usual
    tables = least_time(lambda: [np.interp(4321.5, grid, grid) for _ in range(1000)])
    for ask in (lambda: trajectory.point(4321.5), lambda: RING.point(4321.5), lambda: trajectory.at_time(432.15)):
        assert least_time(lambda ask=ask: [ask() for _ in range(1000)]) < 10.0 * tables


# -- the door ------------------------------------------------------------------------------------------------------------------------


def spoil(name: str, row: int, value: float) -> dict[str, np.ndarray]:
    columns = {key: np.array(column) for key, column in on_clothoid(np.linspace(0.0, 20.0, 11)).columns.items()}
    columns[name][row] = value
    return columns


@pytest.mark.parametrize(
    ("name", "row", "value", "words"),
    [
        ("kappa", 3, np.nan, "row 3: kappa_1pm is nan, expected a finite number"),
        ("power", 0, np.inf, "row 0: power_w is inf, expected a finite number"),
        ("s", 4, 6.0, "row 4: s_m is 6, expected more than 6 m"),
        ("v", 2, -1.0, "row 2: v_mps is -1, expected 0 or more"),
        ("t", 5, 0.0, "row 5: t_s is 0, expected more than 0.8 s"),
        ("psi", 6, 4.0, "row 6: psi_rad is 4, expected a heading that goes on"),
        ("bank", 6, 4.0, "row 6: bank_rad is 4, expected a bank in rad"),
    ],
)
def test_tables_that_are_no_trajectory_are_refused_with_row_and_column(name: str, row: int, value: float, words: str):
    with pytest.raises(PlanningError, match=f"^bad road: {words}"):
        Trajectory(**spoil(name, row, value), name="bad road")


def test_standstill_at_two_stations_in_a_row_is_refused():
    with pytest.raises(PlanningError, match="row 2: v_mps is 0, expected a speed"):
        straight(np.array([1.0, 0.0, 0.0, 1.0]))


def test_shapes_that_do_not_fit_are_refused():
    good = on_clothoid(np.linspace(0.0, 20.0, 11))
    with pytest.raises(PlanningError, match=r"x_m has shape \(3,\), expected \(11,\) as s_m"):
        replace(good, x=np.zeros(3))
    with pytest.raises(PlanningError, match=r"s_m has shape \(1,\), expected \(n,\)"):
        Trajectory(**{name: column[:1] for name, column in good.columns.items()})
    with pytest.raises(PlanningError, match=r"s_m has shape \(1, 11\), expected \(n,\)"):
        Trajectory(**{name: column[None] for name, column in good.columns.items()})
    with pytest.raises(PlanningError, match=r"power_w has shape \(11,\), expected \(10,\) or one value"):
        on_clothoid(np.linspace(0.0, 20.0, 11), power=np.zeros(11))
    with pytest.raises(PlanningError, match="expected numbers"):
        Trajectory.along(good.s, "east", good.y, good.psi, good.kappa, good.v)  # pyright: ignore[reportArgumentType]
    with pytest.raises(PlanningError, match=r"expected one \(n,\)"):
        Trajectory.along([1.0], [1.0], [1.0], [1.0], [1.0], [1.0])


@pytest.mark.parametrize("name", ["x", "z", "psi", "v"])
def test_a_circuit_whose_ends_do_not_meet_is_refused(name: str):
    columns = {key: np.array(column) for key, column in RING.columns.items()}
    columns[name][-1] += 0.01
    with pytest.raises(PlanningError, match="as in the first row of a closed track"):
        Trajectory(**columns, closed=True)


def test_headings_in_degrees_or_from_north_are_noticed():
    s = np.linspace(0.0, 40.0, 21)
    x, y, psi, kappa = clothoid(s)
    with pytest.raises(PlanningError, match="psi_rad is"):
        Trajectory.along(s, x, y, psi - np.pi / 2, kappa, 10.0 + 0 * s)
    with pytest.raises(PlanningError, match="psi_rad is"):
        Trajectory.along(s, x, y, np.degrees(psi), kappa, 10.0 + 0 * s)
    with pytest.raises(PlanningError, match="kappa_1pm is"):
        Trajectory.along(s, x, y, psi, -20 * kappa, 10.0 + 0 * s)
    with pytest.raises(PlanningError, match=r"s_m is \S+, expected to grow"):
        Trajectory.along(0.5 * s, x, y, psi, kappa, 10.0 + 0 * s)


def test_nothing_in_a_trajectory_can_be_changed():
    given_s = np.linspace(0.0, 20.0, 11)
    trajectory = on_clothoid(given_s)
    given_s[0] = 1.0
    assert trajectory.s[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        trajectory.x[0] = 1.0
    with pytest.raises(FrozenInstanceError):
        trajectory.closed = True  # pyright: ignore[reportAttributeAccessIssue]


def test_a_trajectory_can_be_sent_to_another_process():
    RING.point(1.0)
    assert pickle.loads(pickle.dumps(RING)).point(1.0) == RING.point(1.0)


def test_table_has_the_columns_in_the_order_of_their_names():
    assert Trajectory.COLUMNS[:10] == ("s_m", "x_m", "y_m", "z_m", "psi_rad", "kappa_1pm", "v_mps", "a_mps2", "t_s", "power_w")
    assert Trajectory.COLUMNS[10:] == ("jerk_mps3", "slope", "bank_rad")
    assert np.array_equal(RING.table()[:, 4], RING.psi)
    assert np.array_equal(RING.table()[:, 12], RING.bank)
