"""Are these gestures worth keeping? Figures on motions, and the report of ``s2ag evaluate``."""
