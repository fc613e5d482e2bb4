"""The process that Blender talks to."""
