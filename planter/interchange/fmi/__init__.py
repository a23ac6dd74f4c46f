"""Units for co-simulation by the Functional Mock-up Interface, versions 2.0 and 3.0 (https://fmi-standard.org)."""
