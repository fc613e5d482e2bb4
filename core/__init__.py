"""The gesture model, synthesis and tools; never imports Blender."""
