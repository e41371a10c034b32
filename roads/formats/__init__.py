"""Road files: one module per format, one registry by suffix."""

from .registry import read, read_network, write

__all__ = ["read", "read_network", "write"]
