"""What is told of a drive: table, figure, film, files."""
