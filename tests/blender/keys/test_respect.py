"""What belongs to the user stays as it is: everything but one new action, before, after and when something goes wrong."""

import bpy
import numpy as np
import pytest
import rigging
from bodies import Body, body, performance, turned_degrees
from exactness import EXACT, arm_error
from removing import remove_motion
from s2ag.core.motion import quaternion
from s2ag.core.motion.motion import Motion
from s2ag.rigs.relative_turns import NEUTRAL, torso_turn
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import controls, reading, solver

COLLECTIONS = ("objects", "armatures", "scenes", "collections", "actions", "meshes", "curves", "worlds", "node_groups")


def entangle(item) -> None:
    """Give a plain rig constraints and bones that inherit nothing, so that it has to be measured; its arms stay free."""
    for name in ("spine2", "right_fore"):
        item.data.bones[name].use_inherit_rotation = False
    copy = item.pose.bones["left_upper"].constraints.new("COPY_ROTATION")
    copy.target, copy.subtarget, copy.mix_mode, copy.influence = item, "neck", "BEFORE", 0.5
    copy.target_space = copy.owner_space = "LOCAL"


@pytest.fixture(params=["plain", "measured"])
def rigged(request):
    """A body and its armature, for either solver."""
    whole = body()
    item = rigging.make_armature(whole, seed=4)
    if request.param == "measured":
        entangle(item)
    return whole, item


def apply(item, whole, motion, **options):
    return apply_motion(item, motion, 1, mapping=whole.chains, options=EXACT, **options)


def worst(item, whole, motion) -> float:
    """Degrees by which arms miss their directions, at worst."""
    return arm_error(item, motion, mapping_of(item, whole))


def mapping_of(item, whole):
    return reading.resolve_mapping(item, reading.read(item), whole.chains)


def snapshot(item) -> dict:
    """Everything of a file that a gesture must leave alone, to the bit."""
    context, scene = bpy.context, bpy.context.scene
    pose = {
        bone.name: (
            [list(row) for row in bone.matrix_basis],
            bone.rotation_mode,
            list(bone.rotation_quaternion),
            list(bone.rotation_euler),
            list(bone.lock_rotation),
            [(one.name, one.type, one.influence, one.mute) for one in bone.constraints],
        )
        for bone in item.pose.bones
    }
    return {
        "rest": {bone.name: ([list(row) for row in bone.matrix_local], bone.length) for bone in item.data.bones},
        "pose": pose,
        "object": [list(row) for row in item.matrix_world] + [list(item.scale), list(item.rotation_euler), item.mode],
        "frame": (scene.frame_current, scene.frame_subframe, scene.frame_start, scene.frame_end),
        "scene": (scene.name, context.view_layer.name, context.mode),
        "selected": sorted(thing.name for thing in bpy.data.objects if thing.select_get(view_layer=context.view_layer)),
        "active": context.view_layer.objects.active.name if context.view_layer.objects.active else None,
        "data": {name: sorted(block.name for block in getattr(bpy.data, name)) for name in COLLECTIONS if name != "actions"},
        "users": (item.users, item.data.users),
        "handlers": len(bpy.app.handlers.depsgraph_update_post),
    }


@pytest.mark.parametrize("mode", ["OBJECT", "POSE"])
def test_the_file_is_the_same_but_for_one_action(mode, rigged):
    whole, item = rigged
    bpy.context.view_layer.objects.active = item
    bpy.ops.object.mode_set(mode=mode)
    scene = bpy.context.scene
    scene.frame_set(7, subframe=0.25)
    item.pose.bones["left_hand"].rotation_mode = "ZXY"
    item.pose.bones["left_hand"].rotation_euler = (0.3, 0.1, 0)
    calls = []
    bpy.app.handlers.depsgraph_update_post.append(lambda *_: calls.append(1))
    bpy.context.view_layer.update()
    before, calls[:] = snapshot(item), []
    action = apply(item, whole, Motion(performance(12, size=0.4)))
    assert not calls
    after = snapshot(item)
    assert before == after
    assert [one.name for one in bpy.data.actions] == [action.name]


def test_the_rest_pose_is_bit_identical_after_playing(rigged):
    whole, item = rigged
    before = snapshot(item)["rest"]
    apply(item, whole, Motion(performance(12, size=0.4)))
    for frame in (1, 5, 9):
        bpy.context.scene.frame_set(frame)
    assert snapshot(item)["rest"] == before


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_errors_and_interruptions_leave_nothing_behind(monkeypatch, error):
    whole = body()
    item = rigging.make_armature(whole)
    entangle(item)
    bpy.context.view_layer.update()
    before = snapshot(item)
    steps = []

    def pose(self, *arguments):
        steps.append(1)
        if len(steps) == 20:
            raise error("in the middle")

    monkeypatch.setattr(controls.RigCopy, "pose", pose)
    with pytest.raises(error):
        apply(item, whole, Motion(performance(12, size=0.4)))
    assert snapshot(item) == before and not len(bpy.data.actions)


