from .drive.animation import animate_drive as animate_drive
from .drive.figure import draw_drive as draw_drive
from .drive.files import save_drive as save_drive
from .drive.table import drive_table as drive_table
from .plan.figure import draw_plan as draw_plan
from .plan.files import save_plan as save_plan
from .road.table import network_table as network_table
from .road.table import road_table as road_table
from .road.table import route_table as route_table
from .road.table import save_road_figure as save_road_figure
from .plan.table import comparison_table as comparison_table
from .vehicle.table import save_vehicle_figure as save_vehicle_figure
from .vehicle.table import vehicle_table as vehicle_table

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
