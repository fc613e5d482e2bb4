"""The gesture model and all it needs; never imports Blender."""
