from .balance import COMPONENTS as COMPONENTS
from .balance import Ledger as Ledger
from .balance import drive_energy as drive_energy
from .errors import VehicleError as VehicleError
from .motor import MotorLosses as MotorLosses
from .motor import force_limits as force_limits
from .motor import motor_losses as motor_losses
from .resistance import driving_resistance as driving_resistance
from .vehicle import Chassis as Chassis
from .vehicle import Drive as Drive
from .vehicle import Limits as Limits
from .vehicle import Resistance as Resistance
from .vehicle import Vehicle as Vehicle
from .vehicle import load_vehicle as load_vehicle
from .vehicle import shipped as shipped

__all__ = [
    "COMPONENTS",
    "Chassis",
    "Drive",
    "Ledger",
    "Limits",
    "MotorLosses",
    "Resistance",
    "Vehicle",
    "VehicleError",
    "drive_energy",
    "driving_resistance",
    "force_limits",
    "load_vehicle",
    "motor_losses",
    "shipped",
]
