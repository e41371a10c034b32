"""`energy-mgr`: entry point, and how errors look to a person."""

from __future__ import annotations

import sys
import traceback

import click

from .battery import battery_group
from .complaints import FAULT, fault_words, wants_traceback
from .front import front_command
from .plan import plan_command
from .quick import end_quickly, start_quickly
from .roads import roads_group
from .score import score_command
from .simulate import simulate_command
from .vehicle import vehicle_group


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="energy-mgr", prog_name="energy-mgr")
def cli() -> None:
    """Plan thrifty drives for electric cars: path, speed and energy from a road file."""


cli.add_command(plan_command)
cli.add_command(front_command)
cli.add_command(score_command)
cli.add_command(simulate_command)
cli.add_command(roads_group)
cli.add_command(vehicle_group)
cli.add_command(battery_group)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Bad input ends in one line on standard error and exit code 2. So does, with exit code 70, what nobody foresaw: the line names the command, its
    files and the place, and asks for a report; with `ENERGY_MGR_TRACEBACK=1` in the environment the traceback is printed above it.
    """
    try:
        code = cli.main(args=arguments, prog_name="energy-mgr", standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return 2
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        hint = f" (see '{context.command_path} --help')" if context is not None else ""
        return _complain(error.format_message().replace("\n", " ") + hint)
    except (click.Abort, KeyboardInterrupt):
        click.echo("energy-mgr: interrupted, nothing written", err=True)
        return 130
    except Exception as error:  # the last line of defence: no command ends in a traceback
        if wants_traceback():
            traceback.print_exception(error)
        click.echo(f"energy-mgr: {fault_words(error, cli, sys.argv[1:] if arguments is None else arguments)}", err=True)
        return FAULT
    return code if isinstance(code, int) else 0


def _complain(message: str) -> int:
    click.echo(f"energy-mgr: {message}", err=True)
    return 2


def run() -> None:
    """What the installed command calls: `main` in a process of its own."""
    start_quickly()
    code = main()
    end_quickly()
    sys.exit(code)


if __name__ == "__main__":
    run()
