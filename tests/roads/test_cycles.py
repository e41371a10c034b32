import numpy as np
import pytest

from roads import RoadError, cycles

#: Published length (km), duration (s) and top speed (km/h): UN R83 for the European ones, 40 CFR 86 with EPA's fact sheets for the American ones
#: (7.45, 11.04, 10.26 and 8.01 miles; 56.7, 56.7, 59.9 and 80.3 mph), UN GTR 15 for the WLTC. Lengths hold to the last digit stated, those of
#: ECE 15 and NEDC to 0.2 %, by which the copies of the regulation differ among each other.
PUBLISHED = {
    "ece15": (1.013, 195, 50.0, 2e-3),
    "eudc": (6.955, 400, 120.0, 1e-3),
    "nedc": (11.007, 1180, 120.0, 2e-3),
    "udds": (7.45 * 1.609344, 1369, 56.7 * 1.609344, 1e-3),
    "ftp75": (17.77, 1874, 56.7 * 1.609344, 1e-3),
    "hwfet": (10.26 * 1.609344, 765, 59.9 * 1.609344, 1e-3),
    "us06": (8.01 * 1.609344, 600, 80.3 * 1.609344, 1e-3),
    "wltc_3a": (23.194, 1800, 131.3, 1e-4),
    "wltc_3b": (23.266, 1800, 131.3, 1e-4),
    "wltc_2": (22.649, 1800, 123.1, 1e-4),
    "wltc_1": (11.428, 1611, 64.4, 1e-4),
}


@pytest.mark.parametrize("name", sorted(PUBLISHED))
def test_cycles_have_their_published_length_duration_and_top_speed(name: str, figure):
    length, duration, top, within = PUBLISHED[name]
    cycle = cycles.load(name)
    figure(f"{name}: length", cycle.distance / 1000.0, "{:.4f} km", published=f"{length:.3f} km")
    assert cycle.distance / 1000.0 == pytest.approx(length, rel=within)
    assert cycle.duration == duration
    assert np.max(cycle.v) * 3.6 == pytest.approx(top, abs=0.01)
    assert cycle.v[0] == cycle.v[-1] == 0.0
    assert "Regulation" in cycle.source or "CFR" in cycle.source or "GTR" in cycle.source


def test_all_shipped_cycles_are_checked():
    assert cycles.names() == sorted(PUBLISHED)


def test_composed_cycles_are_composed():
    urban, highway, whole = (cycles.load(name) for name in ("ece15", "eudc", "nedc"))
    assert whole.distance == pytest.approx(4.0 * urban.distance + highway.distance, abs=0.01)
    assert np.allclose(whole.speed_at(urban.t + 195.0), urban.v)
    cold, both = cycles.load("udds"), cycles.load("ftp75")
    assert np.allclose(both.speed_at(1369.0 + np.arange(1, 506)), cold.speed_at(np.arange(1, 506)))


def test_wltc_phases_are_as_long_as_published():
    cycle = cycles.load("wltc_3b")
    ends = np.interp([589.0, 1022.0, 1477.0, 1800.0], cycle.t, cycle.distances)
    # GTR 15, Annex 1: 3095, 4756, 7162 and 8254 m
    assert np.allclose(np.diff(np.append(0.0, ends)), [3095, 4756, 7162, 8254], atol=1.0)


def test_own_cycles_and_bad_ones(tmp_path):
    (tmp_path / "mine.csv").write_text("t_s,v_mps\n0,0\n10,5\n20,0\n")
    assert cycles.load(tmp_path / "mine.csv").distance == pytest.approx(50.0)
    for text, words in (
        ("t_s,v_mps\n0,0\n0,5\n", r"bad\.csv:3: t_s does not increase"),
        ("t_s,v_kmh\n0,0\n1,-5\n", r"bad\.csv:3: speed is -1.38"),
        ("t_s,w\n0,0\n1,1\n", "expected t_s and v_kmh"),
    ):
        (tmp_path / "bad.csv").write_text(text)
        with pytest.raises(RoadError, match=words):
            cycles.load(tmp_path / "bad.csv")
    with pytest.raises(RoadError, match="no shipped cycle, expected one of ece15"):
        cycles.load("wltp")
