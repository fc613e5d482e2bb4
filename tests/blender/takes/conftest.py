"""A take to do something with."""

import pytest


@pytest.fixture
def take(speaker, examples):
    """The action of a mannequin's take of the shipped recording, keyed on every frame."""
    from acted import take_of  # imports bpy, which may be absent

    return take_of(speaker, examples / "hello.flac", curves="FRAMES")
