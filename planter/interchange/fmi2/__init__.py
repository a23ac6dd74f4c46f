"""Units for co-simulation by the Functional Mock-up Interface, version 2.0 (https://fmi-standard.org)."""
