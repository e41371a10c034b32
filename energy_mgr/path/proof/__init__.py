"""Proofs about a path that hold everywhere, not at samples: its clearance, its curvature."""
