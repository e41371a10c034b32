"""Roads in tables of text or `.mat`: tracks, edges, paths."""
