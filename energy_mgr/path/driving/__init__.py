"""The path while driving: window after window of the road, joined, within a time."""
