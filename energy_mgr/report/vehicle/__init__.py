"""What is told of a car and of its driving cycles."""
