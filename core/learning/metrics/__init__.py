"""Metrics of the paper and of the field, as in the published code and in physical units (reference section F)."""
