from . import cycles as cycles
from .builder import RoadBuilder as RoadBuilder
from .corridor import Corridor as Corridor
from .corridor import Narrowing as Narrowing
from .curve import PlanarCurve as PlanarCurve
from .edit import join as join
from .errors import RoadError as RoadError
from .findings import Finding as Finding
from .formats import read as read
from .formats import read_network as read_network
from .formats import write as write
from .gallery import open_road as open_road
from .gallery import shipped as shipped
from .lane import Lane as Lane
from .links import Link as Link
from .network import Network as Network
from .network_builder import NetworkBuilder as NetworkBuilder
from .road import Road as Road
from .smooth import smoothed as smoothed
from .tracker import Tracker as Tracker

__all__ = [
    "Corridor",
    "Finding",
    "Lane",
    "Link",
    "Narrowing",
    "Network",
    "NetworkBuilder",
    "PlanarCurve",
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
