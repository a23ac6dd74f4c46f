"""What this installation has, and what would make it faster."""
