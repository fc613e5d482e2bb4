"""What the shipped weights perform is what they performed: all styles on two voices, other settings, and edited takes.

Numbers are compared within float32 rounding, carried through the network (:mod:`rounding`), so that another CPU passes.
"""

import golden
import numpy as np
import pytest
from rounding import bound
from s2ag.core.synthesis.session import Session


@pytest.fixture(scope="module")
def shared_or_none(request):
    folder = request.config.rootpath.parent / "shared" / "data"
    return folder if folder.is_dir() else None


@pytest.fixture(scope="module")
def performed(shared_or_none):
    return {name: (step, motion) for name, step, motion in golden.perform(shared_or_none)}


@pytest.fixture(scope="module")
def stored():
    with np.load(golden.MOTIONS) as content:
        return dict(content)


def test_every_motion_is_as_it_was_stored(performed, stored):
    most = bound(Session().checkpoint)
    for name, (step, motion) in performed.items():
        golden.assert_equal({f"{name}:{part}": values for part, values in golden.sampled(motion, step).items()}, stored, most)


def test_every_provenance_is_as_it_was_stored(performed, stored):
    for name, (_, motion) in performed.items():
        assert golden.described(motion) == str(stored[f"{name}:meta"]), name


def test_all_styles_are_stored_on_two_voices(stored):
    styles = [style["name"] for style in Session().styles()]
    expected = {f"{voice}/{style}" for voice in golden.STEPS for style in styles}
    assert len(styles) == 24 and expected <= {name.split(":")[0] for name in stored}


def test_another_motion_is_told_from_the_stored_one(performed, stored):
    step, motion = performed["hello/stern"]
    wrong = {f"hello/diplomat:{part}": values for part, values in golden.sampled(motion, step).items()}
    with pytest.raises(AssertionError):
        golden.assert_equal(wrong, stored, bound(Session().checkpoint))
