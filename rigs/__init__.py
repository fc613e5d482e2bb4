"""Retargeting of ten joints to any armature: numpy code, and the bone names of rig families as JSON."""
