"""Following a trajectory independently of time: projection, tracking laws, and the follower that joins them."""

from .follower import Follower, Following, Preview
from .geometric import GeometricGains, GeometricLaw
from .law import TrackingLaw
from .laws import LAWS, make_law
from .linearising import LinearisingGains, LinearisingLaw
from .pd import PdGains, PdLaw
from .projected import Projected
from .projection import PathProjection

__all__ = [
    "LAWS",
    "Follower",
    "Following",
    "GeometricGains",
    "GeometricLaw",
    "LinearisingGains",
    "LinearisingLaw",
    "PathProjection",
    "PdGains",
    "PdLaw",
    "Preview",
    "Projected",
    "TrackingLaw",
    "make_law",
]
