from .builder import RoadBuilder as RoadBuilder
from .corridor import Corridor as Corridor
from .curve import PlanarCurve as PlanarCurve
from .errors import RoadError as RoadError
from .formats import read as read
from .formats import write as write
from .gallery import open_road as open_road
from .gallery import shipped as shipped
from .road import Lane as Lane
from .road import Road as Road

__all__ = [
    "Corridor",
    "Lane",
    "PlanarCurve",
    "Road",
    "RoadBuilder",
    "RoadError",
    "open_road",
    "read",
    "shipped",
    "write",
]
