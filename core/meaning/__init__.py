"""Semantic gestures: phrases that have a gesture of their own, and how it is added to a motion."""
