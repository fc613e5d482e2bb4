"""The full engine's own Python environment: planned, made, tried and found. Needs no numpy; Blender only finds and tries."""
