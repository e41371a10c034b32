from .figure import draw_plan as draw_plan
from .files import save_plan as save_plan
from .table import comparison_table as comparison_table

__all__ = ["comparison_table", "draw_plan", "save_plan"]
