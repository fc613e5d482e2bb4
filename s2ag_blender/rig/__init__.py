"""Reading an armature, and solving a pose on it."""
