"""Data sets of others, and the user's own performers, in the project's one format (``core/learning/train/storage.py``)."""
