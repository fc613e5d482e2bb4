"""Who is keyed."""

import pytest


@pytest.fixture
def actor(figure, voice):
    """A mannequin with a recording of three seconds, from frame 10 on."""
    figure.s2ag.audio, figure.s2ag.start_frame = str(voice), 10
    return figure
