"""Converts public data sets and the user's own recordings to the project's format (``core/learning/train/storage.py``)."""
