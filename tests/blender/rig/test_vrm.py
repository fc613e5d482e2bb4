"""The map that the VRM add-on keeps on an armature: of VRM 1 and 0, with the add-on and without it."""

import bpy
import numpy as np
import pytest
import rigging
import skeletons
from bodies import Body
from s2ag.rigs.family import families
from s2ag.s2ag_blender.rig import reading, vrm

FIGURE, WAS = skeletons.renamed(skeletons.person(next(one for one in families() if one.key == "vrm"), "A"), seed=4)
HUMANS = {
    human: name
    for part, humans in vrm._PARTS.items()
    if part not in ("hips", "torso")
    for human in humans
    for name in FIGURE.chains[part]
}
HUMANS |= {"hips": FIGURE.hips, **dict(zip(vrm._PARTS["torso"], FIGURE.chains["torso"], strict=True))}


def armature():
    """A person whose bones have names that tell nothing, scattered so that positions tell nothing either."""
    joints = {name: (100 * np.asarray(at), None) for name, (at, _) in FIGURE.joints.items()}
    return rigging.make_armature(Body(joints, {}))


def camel(name: str) -> str:
    first, *others = name.split("_")
    return first + "".join(word.title() for word in others)


def newer(humans):
    return {
        "spec_version": "1.0",
        "vrm1": {"humanoid": {"human_bones": {k: {"node": {"bone_name": v}} for k, v in humans.items()}}},
    }


def older(humans):
    bones = [{"bone": camel(human), "node": {"bone_name": name}} for human, name in humans.items()]
    return {"spec_version": "0.0", "vrm0": {"humanoid": {"human_bones": bones}}}


@pytest.mark.parametrize(
    "make", [newer, older, lambda humans: newer({}) | older(humans)], ids=["1", "0", "0 beside an empty 1"]
)
def test_a_map_kept_as_plain_data(make):
    item = armature()
    item.data["vrm_addon_extension"] = make(HUMANS)
    found = reading.resolve_mapping(item, reading.read(item))
    assert (found.family, found.chains, found.hips) == (vrm.FAMILY, FIGURE.chains, FIGURE.hips)
    assert {one.how for one in found.findings} == {"map"} and found.warnings == ()


def test_bones_meant_by_their_marks():
    item = armature()
    marks = {name: f"mark of {name}" for name in HUMANS.values()}
    for name, mark in marks.items():
        item.data.bones[name]["vrm_addon_extension"] = {"uuid": mark}
    nodes = {human: {"node": {"bone_uuid": marks[name]}} for human, name in HUMANS.items()}
    item.data["vrm_addon_extension"] = {"vrm1": {"humanoid": {"human_bones": nodes}}}
    assert reading.resolve_mapping(item, reading.read(item)).chains == FIGURE.chains


def test_bones_that_are_gone_and_half_a_map():
    item = armature()
    humans = HUMANS | {"left_shoulder": "gone", "neck": ""}
    item.data["vrm_addon_extension"] = newer(humans)
    found = reading.resolve_mapping(item, reading.read(item))
    assert "left_clavicle" not in found.chains and "neck" not in found.chains
    assert found.chains["head"] == FIGURE.chains["head"]
    for strange in ({}, {"vrm1": 3}, {"vrm1": {"humanoid": {}}}, {"vrm0": {"humanoid": {"human_bones": []}}}):
        item.data["vrm_addon_extension"] = strange
        assert vrm.humanoid(item) is None
    del item.data["vrm_addon_extension"]
    assert vrm.humanoid(item) is None


class Node(bpy.types.PropertyGroup):
    bone_name: bpy.props.StringProperty()


class HumanBone(bpy.types.PropertyGroup):
    node: bpy.props.PointerProperty(type=Node)


class OldBone(bpy.types.PropertyGroup):
    bone: bpy.props.StringProperty()
    node: bpy.props.PointerProperty(type=Node)


HumanBones = type(
    "HumanBones",
    (bpy.types.PropertyGroup,),
    {"__annotations__": {human: bpy.props.PointerProperty(type=HumanBone) for human in HUMANS}},
)


class NewHumanoid(bpy.types.PropertyGroup):
    human_bones: bpy.props.PointerProperty(type=HumanBones)


class OldHumanoid(bpy.types.PropertyGroup):
    human_bones: bpy.props.CollectionProperty(type=OldBone)


class Vrm1(bpy.types.PropertyGroup):
    humanoid: bpy.props.PointerProperty(type=NewHumanoid)


class Vrm0(bpy.types.PropertyGroup):
    humanoid: bpy.props.PointerProperty(type=OldHumanoid)


class Extension(bpy.types.PropertyGroup):
    spec_version: bpy.props.EnumProperty(items=[("0.0", "0.0", ""), ("1.0", "1.0", "")])
    vrm1: bpy.props.PointerProperty(type=Vrm1)
    vrm0: bpy.props.PointerProperty(type=Vrm0)


CLASSES = (Node, HumanBone, OldBone, HumanBones, NewHumanoid, OldHumanoid, Vrm1, Vrm0, Extension)


@pytest.fixture
def addon():
    """Properties laid out as the add-on's; yields a function that removes them, as an absent add-on has none."""
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Armature.vrm_addon_extension = bpy.props.PointerProperty(type=Extension)
    present = [True]

    def leave():
        if present:
            present.clear()
            del bpy.types.Armature.vrm_addon_extension
            for one in reversed(CLASSES):
                bpy.utils.unregister_class(one)

    yield leave
    leave()


@pytest.mark.parametrize("version", ["1.0", "0.0"])
def test_registered_properties_and_the_file_without_the_addon(addon, version, tmp_path):
    item = armature()
    extension = item.data.vrm_addon_extension
    assert vrm.humanoid(item) is None
    extension.spec_version = version
    for human, name in HUMANS.items():
        if version == "1.0":
            getattr(extension.vrm1.humanoid.human_bones, human).node.bone_name = name
        else:
            entry = extension.vrm0.humanoid.human_bones.add()
            entry.bone, entry.node.bone_name = camel(human), name
    found = reading.resolve_mapping(item, reading.read(item))
    assert (found.family, found.chains, found.hips) == (vrm.FAMILY, FIGURE.chains, FIGURE.hips)
    path = str(tmp_path / "avatar.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    addon()
    bpy.ops.wm.open_mainfile(filepath=path)
    again = next(item for item in bpy.data.objects if item.type == "ARMATURE")
    assert vrm.humanoid(again).chains == FIGURE.chains
