"""The dynamics of mechanisms that move freely, as functions of state, inputs and parameters."""
