"""A recording becomes motions."""
