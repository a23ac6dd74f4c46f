"""The Reuleaux-pentagon clutch of shi2021: its shape, its engagement, its field test."""
