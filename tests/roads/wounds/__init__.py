"""What can be wrong with a map, one function each: `wound(root, rng)` changes the tree."""
