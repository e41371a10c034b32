from . import identify as identify
from .availability import Availability as Availability
from .availability import Available as Available
from .availability import available_power as available_power
from .availability import published_power as published_power
from .cell import Cell as Cell
from .cell import CellLimits as CellLimits
from .cell import Esc as Esc
from .cell import Mesc as Mesc
from .cell import Pair as Pair
from .cell import Rc as Rc
from .cell import Validity as Validity
from .cell import dump_cell as dump_cell
from .cell import load_cell as load_cell
from .cell import shipped_cells as shipped_cells
from .identify import DynamicTest as DynamicTest
from .identify import Identified as Identified
from .identify import OcvTest as OcvTest
from .identify import Script as Script
from .identify import evaluate as evaluate
from .identify import from_files as from_files
from .model import CellModel as CellModel
from .model import Powers as Powers
from .model import derivative as derivative
from .model import electromotive as electromotive
from .model import heat as heat
from .model import powers as powers
from .model import rest as rest
from .model import states as states
from .model import voltage as voltage
from .pack import Pack as Pack
from .pack import PackModel as PackModel
from .pack import PowerCurrent as PowerCurrent
from .pack import current_from_power as current_from_power
from .pack_availability import pack_power as pack_power
from .simulation import CellRun as CellRun
from .simulation import advance as advance
from .simulation import simulate as simulate
from .tables import Table as Table
from .tables import capacity_correction as capacity_correction

__all__ = [
    "Availability",
    "Available",
    "Cell",
    "CellLimits",
    "CellModel",
    "CellRun",
    "DynamicTest",
    "Esc",
    "Identified",
    "Mesc",
    "OcvTest",
    "Pack",
    "PackModel",
    "Pair",
    "PowerCurrent",
    "Powers",
    "Rc",
    "Script",
    "Table",
    "Validity",
    "advance",
    "available_power",
    "capacity_correction",
    "current_from_power",
    "derivative",
    "dump_cell",
    "electromotive",
    "evaluate",
    "from_files",
    "heat",
    "identify",
    "load_cell",
    "pack_power",
    "powers",
    "published_power",
    "rest",
    "shipped_cells",
    "simulate",
    "states",
    "voltage",
]
