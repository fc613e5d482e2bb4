"""Styles of one's own, learned from motion: its source, its figures of manner, the fit, and how well that goes."""
