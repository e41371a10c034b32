"""Errors of the library as a person should read them."""

from __future__ import annotations

import click


class complaints:  # noqa: N801  (used like a function)
    """Errors of the library become one line on standard error."""

    def __enter__(self) -> None:
        """Nothing to prepare."""

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: object) -> None:
        """Raise what a person should read."""
        from powertrain import VehicleError
        from roads import RoadError

        from ..errors import PlanningError

        if isinstance(error, RoadError | VehicleError | PlanningError):
            raise click.ClickException(str(error)) from None
