"""A dozen edits of all kinds, one on the other, through the operators: each is there, is one step, and changes no other key."""

import bpy
import numpy as np
import pytest
from acted import apart, curves, now, pose, press, same_curves
from mathutils import Quaternion, Vector
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.keys.apply import scene_fps
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.takes import gesture_edits, take_list, timing

LANDS, SIZE = 0.08, 0.15
"""Seconds and share within which a stroke is what was asked for."""


def figure():
    return bpy.data.objects["Mannequin"]


def state():
    return curves(now()), gesture_edits.edits_of(now()), now()[gesture_edits.GESTURES]


def gesture(number, hand=None):
    """The gesture nearest to a share of a dozen of the take, made by another hand than ``hand``."""
    found = [one for one in gesture_edits.shown_gestures(now(), bpy.context.scene)[1:-1] if one.hand != hand]
    return found[number * len(found) // 12]


def made(at):
    found = gesture_edits.shown_gestures(now(), bpy.context.scene)
    return next((one for one in found if abs(one.at - at) <= LANDS), None)


def moved(number, by):
    one = gesture(number)
    now().pose_markers[one.name].frame += by
    wanted = one.at + by / scene_fps(bpy.context.scene)
    assert press(bpy.ops.s2ag.apply_markers) == {"FINISHED"}
    return lambda: made(wanted) is not None and made(wanted).hand == one.hand


def changed(number, **asked):
    one = gesture(number, asked.get("hand"))
    bpy.context.scene.frame_set(one.frame)
    assert press(bpy.ops.s2ag.change_gesture, **asked) == {"FINISHED"}
    had = {"hand": lambda there: there.hand == asked["hand"], "kind": lambda there: there.kind == asked["kind"]}
    had["size"] = lambda there: abs(there.size / (asked["size"] * one.size) - 1) <= SIZE
    return lambda: made(one.at) is not None and all(had[name](made(one.at)) for name in asked)


def deleted(number):
    one = gesture(number)
    bpy.context.scene.frame_set(one.frame)
    assert press(bpy.ops.s2ag.delete_gesture) == {"FINISHED"}
    return lambda: made(one.at) is None or made(one.at).size <= 0.5 * one.size


def added(frame, kind):
    bpy.context.scene.frame_set(frame)
    at = gesture_edits.seconds_at(now(), bpy.context.scene, frame)
    assert press(bpy.ops.s2ag.add_gesture, kind=kind) == {"FINISHED"}
    return lambda: made(at) is not None and made(at).kind == kind


def rerolled(first, last):
    scene, before = bpy.context.scene, curves(now())
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, first, last
    assert press(bpy.ops.s2ag.reroll_range) == {"FINISHED"}
    return lambda: not same_curves(before, now())


def arm(side="left"):
    chains = reading.resolve_mapping(figure(), reading.read(figure())).chains
    return chains[f"{side}_upper_arm"][0], chains[f"{side}_forearm"][-1]


def posed(frame):
    bpy.context.scene.frame_set(frame)
    for name in arm():
        bone = figure().pose.bones[name]
        bone.rotation_quaternion = bone.rotation_quaternion @ Quaternion((1, 0, 0), np.radians(20))
        bone.keyframe_insert("rotation_quaternion", frame=frame)
    wanted = pose(figure(), frame)
    assert press(bpy.ops.s2ag.keep_pose) == {"FINISHED"}
    return lambda: apart(wanted, pose(figure(), frame)) <= 0.5


def wrist(frame):
    bpy.context.scene.frame_set(frame)
    return figure().matrix_world @ figure().pose.bones[arm()[1]].tail


def placed(first, last):
    scene, target = bpy.context.scene, bpy.data.objects.new("Table", None)
    there = wrist((first + last) // 2)
    shoulder = figure().matrix_world @ figure().pose.bones[arm()[0]].head
    # Within reach however straight the arm is there.
    target.location = place = there.lerp(shoulder, 0.15) + Vector((0.04, -0.03, 0.03))
    scene.collection.objects.link(target)
    bpy.context.view_layer.update()
    figure().s2ag.target = target
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, first, last
    assert press(bpy.ops.s2ag.keep_place, hand="left") == {"FINISHED"}
    return lambda: all((wrist(frame) - place).length <= 0.005 for frame in range(first, last + 1))


EDITS = [
    lambda: moved(2, 6),
    lambda: moved(9, -6),
    lambda: changed(3, size=0.7),
    lambda: changed(10, size=1.25),
    lambda: changed(4, hand="left"),
    lambda: changed(8, hand="right"),
    lambda: changed(6, kind="big"),
    lambda: added(170, "shrug"),
    lambda: deleted(7),
    lambda: rerolled(90, 140),
    lambda: posed(150),
    lambda: placed(270, 290),
]


def elsewhere(before, after, action):
    """Whether keys of two takes are the same wherever the last edit of ``action`` has touched nothing."""
    told, fps = provenance.read(action), scene_fps(bpy.context.scene)
    clock, room = timing.clock_of(told, fps), 2 * fps / 15  # keys between frames of the motion, and the next turn of a curve
    spans = [[float(clock.frame(at)) for at in span] for span in told["touched"][-1]]
    assert sum(stop - start for start, stop in spans) < 7 * fps

    def outside(keys):
        inside = [(keys[:, 0] >= start - room - 0.5) & (keys[:, 0] <= stop + room + 0.5) for start, stop in spans]
        return keys[~np.any(inside, axis=0)]

    assert before.keys() == after.keys()
    return all(np.array_equal(outside(before[key]), outside(after[key])) for key in before)


@pytest.mark.slow
def test_a_dozen_edits(speaker, examples):
    speaker.s2ag.audio, speaker.s2ag.curves = str(examples / "hello.flac"), "FRAMES"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="ready")
    missed = []
    for number, edit in enumerate(EDITS):
        before = state()
        there = edit()
        after = state()
        told = take_list.active(figure()).warnings
        assert len(after[1]) == number + 1 and not same_curves(before[0], after[0]), number
        missed += [] if there() else [after[1][-1]]
        assert there() or f"Decision {number + 1} " in told, (number, after[1][-1], told)
        assert elsewhere(before[0], after[0], now()), (number, after[1][-1])
        bpy.ops.ed.undo()
        assert same_curves(state()[0], before[0]) and state()[1:] == before[1:], number
        bpy.ops.ed.redo()
        assert same_curves(state()[0], after[0]) and state()[1:] == after[1:], number
        assert there() or f"Decision {number + 1} " in told, number
    assert len(missed) <= 2, missed  # each is told; of a lively take more neighbours leave no room
