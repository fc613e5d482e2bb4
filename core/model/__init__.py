"""The Speech2AffectiveGestures network."""
