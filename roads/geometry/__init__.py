"""Curves in the plane: cubics, clothoids, nearest places, crossings."""
