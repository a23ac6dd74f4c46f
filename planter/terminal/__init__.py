"""What commands take and say on a terminal."""
