from .energy.balance import COMPONENTS as COMPONENTS
from .energy.balance import KWH as KWH
from .energy.balance import Ledger as Ledger
from .energy.balance import drive_energy as drive_energy
from .energy.cycle import CycleLedger as CycleLedger
from .energy.cycle import drive_cycle as drive_cycle
from .energy.cycle_charge import ChargeLedger as ChargeLedger
from .energy.cycle_charge import charge_over_cycle as charge_over_cycle
from .errors import VehicleError as VehicleError
from .drive.machine import torque_limits as torque_limits
from .energy.motor import MotorLosses as MotorLosses
from .energy.motor import force_limits as force_limits
from .energy.motor import motor_losses as motor_losses
from .drive.motor_map import MapFit as MapFit
from .drive.motor_map import MotorMap as MotorMap
from .drive.motor_map import read_map as read_map
from .plant import Plant as Plant
from .plant import PlantLedger as PlantLedger
from .energy.resistance import driving_resistance as driving_resistance
from .description.sections import Battery as Battery
from .description.sections import Body as Body
from .description.sections import Brakes as Brakes
from .description.sections import Chassis as Chassis
from .description.sections import Drive as Drive
from .description.sections import Electrics as Electrics
from .description.sections import Limits as Limits
from .description.sections import Resistance as Resistance
from .description.sections import Steering as Steering
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
