"""Hands of a motion, read back from Blender: palms, knuckles and fingers on rigs that others made."""

import bpy
import handed
import numpy as np
import pytest
import rigging
from bodies import degrees, performance
from s2ag.core.motion import handshape, skeleton
from s2ag.core.motion.hands import Hands
from s2ag.core.motion.motion import Motion
from s2ag.rigs.goals import SIDES, Goals, Options
from s2ag.rigs.plain import character_frame
from s2ag.s2ag_blender.cast import human
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import reading

FRAMES = (1, 8, 17)


def laid(item, change=lambda hands: hands):
    """Key a motion with hands; bones, mapping, hands at the frames, and posed heads (frames, n, 3)."""
    bones = reading.read(item)
    mapping = reading.resolve_mapping(item, bones)
    frame = character_frame(bones, mapping)
    bpy.context.scene.render.fps = 15
    directions = performance(20, size=0.3)
    motion = Motion(directions, hands=change(handed.within_reach(bones, mapping, frame, directions)))
    apply_motion(item, motion, 1, options=Options(clear_body=0.0))
    heads = []
    for at in FRAMES:
        pose = rigging.evaluated(item, at)
        heads.append([pose[name][:3, 3] for name in bones.names])
    goals = Goals(bones, mapping, directions, hands=motion.hands)
    return bones, goals, motion.hands[[at - 1 for at in FRAMES]], np.array(heads)


def check(item):
    bones, goals, hands, heads = laid(item)
    for place, side in enumerate(SIDES):
        palm = goals.hand(side)
        assert palm.fingers is not None and len(palm.fingers.fingers) == 4 and palm.fingers.thumb
        seen = handed.read_back(bones, goals.mapping, side, heads, palm.normal)
        for found, wanted in zip(seen, (hands.knuckles, hands.palms), strict=True):
            assert degrees(found, skeleton.canonical_to_blender(wanted[:, place]) @ goals.frame).max() < 1
        for number, chain in enumerate(palm.fingers.fingers):
            first = skeleton.normalize(heads[:, chain[1]] - heads[:, chain[0]])
            base = np.degrees(np.arcsin((first * seen[1]).sum(-1)))
            np.testing.assert_allclose(base, handshape.columns(hands.shape, "base")[:, place, number], atol=1.0)


def grasp(item):
    """For each finger whether its end is nearer to the wrist in a fist than in a flat hand, and on the palm's side."""

    def shaped(angles):
        shape = np.array([*angles * 4, 30, 20, 20, 0], np.float32)
        return lambda hands: Hands.of(hands.knuckles, hands.palms, np.broadcast_to(shape, hands.shape.shape))

    closed, flat = (laid(item, shaped(angles)) for angles in ([70, 130], [0, 0]))
    bones, goals = closed[:2]
    found = []
    for side in SIDES:
        wrist = bones.row(goals.mapping.chains[f"{side}_hand"][0])
        for chain in goals.hand(side).fingers.fingers:
            far, near = (np.linalg.norm(one[3][:, chain[2]] - one[3][:, wrist], axis=-1) for one in (flat, closed))
            normal = handed.read_back(bones, goals.mapping, side, closed[3], goals.hand(side).normal)[1]
            out = ((closed[3][:, chain[1]] - closed[3][:, chain[0]]) * normal).sum(-1)
            found.append((near / far).max() < 0.9 and out.min() > 0)
    return found


@pytest.mark.parametrize("name", ["default", "mixamo", "game_engine", "cmu_mb", "rigify"])
def test_the_human_has_the_motions_hands(name):
    item = human.build(name).armature
    if name == "cmu_mb":
        pytest.skip("its hands have no fingers")
    check(item)
    assert all(grasp(item))


@pytest.mark.parametrize("name", ["Male_Adult_01", "Female_Adult_01"])
def test_rocketbox_has_the_motions_hands(shared, name):
    path = shared / "rocketbox" / f"{name}.fbx"
    if not path.is_file():
        pytest.skip(f"{path.name} is absent")
    bpy.ops.import_scene.fbx(filepath=str(path))
    item = next(item for item in bpy.data.objects if item.type == "ARMATURE")
    check(item)
    assert all(grasp(item))
