"""The planting device driven by a motor and a flywheel: its carrier's speed varies over a turn."""
