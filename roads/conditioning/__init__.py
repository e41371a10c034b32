"""From what a receiver recorded to a road: outliers, stops and turning points, the plane and the heights smoothed within an accuracy."""
