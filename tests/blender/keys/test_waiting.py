"""Motions of who waits, as they are keyed: loops that come again and again, and hands that reach the face."""

from dataclasses import replace

import bpy
import numpy as np
from s2ag.core.motion import hand_channels, skeleton
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis import idling
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.keys.apply import apply_motion, scene_fps, solve_keys


def test_a_loop_is_keyed_as_if_it_came_again_and_again(extension):
    item = mannequin.build().armature
    fps = scene_fps(bpy.context.scene)
    for seed in range(4):
        loop = idling.idle(6, seed=seed, stillness=0.3, loop=True, fps=fps)
        rows = np.arange(3 * len(loop.directions) - 2) % (len(loop.directions) - 1)
        often = solve_keys(item, replace(loop.frames(rows), meta={}), 1, scene=bpy.context.scene).rotations
        for bone, turns in solve_keys(item, loop, 1, scene=bpy.context.scene).rotations.items():
            again = often[bone][len(loop.directions) - 1 :][: len(turns)]
            assert np.degrees(2 * np.arccos(np.clip(np.abs((turns * again).sum(-1)), 0, 1))).max() < 0.5
            assert np.array_equal(turns[0], turns[-1])


def test_who_yawns_covers_the_mouth_and_who_speaks_shows_the_face(extension):
    item, aside = mannequin.build().armature, []
    numbers = next(one.numbers for one in idling._table() if one.kind == "yawn")
    directions = skeleton.normalize(numbers[:, :27].reshape(-1, 9, 3)).astype(np.float32)
    hands = hand_channels.from_channels(numbers[:, 27:], directions)
    for meta in ({}, {"audio": "a recording's hash"}):
        apply_motion(item, Motion(directions, meta=meta, hands=hands), 1)
        places = []
        for frame in range(1, 1 + round(len(directions) / skeleton.FPS * scene_fps(bpy.context.scene))):
            bpy.context.scene.frame_set(frame)
            pose = item.pose.bones
            tips = [pose[f"middle_2.{side}"].tail - 0.5 * (pose["head"].head + pose["head"].tail) for side in "LR"]
            places.append(min(np.hypot(tip.x, tip.z) for tip in tips))
        aside.append(min(places))
    assert aside[0] < 0.08 < aside[1] - 0.04
