"""What is told of a plan: table, figure, files, and of many: the front."""
