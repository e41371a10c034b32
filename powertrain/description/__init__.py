"""A car's description: the sections of its TOML file with their ranges, and how files are read."""
