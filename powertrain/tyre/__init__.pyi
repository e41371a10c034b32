from .force import Tyre as Tyre
from .force import TyreForces as TyreForces
from .force import slip_power as slip_power
from .linear import LinearTyre as LinearTyre
from .magic import MagicTyre as MagicTyre
from .mf.model import MfTyre as MfTyre
from .tir import read_tir as read_tir

__all__ = ["LinearTyre", "MagicTyre", "MfTyre", "Tyre", "TyreForces", "read_tir", "slip_power"]
