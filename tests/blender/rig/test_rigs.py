"""Rigs that others made: names found, left and front found, arms exact."""

from dataclasses import replace

import bpy
import found_rigs
import numpy as np
import people
import pytest
import rigging
import skeletons
from bodies import ARM_EDGES, Body, degrees, performance
from s2ag.core.errors import RigUnusable
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.rigs.family import families
from s2ag.rigs.goals import Options
from s2ag.rigs.skeleton import character_frame
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import reading
from solved import detect


def gesture(item, motion=None):
    """Key a motion; returns the mapping and the worst error of the arms in degrees, in the character's own frame."""
    motion = motion or Motion(performance(20, size=1.2))
    bones = reading.read(item)
    mapping = reading.resolve_mapping(item, bones)
    frame = character_frame(bones, mapping)
    apply_motion(item, motion, 1, options=Options(clear_body=False, limits=False))
    chains, worst = mapping.chains, 0.0
    ends = {"upper_arm": "forearm", "forearm": "hand"}
    pairs = {
        edge: (chains[edge][0], chains[edge[: edge.index("_") + 1] + ends[edge.split("_", 1)[1]]][0]) for edge in ARM_EDGES
    }
    wanted = rigging.scene_motion(motion)
    frames = list(range(0, len(wanted), 5))
    for edge, along in rigging.directions(item, pairs, [1 + at for at in frames]).items():
        goal = rigging.in_blender(wanted[frames, skeleton.EDGE_NAMES.index(edge)]) @ frame
        worst = max(worst, degrees(along, goal).max())
    return mapping, worst


def world_front_and_up(item):
    """The front and the up of a character in the world."""
    bones = reading.read(item)
    frame = character_frame(bones, reading.resolve_mapping(item, bones))
    world = np.array(item.matrix_world)[:3, :3]
    return (skeleton.normalize(axis @ world.T) for axis in (-frame[1], frame[2]))


@pytest.mark.slow
def test_rigify_metarig(rigify_saved):
    mapping, worst = gesture(found_rigs.opened(rigify_saved[0]))
    assert mapping.family == "rigify_metarig" and mapping.warnings == ()
    assert mapping.chains["torso"] == ("spine.001", "spine.002", "spine.003")
    assert worst < 0.01


@pytest.mark.slow
def test_rigify_control_rig(rigify_saved):
    item = found_rigs.opened(rigify_saved[1])
    bones = reading.read(item)
    found = reading.resolve_mapping(item, bones)
    assert found.family == "rigify_controls" and found.hips == "torso"
    assert found.chains["torso"] == ("spine_fk.002", "spine_fk.003") and found.chains["head"] == ("head",)
    assert found.chains["right_upper_arm"] == ("upper_arm_fk.R",) and set(found.chains) >= set(skeleton.EDGE_NAMES)
    for switch in next(family for family in families() if family.key == "rigify_controls").switches:
        assert isinstance(item.pose.bones[switch.bone].path_resolve(switch.path), float)
    # What the torso bones of the family move, and what they leave alone.
    pose, moved = item.pose.bones, {}
    for name in ("DEF-spine", "DEF-spine.003"):
        moved[name] = pose[name].matrix.copy()
    for name in found.chains["torso"]:
        pose[name].rotation_mode, pose[name].rotation_quaternion = "QUATERNION", (0.995, 0.0998, 0, 0)
    bpy.context.view_layer.update()
    angles = {
        name: np.degrees(before.to_quaternion().rotation_difference(pose[name].matrix.to_quaternion()).angle)
        for name, before in moved.items()
    }
    assert angles["DEF-spine"] < 0.1 and angles["DEF-spine.003"] > 20


@pytest.mark.parametrize("name", ["Male_Adult_01", "Female_Adult_01"])
def test_rocketbox(shared, name):
    item = found_rigs.rocketbox(shared, name)
    mapping, worst = gesture(item)
    assert mapping.family == "biped" and mapping.chains["left_upper_arm"] == ("Bip01 L UpperArm",)
    assert worst < 0.01
    front, up = world_front_and_up(item)
    np.testing.assert_allclose(up, [0, 0, 1], atol=0.05)
    np.testing.assert_allclose(front, [0, -1, 0], atol=0.05)


