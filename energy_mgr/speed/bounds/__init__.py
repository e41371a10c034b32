"""What bounds the speed along a path."""
