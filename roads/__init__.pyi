from . import cycles as cycles
from .editing.builder import RoadBuilder as RoadBuilder
from .corridor import Corridor as Corridor
from .corridor import Narrowing as Narrowing
from .geometry.curve import PlanarCurve as PlanarCurve
from .editing.edit import join as join
from .errors import RoadError as RoadError
from .findings import Finding as Finding
from .formats import read as read
from .formats import read_network as read_network
from .formats import write as write
from .gallery import open_road as open_road
from .gallery import shipped as shipped
from .lane import Lane as Lane
from .networks.links import Link as Link
from .networks.network import Network as Network
from .editing.network_builder import NetworkBuilder as NetworkBuilder
from .recorded import Recorded as Recorded
from .road import Road as Road
from .editing.smooth import smoothed as smoothed
from .geometry.tracker import Tracker as Tracker

__all__ = [
    "Corridor",
    "Finding",
    "Lane",
    "Link",
    "Narrowing",
    "Network",
    "NetworkBuilder",
    "PlanarCurve",
    "Recorded",
    "Road",
    "RoadBuilder",
    "RoadError",
    "Tracker",
    "cycles",
    "join",
    "open_road",
    "read",
    "read_network",
    "shipped",
    "smoothed",
    "write",
]
