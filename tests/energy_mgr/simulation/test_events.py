"""Files of events."""

import pytest

from energy_mgr.simulation import Event, read_events
from powertrain import VehicleError


def test_events_come_from_a_file(tmp_path):
    file = tmp_path / "events.toml"
    file.write_text('[[event]]\nstation_m = 850.0\npart = "steer_fl"\nkind = "stuck"\nduration_s = 2.0\n')
    assert read_events(file) == (Event(part="steer_fl", kind="stuck", station_m=850.0, duration_s=2.0),)
    unknown = '[[event]]\npart="a"\nkind="dead"\ncolour=1\n'
    for text in ("[[event]]\npart = 1\n", 'event = "x"\n', '[[event]]\npart = "a"\nkind = "bent"\n', "[[event]]\npart", unknown):
        file.write_text(text)
        with pytest.raises(VehicleError, match=r"events\.toml") as caught:
            read_events(file)
        assert "\n" not in str(caught.value)
    with pytest.raises(VehicleError, match=r"missing\.toml"):
        read_events(tmp_path / "missing.toml")
