"""What a .blend stores of ours, damaged by others: it is what we wrote, or it counts as nothing; no button fails over it."""

import contextlib
import json
import random

import bpy
import mutations
import pytest
from s2ag.core.errors import S2agError
from s2ag.s2ag_blender import compat, json_properties, provenance
from s2ag.s2ag_blender.keys import density, faces, keyframes, layers, test_pose
from s2ag.s2ag_blender.rig import facemaps
from s2ag.s2ag_blender.takes import control_curves, drafts, generate, retiming, sound_strips, stored_settings, take_list

pytestmark = pytest.mark.slow


@pytest.fixture
def laid(figure, voice, wave):
    """A mannequin with an action of ours."""
    figure.s2ag.audio = str(voice)
    motion = wave(46)
    motion.meta.update({"style": "still", "seed": 3, "take": 0, "checkpoint": "abc"})
    generate.finish(generate.plan(bpy.context, figure), {"motions": [motion]})
    return figure


def used(armature, action):
    """All that reads what is stored on an action."""
    told = provenance.read(action)
    place = layers.Place.of(action)
    if place is not None:
        assert place.overlaps(place.first, place.last) or place.first > place.last
        assert density.most_keys(action) >= 0 and isinstance(density.is_dense(action), bool)
    layers.is_draft(action)
    layers.base_action(armature, 1, 30)
    keyframes.restore_former_values(armature, action)
    if told is not None:
        take_list.title(armature, action)
        if "settings" in told and "seed" in told:
            with contextlib.suppress(S2agError):
                stored_settings.restore(armature.s2ag, told["settings"])


@pytest.mark.parametrize("name", [provenance.PROPERTY, keyframes.FORMER, density.KEYED])
def test_damaged_properties_of_an_action(laid, name):
    action = laid.animation_data.action
    good = action[name]
    others = [good.encode()]
    for number in range(150):
        chance = random.Random(f"{name} {number}")
        action[name] = mutations.of_json(good.encode(), chance, others).decode("utf-8", "replace").replace("\0", "")
        used(laid, action)
        action[name] = good
    used(laid, action)


DAMAGED = ["", "[", "[]", '{"muted": 3}', '{"a": 1}', "[" * 5000, '{"action_influence": "x", "muted": [[]]}']


@pytest.mark.parametrize("text", DAMAGED, ids=range(len(DAMAGED)))
def test_damaged_properties_of_a_character(laid, text):
    laid[drafts.STAGED], laid[test_pose.BEFORE] = text, text
    drafts.drop(laid)
    test_pose.end_test_pose(laid)
    assert drafts.STAGED not in laid and test_pose.BEFORE not in laid


ODD = (0, 3.5, True, "x", [0.0, 1.0], [1, 2, 3, 4], {"a": 1}, bytes(3), float("nan"), "character", "scene")
"""Values of all kinds that a custom property may hold; the last two stand for pointers to what is no action."""


@pytest.mark.parametrize("value", ODD, ids=str)
def test_properties_of_other_kinds_count_as_nothing(laid, voice, wave, value):
    value = {"character": laid, "scene": bpy.context.scene}.get(value, value) if isinstance(value, str) else value
    action = laid.animation_data.action
    strip = next(iter(compat.sound_strips(bpy.context.scene)), None)
    if strip is None:
        pytest.skip("this Blender was built without sound")
    for name in ("s2ag_slot", "s2ag_base", layers.BEFORE, "s2ag_face_action_0", "s2ag_face_base_0", sound_strips.TAG):
        action[name] = value
    for owner, name in ((strip, sound_strips.TAG), (strip, "s2ag_silenced"), (laid, facemaps.OWN), (laid, drafts.STAGED)):
        owner[name] = value
    action[faces.FACES] = json.dumps([{"key": key.name, "slot": "x", "before": {}} for key in bpy.data.shape_keys] or
                                     [{"key": "Key", "slot": "x", "before": {}}])  # fmt: skip
    used(laid, action)
    drafts.drop(laid)
    facemaps.read_face_map(laid)
    generate.finish(generate.plan(bpy.context, laid), {"motions": [wave(46)]})
    layers.hide(laid, action)
    layers.show(laid, action)
    sound_strips.unmute_strip_of(laid, action)
    sound_strips.remove_unused()
    retiming.strip_of_take(action, bpy.context.scene)


@pytest.mark.parametrize("draft", [False, True], ids=["take", "draft"])
@pytest.mark.parametrize("length", [1, 2, 3])
def test_links_in_a_circle_lead_nowhere(laid, draft, length):
    """Remap Users makes such circles."""
    first = laid.animation_data.action
    circle = [first, *(first.copy() for _ in range(length - 1))]
    for action, following in zip(circle, [*circle[1:], first], strict=True):
        action["s2ag_base"] = action[layers.BEFORE] = following
        if draft:
            provenance.stamp(action, provenance.require(action) | {layers.DRAFT: True})
    place = layers.Place.of(first)
    assert layers.base_action(laid, place.first, place.last) is None
    assert control_curves.keyed_curves(laid) == {}
    drafts.drop(laid)
    if not draft:
        layers.hide(laid, first)


def test_nothing_but_numbers_is_set_by_what_a_file_says(laid):
    """A driver's expression would run with the next frame."""
    curve = laid.driver_add("location", 0)
    curve.driver.expression = "1.0"
    action, name = laid.animation_data.action, laid.name
    told = {"animation_data.drivers[0].driver.expression": "2.0", "name": "other", "location": ["x"] * 3}
    action[keyframes.FORMER] = json.dumps(told)
    keyframes.restore_former_values(laid, action)
    assert curve.driver.expression == "1.0" and laid.name == name


STORED = [("{}", dict, {}), ("[1]", list, [1]), ("[1]", dict, {}), (3, dict, {}), ("{", list, [])]


@pytest.mark.parametrize(("value", "kind", "found"), STORED)
def test_what_is_stored_is_of_its_kind(value, kind, found):
    assert json_properties.read({"a": value}, "a", kind) == found and json_properties.read({}, "a", kind) == kind()


@pytest.mark.parametrize("text", ["[", "[" * 5000, "3", '[[1], null, "hand"]'])
def test_bones_that_stand_are_names_or_nothing(laid, text):
    action = laid.animation_data.action
    action[density._STOOD] = text
    density.convert(laid, action, None, 30.0)
    density.convert(laid, action, 0.01, 30.0)
    assert density.most_keys(action) > 0