def test_mesh2motion_human(shared):
    item = found_rigs.mesh2motion(shared)
    found = reading.resolve_mapping(item, reading.read(item))
    assert found.family == "mesh2motion_controls"
    for switch in next(family for family in families() if family.key == found.family).switches:
        bone = item.pose.bones[switch.bone]
        constraint, value = bone.path_resolve(switch.path.rpartition(".")[0]), switch.path.rpartition(".")[2]
        setattr(constraint, value, switch.value)
    mapping, worst = gesture(item)
    assert mapping.chains["left_forearm"] == ("DRV_forearm_L",) and worst < 0.01


@pytest.mark.parametrize("name", ["default", "mixamo", "game_engine", "cmu_mb", "rigify"])
def test_rigs_of_the_human_by_name_and_by_position(name):
    item = people.armature(name)
    found = reading.resolve_mapping(item, reading.read(item))
    assert set(found.chains) >= set(skeleton.EDGE_NAMES) and found.warnings == ()
    assert {one.how for one in found.findings if one.bones} == {"name"}
    by_position = nameless(reading.read(item))
    arms = [part for part in found.chains if part.startswith(("left", "right")) and not part.endswith("twist")]
    assert {part: by_position.chains[part] for part in arms} == {part: found.chains[part] for part in arms}
    assert by_position.chains["head"] == found.chains["head"] and by_position.hips == found.hips


def nameless(bones):
    """What is found of bones that have numbers for names, in their own names."""
    numbers = tuple(f"{place:03}" for place in range(len(bones.names)))
    found = detect(replace(bones, names=numbers))
    chains = {part: tuple(bones.names[int(name)] for name in chain) for part, chain in found.chains.items()}
    return replace(found, chains=chains, hips=bones.names[int(found.hips)])


@pytest.mark.parametrize("name", ["Male_Adult_01", "Female_Adult_01"])
def test_rocketbox_by_position(shared, name):
    bones = reading.read(found_rigs.rocketbox(shared, name))
    named, placed = detect(bones), nameless(bones)
    assert placed.chains == named.chains
    told = {one.part: one.note for one in named.findings}
    assert told["torso"] == '"Bip01 Spine" carries the legs and stays at rest'
    assert told["neck"] == '"Bip01 Neck" carries the arms and stays at rest'


ANIMALS = ["basic_quadruped", "bird", "cat", "horse", "shark", "wolf"]


@pytest.mark.skipif(bpy.app.version < (5, 0), reason="Blender's module before 5.0 hangs or crashes at exit once Rigify was on")
@pytest.mark.parametrize("animal", ANIMALS)
def test_animals_are_refused_naming_the_arms_and_nothing_changes(animal, wave):
    bpy.ops.preferences.addon_enable(module="rigify")
    getattr(bpy.ops.object, f"armature_{animal}_metarig_add")()
    items = [bpy.context.object]
    if animal in ("basic_quadruped", "horse"):
        bpy.ops.pose.rigify_generate()
        items = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    for item in items:
        before = state(item)
        with pytest.raises(RigUnusable, match=f'^Armature "{item.name}" .* the left upper arm, .* are missing') as caught:
            apply_motion(item, wave(4), 1)
        assert ("four legs" in caught.value.message) == (animal not in ("bird", "shark"))
        assert caught.value.remedy and state(item) == before


def state(item):
    """What a refused armature must keep."""
    animation = item.animation_data
    rest = [tuple(map(tuple, bone.matrix_local)) for bone in item.data.bones]
    pose = [(*bone.rotation_quaternion, *bone.rotation_euler, bone.rotation_mode) for bone in item.pose.bones]
    return rest, pose, animation and (animation.action, len(animation.nla_tracks)), len(bpy.data.actions)


