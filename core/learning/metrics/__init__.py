"""Metrics of the paper and of the field, in the published code's definition and in true units (reference section F)."""
