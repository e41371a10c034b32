"""What a car's motors and resistances take, and quasi-static energy: over way, over time, out of a battery."""
