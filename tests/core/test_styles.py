import struct
from pathlib import Path

import numpy as np
import pytest
from s2ag.core import styles
from s2ag.core.errors import UnknownStyle, UsageError
from s2ag.core.model import checkpoint_metadata

NAMES = ["calm lecturer", "eager storyteller", "stern"]


def test_a_name_in_any_spelling_is_the_speaker():
    assert styles.parse("Calm_Lecturer", NAMES) == {0: 1.0}
    assert styles.parse("eager-storyteller", NAMES) == {1: 1.0}


def test_blends_are_normalised_and_repeated_names_add_up():
    assert styles.parse("calm lecturer:1+stern:3", NAMES) == {0: 0.25, 2: 0.75}
    assert styles.parse({"stern": 2, "Stern": 2}, NAMES) == {2: 1.0}


IMPOSSIBLE = ["calm lecturer:0", "stern:-1", "stern:x", "stern:nan", "", "+", "stern:1e308+calm lecturer:1e308", "stern:1e-320"]


@pytest.mark.parametrize("expression", IMPOSSIBLE)
def test_impossible_weights_are_refused(expression):
    with pytest.raises(UnknownStyle):
        styles.parse(expression, NAMES)


def test_an_unknown_style_lists_the_near_ones():
    with pytest.raises(UnknownStyle) as error:
        styles.parse("calm lectures", NAMES)
    assert "calm lecturer" in error.value.remedy and "stern" not in error.value.remedy


def test_the_default_is_the_speaker_marked_so_or_the_first():
    assert styles.default_speaker([{"name": "a"}, {"name": "b", "default": True}]) == "b"
    assert styles.default_speaker([{"name": "a"}, {"name": "b"}]) == "a"


def test_latents():
    rng = np.random.default_rng(0)
    mean, deviation = rng.normal(size=(3, 16)), np.full((3, 16), 0.1)
    named = styles.sample_styles({1: 1.0}, mean, deviation, seed=4, takes=3)
    np.testing.assert_allclose(named[0], mean[1], atol=1e-6)
    assert not np.allclose(named[1], named[2])
    blend = styles.sample_styles({0: 0.5, 1: 0.5}, mean, deviation, seed=4, takes=1)
    np.testing.assert_allclose(blend[0], mean[:2].mean(0), atol=1e-6)
    drawn = styles.sample_styles(None, mean, deviation, seed=4, takes=2)
    assert np.array_equal(drawn, styles.sample_styles(None, mean, deviation, seed=4, takes=2))
    assert not np.allclose(drawn, styles.sample_styles(None, mean, deviation, seed=5, takes=2))


def test_controls_stand_in_the_networks_order():
    values = styles.controls({"dominance": -0.5, "arousal": 1}, rate=0.25, hand=-1)
    assert values.dtype == np.float32
    assert dict(zip(styles.CONTROLS, values.tolist(), strict=True)) == {
        "arousal": 1, "valence": 0, "dominance": -0.5, "rate": 0.25, "hand": -1
    }  # fmt: skip
    assert not styles.controls({}).any()


@pytest.mark.parametrize(
    "wrong",
    [
        ({"joy": 0.5},),
        ({"rate": 0.5},),
        ({"arousal": 1.01},),
        ({"arousal": float("nan")},),
        ({"arousal": "high"},),
        ({"arousal": True},),
        ({"arousal": None},),
        ({}, -2),
        ({}, 0, float("inf")),
    ],
)
def test_impossible_controls_are_refused(wrong):
    with pytest.raises(UsageError) as error:
        styles.controls(*wrong)
    assert error.value.remedy


def test_an_unknown_affect_lists_the_known():
    with pytest.raises(UsageError, match="'joy'") as error:
        styles.controls({"joy": 0.5})
    assert all(name in error.value.remedy for name in styles.AFFECTS)


def test_every_control_is_explained():
    assert [one["name"] for one in styles.describe_controls(len(styles.CONTROLS))] == list(styles.CONTROLS)
    assert all(one["description"] for one in styles.describe_controls(5)) and styles.describe_controls(0) == []


def test_every_shipped_style_has_a_small_picture():
    """As docs/style_pictures.py draws them; no two are the same."""
    folder = Path(styles.__file__).parent / "assets" / "styles"
    pictures = {path.stem: path.read_bytes() for path in folder.iterdir()}
    facts = checkpoint_metadata.describe(checkpoint_metadata.locate(""))
    assert pictures.keys() == {one["name"] for one in facts["speakers"]} and len(set(pictures.values())) == len(pictures)
    for content in pictures.values():
        assert content[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", content[16:24]) == (64, 64) and len(content) < 3000
