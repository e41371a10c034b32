"""A CasADi function called through buffers: arrays in, arrays out, nothing made in between."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from powertrain.chassis.compiled import scalar
from powertrain.symbolic import ca

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


class Compiled:
    """A function of vectors, its results dense.

    Attributes:
        arguments: the arrays that the function reads; write into them and call `run`.
        results: the arrays that `run` fills, column by column as they are in the mathematics.
    """

    def __init__(
        self, name: str, arguments: Sequence[Any], results: Sequence[Any], shared: Sequence[Floats] = (), results_in: Sequence[Floats] = ()
    ) -> None:
        """Optimise and bind expressions `results` of symbols `arguments`; the first arguments are read from the arrays `shared`, the first
        results go to the arrays `results_in`, all in Fortran order."""
        self.function = ca.Function(name, list(arguments), [ca.densify(result) for result in ca.cse(list(results))])
        self.arguments: list[Floats] = [*shared, *(np.zeros(argument.numel()) for argument in arguments[len(shared) :])]
        # CasADi stores columns one after the other
        self.results: list[Floats] = [*results_in, *(np.zeros(result.shape, order="F") for result in results[len(results_in) :])]
        self._bind(self.function)

    def compile_c(self) -> None:
        """Turn the function into machine code: a second or two once, then about a fifth of the time.

        Raises:
            VehicleError: there is no C compiler, or it refused.
        """
        self._bind(scalar(self.function))

    def _bind(self, function: Any) -> None:
        self._called = function
        self._buffer, self.run = function.buffer()
        for k, argument in enumerate(self.arguments):
            self._buffer.set_arg(k, argument.T.data)
        for k, result in enumerate(self.results):
            self._buffer.set_res(k, result.T.data)

    def __call__(self, *arguments: Floats) -> list[Floats]:
        """The results for `arguments`; they are overwritten by the next call."""
        for place, argument in zip(self.arguments, arguments, strict=True):
            place[:] = argument
        self.run()
        return self.results
