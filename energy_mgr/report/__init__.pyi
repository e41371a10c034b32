from .animation import animate_drive as animate_drive
from .drive_figure import draw_drive as draw_drive
from .drive_files import save_drive as save_drive
from .drive_table import drive_table as drive_table
from .figure import draw_plan as draw_plan
from .files import save_plan as save_plan
from .road_table import network_table as network_table
from .road_table import road_table as road_table
from .road_table import route_table as route_table
from .road_table import save_road_figure as save_road_figure
from .table import comparison_table as comparison_table
from .vehicle_table import save_vehicle_figure as save_vehicle_figure
from .vehicle_table import vehicle_table as vehicle_table

__all__ = [
    "animate_drive",
    "comparison_table",
    "draw_drive",
    "draw_plan",
    "drive_table",
    "network_table",
    "road_table",
    "route_table",
    "save_drive",
    "save_plan",
    "save_road_figure",
    "save_vehicle_figure",
    "vehicle_table",
]
