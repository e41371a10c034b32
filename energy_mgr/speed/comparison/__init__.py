"""The same programmes by other means, to hold the main method to account: cones, dynamic programming, IPOPT."""
