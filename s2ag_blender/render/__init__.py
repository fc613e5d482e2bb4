"""Writes scenes to files: films, images, and exchange formats."""
