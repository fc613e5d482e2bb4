"""A door for scripts from before the rooms: ``s2ag_blender.keys.apply`` under its old name."""

from .keys.apply import apply_motion

__all__ = ["apply_motion"]
