"""What is to be identified: which filters, which resistances, over which nodes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_OCV_NODES = (*(0.0, 0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.125, 0.15), *(round(0.05 * k, 2) for k in range(4, 20)), 0.975, 0.99, 1.0)
_RESISTANCE_NODES = (0.0, 0.01, 0.02, 0.03, 0.045, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8, 0.9, 0.97, 1.0)
_HYSTERESIS_NODES = (0.0, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)


@dataclass(frozen=True)
class Structure:
    """The form of a model, and where its tables have nodes.

    Attributes:
        model: "mesc", "esc" or "rc".
        time_constants: s, one per filter, where the search for poles begins; pure MESC has one for all four stages.
        ohmic: whether a resistance acts at once.
        taps: whether every filter has a resistance, or the last one only.
        hysteresis: whether there is a hysteresis voltage.
        resistance_nodes: charge at the nodes of the resistances; a single one means no dependence on charge.
        current_nodes: current at the nodes of R_0 (or of R_i in the pure MESC) as a share of 1 C; none: no dependence.
    """

    model: str
    time_constants: tuple[float, ...]
    ohmic: bool = True
    taps: bool = True
    hysteresis: bool = True
    ocv_nodes: tuple[float, ...] = _OCV_NODES
    resistance_nodes: tuple[float, ...] = _RESISTANCE_NODES
    hysteresis_nodes: tuple[float, ...] = _HYSTERESIS_NODES
    current_nodes: tuple[float, ...] = field(default=())

    @property
    def chain(self) -> bool:
        """Whether each filter follows the one before it."""
        return self.model == "mesc"

    @property
    def filters(self) -> int:
        """Number of filters."""
        return 4 if self.model == "mesc" else len(self.time_constants)

    @property
    def branches(self) -> int:
        """Number of resistances, R_0 included."""
        return int(self.ohmic) + (self.filters if self.taps else 1)

    def width(self, branch: int) -> int:
        """Number of parameters of a resistance at one temperature."""
        return len(self.resistance_nodes) * (max(len(self.current_nodes), 1) if branch == 0 else 1)


#: Ready-made structures by name. "mesc" and "rc-hysteresis" suit LFP; "mesc-nmc" cells without hysteresis whose ohmic part falls with current
#: (charge transfer in the cold); "mesc-published" is (5.4) as printed.
STRUCTURES = {
    "mesc": Structure("mesc", (1.5, 15.0, 150.0, 1000.0)),
    "mesc-nmc": Structure(
        "mesc",
        (1.5, 15.0, 150.0, 1000.0),
        hysteresis=False,
        resistance_nodes=(0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0),
        current_nodes=(-5.0, -1.5, -0.3, 0.3, 1.5, 5.0),
    ),
    "mesc-published": Structure("mesc", (0.3,), ohmic=False, taps=False, current_nodes=(-3.0, -0.5, 0.5, 3.0)),
    "esc": Structure("esc", (15.0,), resistance_nodes=(0.5,)),
    "rc": Structure("rc", (1.5, 15.0, 150.0), hysteresis=False),
    "rc-hysteresis": Structure("rc", (1.5, 15.0, 150.0)),
}


def hats(x: Any, nodes: tuple[float, ...]) -> Floats:
    """(n, k) hat functions of the nodes at `x`, clamped; what a table over these nodes is linear in."""
    x = np.asarray(x, dtype=np.float64)
    if len(nodes) < 2:
        return np.ones((len(x), 1))
    at = np.asarray(nodes)
    j = np.clip(np.searchsorted(at, x, side="right") - 1, 0, len(at) - 2)
    w = np.clip((x - at[j]) / (at[j + 1] - at[j]), 0.0, 1.0)
    out, rows = np.zeros((len(x), len(at))), np.arange(len(x))
    out[rows, j], out[rows, j + 1] = 1.0 - w, w
    return out
