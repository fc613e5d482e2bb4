"""Losses, data set and training loop."""
