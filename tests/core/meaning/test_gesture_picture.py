"""Pictures of the kinds of gesture: each is another one, with the figure in it and nothing at its edges."""

import numpy as np
from s2ag.core.meaning import gesture_picture, vocabulary


def test_every_kind_has_a_picture_of_its_own():
    pictures = {name: gesture_picture.draw(one) for name, one in vocabulary.load_vocabulary().gestures.items()}
    assert len({picture.tobytes() for picture in pictures.values()}) == len(pictures)
    for name, picture in pictures.items():
        assert picture.shape == (gesture_picture.SIZE, gesture_picture.SIZE, 4) and 0 <= picture.min() <= picture.max() <= 1
        assert 0.05 < (picture[..., 3] > 0.5).mean() < 0.4, name


def test_the_hand_that_shows_it_is_the_coloured_one():
    shown = vocabulary.load_vocabulary().gestures
    orange = {name: gesture_picture.draw(shown[name])[..., 0] > 0.9 for name in ("left", "right")}
    columns = {name: np.flatnonzero(marked.any(0)).mean() for name, marked in orange.items()}
    assert columns["right"] < gesture_picture.SIZE / 2 < columns["left"]  # seen from the front
