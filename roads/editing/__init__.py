"""Making and changing roads: builders, joining, smoothing."""
