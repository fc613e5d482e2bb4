"""A stored take becomes the stored keys, on a plain figure, a skinned human and a control rig."""

import golden
import golden_keys
import numpy as np
import pytest

ROUNDING = 2 * 64 * float(np.finfo(np.float32).eps)
"""Blender keeps float32, a bone's turn is a chain of at most 64 products, and what is stored was rounded as often."""


@pytest.mark.parametrize("character", golden.RIGS)
def test_keys_are_as_they_were_stored(extension, character):
    with np.load(golden.KEYS) as content:
        stored = {name: values for name, values in content.items() if name.startswith(f"{character}|")}
    keys = {f"{character}|{path}": values for path, values in golden_keys.keys(character).items()}
    assert keys.keys() == {name for name in stored if not name.endswith(":level")}
    golden.assert_equal(keys, stored, ROUNDING)
