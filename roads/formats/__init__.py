"""Road files: one module per format, one registry by suffix."""

from .registry import read, write

__all__ = ["read", "write"]
