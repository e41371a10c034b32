from .coefficients import Coefficients as Coefficients
from .model import MfTyre as MfTyre

__all__ = ["Coefficients", "MfTyre"]
