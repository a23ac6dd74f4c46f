"""The studio without a server: one HTML file that computes a machine in the browser."""
