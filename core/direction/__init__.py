"""Takes are directed: their gestures are found, and what an animator changes is made anew while the rest stays."""
