"""The fastest speed: forward and backward, and by TOPP-RA."""
