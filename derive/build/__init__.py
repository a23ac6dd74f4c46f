"""What a generated folder holds: everything of our own, or of what a user names; written or compared."""
