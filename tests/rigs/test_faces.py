"""Faces are recognised by the names of their shape keys, and every closure, blink and look reaches what can show it."""

import json

import numpy as np
import pytest
from s2ag.core.errors import RigUnusable
from s2ag.core.motion.face import CHANNELS, MOUTH
from s2ag.rigs.faces import shapes

FAMILIES = {family.name: family for family in shapes.families()}
OTHERS = ("Basis", "nose wide", "fist", "hat off")


def names(family, prefix=""):
    """Keys of a face of this family, by the first of their names."""
    return tuple(prefix + alike.split("|")[0] for alike in family.keys)


def one(channel, value=1.0):
    weights = np.zeros((1, len(CHANNELS)))
    weights[0, CHANNELS.index(channel)] = value
    return weights


@pytest.mark.parametrize("name", FAMILIES)
def test_every_family_knows_itself_and_says_what_is_missing(name):
    found = shapes.detect((*OTHERS, *names(FAMILIES[name])))
    assert found.family == name and not set(found.keys) & set(OTHERS)
    assert not {"closed lips", "vowels", "blinks", "jaw"} & set(found.missing())
    for part, channels in shapes.PARTS.items():
        without = shapes.Shapes(name, {key: parts for key, parts in found.keys.items()
                                       if not {one.rstrip("+-") for one in parts} & set(channels)})  # fmt: skip
        assert part in without.missing()


@pytest.mark.parametrize("name", FAMILIES)
def test_families_name_channels_that_exist_and_weights_that_are_ones(name):
    for parts in FAMILIES[name].keys.values():
        assert all(channel.rstrip("+-") in CHANNELS and 0 < weight <= 1 for channel, weight in parts.items())
    assert set(FAMILIES[name].rest) <= set(MOUTH)


def test_names_as_programs_write_them():
    vroid = shapes.detect(names(FAMILIES["VRoid Studio"], "Face.M_F00_000_00_Fcl_"))
    assert vroid.family == "VRoid Studio" and "Face.M_F00_000_00_Fcl_MTH_A" in vroid.keys
    vrchat = shapes.detect(tuple(f"vrc.v_{name}" for name in ("pp", "ff", "th", "dd", "aa", "e", "ih", "oh", "ou")))
    assert vrchat.family == "Oculus visemes" and len(vrchat.keys) == 9
    assert shapes.detect(("JawOpen", "MouthFunnel", "mouth_pucker", "eyeBlinkLeft", "mouthRollLower")).family == "ARKit 52"
    assert shapes.detect(("あ", "い", "う", "え", "お", "まばたき")).family == "MMD"
    assert shapes.detect(OTHERS) is None and shapes.detect(()) is None


def test_a_blink_is_one_blink():
    both = shapes.detect(names(FAMILIES["VRM expressions"]))
    assert "blink" not in both.keys and {"blinkLeft", "blinkRight"} <= both.keys.keys()
    single = shapes.detect(("A", "I", "U", "E", "O", "Blink"))
    wink, blink = one("BLINK_LEFT"), one("BLINK_LEFT") + one("BLINK_RIGHT")
    assert single.values(blink)["Blink"] == 1 and single.values(wink)["Blink"] == 0.5


def test_eyes_look_to_the_side_that_is_asked_for():
    face = shapes.detect(names(FAMILIES["ARKit 52"]))
    left, right = (face.values(one("LOOK_LEFT", value)) for value in (0.5, -0.5))
    assert left["eyeLookOutLeft"] == left["eyeLookInRight"] > 0 == left["eyeLookInLeft"] == left["eyeLookOutRight"]
    assert right["eyeLookOutRight"] == right["eyeLookInLeft"] > 0 == right["eyeLookOutLeft"]


def test_closed_lips_open_nothing():
    for family in FAMILIES.values():
        values = shapes.detect(names(family)).values(one("PP"))
        opening = [key for key, parts in family.keys.items() if {"AA", "JAW"} & parts.keys()]
        assert opening and all(not values[key.split("|")[0]].any() for key in opening)


def test_values_stay_within_one():
    face = shapes.detect(names(FAMILIES["VRM expressions"]))
    assert all(((column >= 0) & (column <= 1)).all() for column in face.values(np.ones((3, len(CHANNELS)))).values())


def test_maps_are_written_edited_and_read(tmp_path):
    face = shapes.detect(names(FAMILIES["MMD"]))
    shapes.save(tmp_path / "face.json", face)
    assert shapes.load(tmp_path / "face.json") == face
    content = json.loads((tmp_path / "face.json").read_text("utf-8"))
    content["keys"]["帽子"] = {"LOOK_UP-": 0.3}
    (tmp_path / "face.json").write_text(json.dumps(content))
    assert shapes.load(tmp_path / "face.json").keys["帽子"] == {"LOOK_UP-": 0.3}


@pytest.mark.parametrize("content", ["", "[]", "{}", "NOSE 1", 'AA "1"', "AA+ 1"])
def test_broken_maps_are_refused_in_a_sentence(content, tmp_path):
    name, _, weight = content.partition(" ")
    text = f'{{"face_map": 1, "keys": {{"a": {{"{name}": {weight}}}}}}}' if weight else content
    (tmp_path / "face.json").write_text(text)
    with pytest.raises(RigUnusable):
        shapes.load(tmp_path / "face.json")
    with pytest.raises(RigUnusable):
        shapes.load(tmp_path / "none.json")


def test_a_key_that_shows_nothing_stays_at_zero():
    made = shapes.Shapes("own", {"nothing": {}, "open": {"AA": 1.0}}).values(np.ones((4, len(CHANNELS))))
    assert made["nothing"].tolist() == [0] * 4 and made["open"].tolist() == [1] * 4