def test_locked_bones_get_no_keys_and_arms_make_up_for_them(rigged):
    whole, item = rigged
    item.pose.bones["spine3"].lock_rotation = (True, True, True)
    item.pose.bones["left_clavicle"].rotation_mode = "XYZ"
    item.pose.bones["left_clavicle"].lock_rotation = (False, True, False)
    item.pose.bones["neck"].lock_rotation = (True, False, False)
    motion = Motion(performance(12, size=0.4))
    action = apply(item, whole, motion)
    keyed = {(curve.group.name, curve.array_index) for curve in compat.curves(action) if curve.group}
    assert not any(name == "spine3" for name, _ in keyed)
    assert {index for name, index in keyed if name == "left_clavicle"} == {0, 2}
    assert worst(item, whole, motion) < 1


MODES = ("QUATERNION", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "AXIS_ANGLE")


@pytest.mark.parametrize("mode", MODES)
def test_every_rotation_mode_without_jumps(mode, rigged):
    whole, item = rigged
    for bone in item.pose.bones:
        bone.rotation_mode = mode
    motion = Motion(performance(20, size=0.5))
    action = apply(item, whole, motion)
    assert {bone.rotation_mode for bone in item.pose.bones} == {mode}
    assert worst(item, whole, motion) < 1
    if mode == "QUATERNION":
        for path in {curve.data_path for curve in compat.curves(action) if curve.data_path.endswith("quaternion")}:
            columns = [curve for curve in compat.curves(action) if curve.data_path == path]
            keys = np.array([[point.co.y for point in curve.keyframe_points] for curve in columns])
            assert (np.sum(keys[:, 1:] * keys[:, :-1], 0) > 0.9).all()
    elif mode != "AXIS_ANGLE":
        steps = [np.diff([point.co.y for point in curve.keyframe_points]) for curve in compat.curves(action)]
        assert max(np.abs(step).max() for step in steps if len(step)) < np.pi


def test_existing_actions_and_tracks_stay(rigged):
    whole, item = rigged
    item.pose.bones["left_fore"].rotation_mode = "QUATERNION"
    item.pose.bones["left_fore"].rotation_quaternion = (0.8, 0.6, 0, 0)
    item.pose.bones["left_fore"].keyframe_insert("rotation_quaternion", frame=3)
    first = item.animation_data.action
    track = item.animation_data.nla_tracks.new()
    track.name = "theirs"
    strip = track.strips.new("theirs", 30, first)
    track.mute = True

    def keys(action):
        return [[tuple(point.co) for point in curve.keyframe_points] for curve in compat.curves(action)]

    before = keys(first), (strip.frame_start, strip.frame_end, track.mute, strip.action)
    motion = Motion(performance(12, size=0.4))
    second = apply(item, whole, motion)
    assert (keys(first), (strip.frame_start, strip.frame_end, track.mute, strip.action)) == before
    assert first.use_fake_user and item.animation_data.action == second
    assert worst(item, whole, motion) < 1
    remove_motion(item, second)
    third = apply(item, whole, motion, strip=True)
    assert [one.name for one in item.animation_data.nla_tracks] == ["theirs", third.name]
    assert keys(first) == before[0]


def test_library_overrides(rigged, tmp_path):
    whole, item = rigged
    things, names = set(bpy.data.objects), [thing.name for thing in bpy.data.objects]
    library = tmp_path / "rig.blend"
    bpy.data.libraries.write(str(library), things, fake_user=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(library), link=True) as (_, target):
        target.objects = names
    for linked in target.objects:
        bpy.context.collection.objects.link(linked)
    linked = next(thing for thing in target.objects if thing.type == "ARMATURE")
    item = linked.override_create(remap_local_usages=True)
    bpy.context.view_layer.update()
    before = {name: len(getattr(bpy.data, name)) for name in COLLECTIONS if name != "actions"}
    motion = Motion(performance(12, size=0.4))
    apply(item, whole, motion)
    assert {name: len(getattr(bpy.data, name)) for name in COLLECTIONS if name != "actions"} == before
    assert item.override_library is not None and item.data.library is not None
    assert worst(item, whole, motion) < 1
    changed = [one.rna_path for one in item.override_library.properties if "rotation" in one.rna_path]
    assert not changed


