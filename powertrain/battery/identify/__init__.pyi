from .lab import BenchCell as BenchCell
from .lab import dynamic_test as dynamic_test
from .lab import laboratory as laboratory
from .lab import profile as profile
from .lab import slow_test as slow_test
from .procedure import Identified as Identified
from .procedure import from_files as from_files
from .procedure import identify as identify
from .readers import kind_of as kind_of
from .readers import label as label
from .readers import read_arbin as read_arbin
from .readers import read_dynamic as read_dynamic
from .readers import sort_files as sort_files
from .records import DynamicTest as DynamicTest
from .records import OcvTest as OcvTest
from .records import Script as Script
from .report import Score as Score
from .report import evaluate as evaluate
from .report import predict as predict
from .slow import Branches as Branches
from .slow import Charge as Charge
from .slow import branches as branches
from .slow import charge_balances as charge_balances
from .structure import STRUCTURES as STRUCTURES
from .structure import Structure as Structure

__all__ = [
    "STRUCTURES",
    "BenchCell",
    "Branches",
    "Charge",
    "DynamicTest",
    "Identified",
    "OcvTest",
    "Score",
    "Script",
    "Structure",
    "branches",
    "charge_balances",
    "dynamic_test",
    "evaluate",
    "from_files",
    "identify",
    "kind_of",
    "label",
    "laboratory",
    "predict",
    "profile",
    "read_arbin",
    "read_dynamic",
    "slow_test",
    "sort_files",
]
