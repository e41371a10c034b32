"""The road files that ship with the package."""

from .shelf import open_road, shipped

__all__ = ["open_road", "shipped"]
