"""Edits of a take: its gestures are detected, and what an animator changes is regenerated while the rest stays."""
