"""What a command line asks of a plan: the choices are the library's, and everything arrives in the request."""

from typing import Any, get_args

import click
import pytest

from energy_mgr import PlanRequest
from energy_mgr.cli.front import front_command
from energy_mgr.cli.plan import plan_command
from energy_mgr.cli.plan_options import plan_options, taken_request
from energy_mgr.cli.simulate import simulate_command
from energy_mgr.path.planner import PathKind
from energy_mgr.path.solvers import METHODS
from energy_mgr.request import PlanMethod, SpeedKind
from roads.road import Extent

EXPECTED = {
    "corridor": get_args(Extent),
    "path": get_args(PathKind),
    "speed": get_args(SpeedKind),
    "method": get_args(PlanMethod),
    "path_method": METHODS,
}


@pytest.mark.parametrize("command", [plan_command, front_command, simulate_command])
def test_choices_are_those_of_the_library(command: click.Command):
    choices = {option.name: option.type.choices for option in command.params if isinstance(option.type, click.Choice)}
    for name, expected in EXPECTED.items():
        assert sorted(choices.get(name, expected)) == sorted(expected)
    assert {"corridor", "path"} <= choices.keys()


def test_defaults_are_those_of_a_request():
    taken: dict[str, Any] = {}

    @click.command()
    @plan_options()
    def command(**options: Any) -> None:
        taken["request"], taken["left"] = taken_request(options), options

    command(args=[], standalone_mode=False)
    assert taken == {"request": PlanRequest(), "left": {}}


def test_all_options_arrive():
    taken: dict[str, Any] = {}

    @click.command()
    @plan_options()
    def command(**options: Any) -> None:
        taken["request"] = taken_request(options)

    line = "--corridor road --path lane --speed dp --time 95 --margin 0.3 --start-speed 2 --end-speed 1 --stop 5 --window 9:1:2 --jerk 3 --grip 0.8"
    command(args=[*line.split(), "--friction-brakes", "--step", "4"], standalone_mode=False)
    assert taken["request"].to_dict() == {
        "corridor": "road",
        "path": "lane",
        "speed": "dp",
        "journey_time": 95.0,
        "margin": 0.3,
        "rules": {
            "start_speed": 2.0,
            "end_speed": 1.0,
            "stops": [5.0],
            "windows": [[9.0, 1.0, 2.0]],
            "jerk": 3.0,
            "grip": 0.8,
            "friction_brakes": True,
            "step": 4.0,
        },
    }
