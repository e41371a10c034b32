from .balance import COMPONENTS as COMPONENTS
from .balance import KWH as KWH
from .balance import Ledger as Ledger
from .balance import drive_energy as drive_energy
from .cycle import CycleLedger as CycleLedger
from .cycle import drive_cycle as drive_cycle
from .cycle_charge import ChargeLedger as ChargeLedger
from .cycle_charge import charge_over_cycle as charge_over_cycle
from .errors import VehicleError as VehicleError
from .machine import torque_limits as torque_limits
from .motor import MotorLosses as MotorLosses
from .motor import force_limits as force_limits
from .motor import motor_losses as motor_losses
from .motor_map import MapFit as MapFit
from .motor_map import MotorMap as MotorMap
from .motor_map import read_map as read_map
from .plant import Plant as Plant
from .plant import PlantLedger as PlantLedger
from .resistance import driving_resistance as driving_resistance
from .sections import Battery as Battery
from .sections import Body as Body
from .sections import Brakes as Brakes
from .sections import Chassis as Chassis
from .sections import Drive as Drive
from .sections import Electrics as Electrics
from .sections import Limits as Limits
from .sections import Resistance as Resistance
from .sections import Steering as Steering
from .vehicle import Vehicle as Vehicle
from .vehicle import load_vehicle as load_vehicle
from .vehicle import shipped as shipped

__all__ = [
    "COMPONENTS",
    "KWH",
    "Battery",
    "Body",
    "Brakes",
    "ChargeLedger",
    "Chassis",
    "CycleLedger",
    "Drive",
    "Electrics",
    "Ledger",
    "Limits",
    "MapFit",
    "MotorLosses",
    "MotorMap",
    "Plant",
    "PlantLedger",
    "Resistance",
    "Steering",
    "Vehicle",
    "VehicleError",
    "charge_over_cycle",
    "drive_cycle",
    "drive_energy",
    "driving_resistance",
    "force_limits",
    "load_vehicle",
    "motor_losses",
    "read_map",
    "shipped",
    "torque_limits",
]
