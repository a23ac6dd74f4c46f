"""What a paper does not disclose of a planting device: bounds for it, and what the force can be within them."""
