"""Blender's end of the engine."""
