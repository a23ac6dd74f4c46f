"""Results as records, the JSON schema of each, and how a notebook shows them."""

from planter.records.record import Record, WarningRecord

__all__ = ["Record", "WarningRecord"]