BAD = {
    "no arms": (("Shoulder",), "no bones that look like arms: the left upper arm"),
    "one arm": (
        ("LeftShoulder",),
        "looks like Mixamo, Ready Player Me but has no bone for the left upper arm and the left fore",
    ),
    "no forearms": (("ForeArm",), "has no bone for the left forearm and the right forearm"),
}


@pytest.mark.parametrize("case", BAD)
def test_people_without_arms_are_refused_and_nothing_changes(case, wave):
    words, told = BAD[case]
    family = next(family for family in families() if family.key == "mixamo")
    item = rigging.make_armature(centimetres(skeletons.without(skeletons.person(family), *words)))
    before = state(item)
    with pytest.raises(RigUnusable, match=told) as caught:
        apply_motion(item, wave(4), 1)
    assert "--save map.json" in caught.value.remedy and state(item) == before


def test_two_sets_of_arms_are_refused_until_a_map_chooses(wave):
    family = next(family for family in families() if family.key == "mixamo")
    first, second = skeletons.person(family), skeletons.person(family, prefix="rig:")
    item = rigging.make_armature(centimetres(Body(skeletons.in_order(second.joints | first.joints), {})))
    before = state(item)
    with pytest.raises(RigUnusable, match='"LeftArm" and "rig:LeftArm"'):
        apply_motion(item, wave(4), 1)
    assert state(item) == before
    chosen = reading.resolve_mapping(item, reading.read(item), second.mapping)
    assert chosen.chains["left_upper_arm"] == ("rig:LeftArm",)
    for side in ("Left", "Right"):
        constraint = item.pose.bones[f"{side}Arm"].constraints.new("COPY_TRANSFORMS")
        constraint.target, constraint.subtarget = item, f"rig:{side}Arm"
    assert reading.resolve_mapping(item, reading.read(item)).chains["left_upper_arm"] == ("rig:LeftArm",)


def test_what_is_no_armature_or_has_no_bones(wave):
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    with pytest.raises(RigUnusable, match='"Cube" is not an armature'):
        apply_motion(cube, wave(4), 1)
    item = bpy.data.objects.new("Empty", bpy.data.armatures.new("Empty"))
    bpy.context.collection.objects.link(item)
    with pytest.raises(RigUnusable, match='"Empty" has no bones, so the left upper arm, .* missing'):
        apply_motion(item, wave(4), 1)
    assert cube.animation_data is None and item.animation_data is None and not bpy.data.actions


def test_locked_bones_are_told_part_by_part():
    item = human_like()
    item.pose.bones["Head"].lock_rotation = (True, True, True)
    found = reading.resolve_mapping(item, reading.read(item))
    told = {one.part: one for one in found.findings}
    assert "head" not in found.chains and (told["head"].how, told["head"].bones) == ("", ())
    assert told["head"].note == 'Bone "Head": rotation is locked'


def test_twist_bones_that_the_rig_turns_itself_are_left_alone():
    family = next(family for family in families() if family.key == "unreal")
    item = rigging.make_armature(centimetres(skeletons.person(family)))
    assert reading.resolve_mapping(item, reading.read(item)).chains["left_forearm_twist"] == family.twists["left_forearm_twist"]
    for name in family.twists["left_forearm_twist"]:
        constraint = item.pose.bones[name].constraints.new("COPY_ROTATION")
        constraint.target, constraint.subtarget = item, "hand_l"
    driver = item.driver_add(f'pose.bones["{family.twists["right_forearm_twist"][0]}"].rotation_euler', 1)
    assert driver.driver is not None
    found = reading.resolve_mapping(item, reading.read(item)).chains
    assert "left_forearm_twist" not in found
    assert found["right_forearm_twist"] == family.twists["right_forearm_twist"][1:]


def human_like():
    family = next(family for family in families() if family.key == "mixamo")
    return rigging.make_armature(centimetres(skeletons.person(family)))


def centimetres(figure: Body) -> Body:
    joints = {name: (100 * np.asarray(at, float), above) for name, (at, above) in figure.joints.items()}
    return Body(joints, figure.chains, figure.hips)
