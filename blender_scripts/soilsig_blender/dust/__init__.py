"""Fines on grains: where they sit, how much they cover, and the dusty grain that comes of it."""
