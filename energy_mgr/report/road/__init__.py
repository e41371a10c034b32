"""What is told of a road or a network."""