SCALES = {"even": (0.01, 0.01, 0.01), "uneven": (1, 2, 0.5), "mirrored": (-1, 1, 1), "mirrored and uneven": (-0.5, 1, 2)}


@pytest.mark.parametrize("scale", SCALES.values(), ids=SCALES)
def test_object_transforms(scale, rigged):
    whole, item = rigged
    item.scale, item.rotation_euler, item.location = scale, (0.5, -1, 2), (3, -1, 2)
    motion = Motion(performance(12, size=0.4))
    apply(item, whole, motion)
    np.testing.assert_allclose(item.scale, scale, rtol=1e-6)
    assert worst(item, whole, motion) < 1


@pytest.mark.parametrize("kind", ["OBJECT", "BONE"])
def test_parented_armatures(kind, rigged):
    whole, item = rigged
    above = rigging.make_armature(Body({"post": ((0, 0, 0), None)}, {}), "Above")
    above.scale, above.rotation_euler = (2, 2, -2), (0.3, 0.4, 0.5)
    above.keyframe_insert("rotation_euler", frame=1)
    above.rotation_euler = (1, -0.4, 0.5)
    above.keyframe_insert("rotation_euler", frame=20)
    item.parent, item.parent_type = above, kind
    if kind == "BONE":
        item.parent_bone = "post"
    motion = Motion(performance(12, size=0.4))
    apply(item, whole, motion)
    assert item.parent == above
    assert worst(item, whole, motion) < 1


def test_rolls_and_axes_do_not_matter_to_the_torso():
    motion = Motion(performance(12, size=0.4))
    found = []
    for seed in (1, 2):
        whole = body()
        item = rigging.make_armature(whole, f"Rig {seed}", seed=seed)
        apply(item, whole, motion)
        found.append(rigging.turned(item, "spine3", [1, 9]))
    np.testing.assert_allclose(*found, atol=1e-5)
    moved, mean = rigging.in_blender(rigging.scene_motion(motion)), rigging.in_blender(NEUTRAL)
    wanted = quaternion.to_matrix(torso_turn(moved, mean))[[0, 8]]
    assert turned_degrees(found[0], wanted).max() < 0.01


def test_taking_off_gives_the_pose_back(rigged):
    whole, item = rigged
    item.pose.bones["left_fore"].rotation_quaternion = (0.8, 0.6, 0, 0)
    item.pose.bones["head"].rotation_mode = "XYZ"
    item.pose.bones["head"].rotation_euler = (0.1, 0.2, 0.3)
    bpy.context.view_layer.update()
    before = snapshot(item)["pose"]
    action = apply(item, whole, Motion(performance(12, size=0.4)))
    bpy.context.scene.frame_set(9)
    assert snapshot(item)["pose"] != before
    remove_motion(item, action)
    bpy.context.scene.frame_set(1)
    assert snapshot(item)["pose"] == before


def test_settings_that_are_keyed_are_remembered():
    """A map's switch is keyed once; taking the action off gives the value back."""
    from dataclasses import replace

    from s2ag.rigs.family import Switch

    whole = body()
    item = rigging.make_armature(whole)
    item.pose.bones["left_hand"]["ik"] = 1
    limit = item.pose.bones["left_fore"].constraints.new("LIMIT_ROTATION")
    limit.use_limit_x = limit.use_limit_y = limit.use_limit_z = True
    limit.owner_space = "LOCAL"
    switches = (
        Switch("left_hand", '["ik"]', 0.0),
        Switch("left_fore", f'constraints["{limit.name}"].influence', 0.0),
        Switch("left_fore", '["absent"]', 0.0),
    )
    mapping, told = replace(mapping_of(item, whole), switches=switches), []
    motion = Motion(performance(12, size=0.4))
    values = solver.switches(item, mapping, told.append)
    assert len(values) == 2 and any("absent" in sentence for sentence in told)
    assert not solver.why_not_plain(item, reading.read(item), mapping, values)
    action = apply_motion(item, motion, 1, mapping=mapping, options=EXACT)
    assert limit.influence == 1.0 and item.pose.bones["left_hand"]["ik"] == 1
    assert arm_error(item, motion, mapping) < 0.01
    assert limit.influence == 0.0 and item.pose.bones["left_hand"]["ik"] == 0
    remove_motion(item, action)
    assert limit.influence == 1.0 and item.pose.bones["left_hand"]["ik"] == 1
