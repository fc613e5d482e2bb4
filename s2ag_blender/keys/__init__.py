"""Motion onto the timeline."""
