"""Reads an armature's rest pose and mapping, and solves poses on it."""
