import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from powertrain import VehicleError
from powertrain.battery import Table, capacity_correction

VALUES = np.arange(24.0).reshape(3, 4, 2) ** 1.3
AXES = {"soc": (0.0, 0.3, 1.0), "temperature_degc": (-10.0, 5.0, 25.0, 45.0), "current_a": (-20.0, 30.0)}


def nested(values):
    return tuple(nested(v) for v in values) if isinstance(values, list) else float(values)


def table(axes, extrapolate="clamp", values=VALUES):
    return Table(values=nested(values.tolist()), extrapolate=extrapolate, **{name: AXES[name] for name in axes})


def test_values_at_the_nodes_are_the_table():
    found = table(AXES)(*np.meshgrid(AXES["soc"], np.array(AXES["temperature_degc"]) + 273.15, AXES["current_a"], indexing="ij"))
    assert found == pytest.approx(VALUES, abs=1e-12)


def test_scipy_finds_the_same_between_the_nodes(rng):
    from scipy.interpolate import RegularGridInterpolator

    peer = RegularGridInterpolator((AXES["soc"], np.array(AXES["temperature_degc"]) + 273.15, AXES["current_a"]), VALUES)
    points = np.column_stack([rng.uniform(0, 1, 200), rng.uniform(263.15, 318.15, 200), rng.uniform(-20, 30, 200)])
    assert table(AXES)(*points.T) == pytest.approx(peer(points), abs=1e-11)


@pytest.mark.parametrize("extrapolate", ["clamp", "linear"])
@pytest.mark.parametrize("axes", [("soc",), ("temperature_degc",), ("soc", "current_a"), ("soc", "temperature_degc", "current_a")])
def test_symbols_and_numbers_agree_inside_and_outside(axes, extrapolate, rng):
    values = rng.normal(size=tuple(len(AXES[name]) for name in axes))
    found = table(axes, extrapolate, values)
    x = ca.SX.sym("x", 3)
    symbolic = ca.Function("t", [x], [found(x[0], x[1], x[2])])
    points = np.column_stack([rng.uniform(-0.3, 1.3, 300), rng.uniform(250, 330, 300), rng.uniform(-40, 50, 300)])
    numeric = found(*points.T)
    assert np.max(np.abs(np.asarray(symbolic(points.T)).ravel() - numeric)) < 1e-12


def test_two_nodes_continue_their_line_or_stop():
    line = {"soc": (0.0, 1.0), "values": (1.0, 3.0)}
    assert Table(**line, extrapolate="linear")(2.0) == pytest.approx(5.0)
    assert Table(**line)(2.0) == pytest.approx(3.0)
    assert Table(**line)(-1.0) == pytest.approx(1.0)


def test_lists_are_taken_as_arrays():
    found = table(AXES)([0.1, 0.2], (280.0, 290.0), 5.0)
    assert found == pytest.approx(table(AXES)(np.array([0.1, 0.2]), np.array([280.0, 290.0]), 5.0))


def test_what_is_not_a_number_stays_so_in_numbers_and_is_nothing_in_symbols():
    """The documented difference: fmin and fmax of CasADi drop a NaN."""
    x = ca.SX.sym("x")
    line = Table(soc=(0.0, 1.0), values=(1.0, 3.0))
    assert np.isnan(line(np.nan))
    assert float(ca.Function("t", [x], [line(x)])(np.nan)) == 0.0


@given(soc=st.floats(-1, 2), warm=st.floats(200, 400), current=st.floats(-100, 100))
def test_a_clamped_table_never_leaves_its_values(soc, warm, current):
    assert VALUES.min() - 1e-9 <= table(AXES)(soc, warm, current) <= VALUES.max() + 1e-9


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"values": (1.0, 2.0)}, "no axis"),
        ({"soc": (0.0,), "values": (1.0,)}, "at least two"),
        ({"soc": (0.0, 0.0), "values": (1.0, 2.0)}, "increasing"),
        ({"soc": (0.0, float("nan")), "values": (1.0, 2.0)}, "finite"),
        ({"soc": (0.0, 1.0), "values": (1.0, 2.0, 3.0)}, "shape"),
        ({"soc": (0.0, 1.0), "current_a": (0.0, 1.0), "values": ((1.0, 2.0), (3.0,))}, "different length"),
        ({"soc": (0.0, 1.0), "values": (1.0, float("inf"))}, "not finite"),
    ],
)
def test_a_malformed_table_is_refused_in_one_line(wrong, says):
    with pytest.raises(VehicleError, match=says) as error:
        Table(**wrong)
    assert "\n" not in str(error.value)


def test_capacity_correction_follows_both_branches_of_the_thesis():
    k = capacity_correction(0.002, 1.0, -40.0, 80.0)
    assert k(current=80.0) == pytest.approx(1.0 + 0.002 * 80.0)
    assert k(current=-40.0) == pytest.approx(np.exp(-0.08))
    assert k(current=0.0) == pytest.approx(1.0)
    assert k(current=20.0) > k(current=0.0) > k(current=-20.0)
    with pytest.raises(VehicleError, match="expected above 0"):
        capacity_correction(0.1, 0.5, -40.0, 80.0)
