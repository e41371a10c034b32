"""Components and their losses, each from its own section of the description: machines, brakes, steering, supply."""
