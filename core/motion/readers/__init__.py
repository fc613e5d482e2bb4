"""Readers of recorded and generated motion: files and skeletons of others become a :class:`Motion`."""
