"""Hands of a motion, read back from Blender: palms, knuckles, fingers and feet on every kind of rig.

``pytest tests/blender/rig/test_palms_on_rigs.py -rP`` prints a line for each: degrees between motion and palm, knuckles and
the base of the fingers, and millimetres that feet move where the weight shifts.
"""

from dataclasses import replace

import bpy
import found_rigs
import handed
import numpy as np
import people
import pytest
import rigging
import skeletons
from bodies import degrees, performance
from s2ag.core.motion import handshape, skeleton
from s2ag.core.motion.hands import Hands
from s2ag.core.motion.motion import Motion
from s2ag.rigs import legs
from s2ag.rigs.family import families
from s2ag.rigs.goals import SIDES, Goals, Options
from s2ag.rigs.skeleton import character_frame
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.rig.hands import free_bones

pytestmark = pytest.mark.slow

FRAMES = (1, 8, 17)
FAMILIES = families()


def laid(item, change=lambda hands: hands, **more):
    """Key a motion with hands; bones, mapping, hands at the frames, and posed heads (frames, n, 3)."""
    bones = reading.read(item)
    mapping = reading.resolve_mapping(item, bones)
    frame, free = character_frame(bones, mapping), free_bones(item, posed=True)
    bpy.context.scene.render.fps = 15
    directions = performance(20, size=0.3)
    motion = Motion(directions, hands=change(handed.within_reach(bones, mapping, frame, directions, free=free)), **more)
    apply_motion(item, motion, 1, options=Options(clear_body=False))
    heads = []
    for at in FRAMES:
        pose = rigging.evaluated(item, at)
        heads.append([pose[name][:3, 3] for name in bones.names])
    goals = Goals(bones, mapping, directions, hands=motion.hands, free=free)
    return bones, goals, motion.hands[[at - 1 for at in FRAMES]], np.array(heads)


def check(name, item, stands=True):
    """Print the figures of a rig and hold them to their bounds; its feet too, if it ``stands`` on legs that are found."""
    bones, goals, hands, heads = laid(item, pelvis=handed.pelvis(20) if stands else None)
    off = {"knuckles": 0.0, "palms": 0.0, "fingers": 0.0}
    for place, side in enumerate(SIDES):
        palm = goals.hand(side)
        assert palm.fingers is not None and len(palm.fingers.fingers) >= 3 and palm.fingers.thumb
        seen = handed.read_back(bones, goals.mapping, side, heads, palm.normal, goals.usable())
        for part, found, wanted in zip(("knuckles", "palms"), seen, (hands.knuckles, hands.palms), strict=True):
            error = degrees(found, skeleton.canonical_to_blender(wanted[:, place]) @ goals.frame).max()
            off[part] = max(off[part], error)
        columns = np.linspace(0, 3, len(palm.fingers.fingers)).round().astype(int)
        for number, chain in zip(columns, palm.fingers.fingers, strict=True):
            first = skeleton.normalize(heads[:, chain[1]] - heads[:, chain[0]])
            base = np.degrees(np.arcsin((first * seen[1]).sum(-1)))
            error = np.abs(base - handshape.columns(hands.shape, "base")[:, place, number]).max()
            off["fingers"] = max(off["fingers"], error)
    told = f"{name:32}" + "".join(f"{part} {error:.2f}°  " for part, error in off.items())
    assert max(off.values()) < 1
    if stands:
        standing = legs.find(bones, goals.mapping, goals.frame[2])
        millimetres = 1000 * np.abs(np.array(item.matrix_world)[:3, :3]).max() * np.abs(heads - bones.heads).max((0, 2))
        moved = millimetres[[leg.foot for leg in standing.pair]].max()
        told += f"feet {moved:.2f} mm"
        assert moved < 5 and millimetres[standing.pelvis] > 15
    print(told)
    assert all(grasp(item))


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
            far, near = (np.linalg.norm(one[3][:, chain[:3][-1]] - one[3][:, wrist], axis=-1) for one in (flat, closed))
            normal = handed.read_back(bones, goals.mapping, side, closed[3], goals.hand(side).normal, goals.usable())[1]
            out = ((closed[3][:, chain[1]] - closed[3][:, chain[0]]) * normal).sum(-1)
            found.append((near / far).max() < 0.9 and out.min() > 0)
    return found


@pytest.mark.parametrize("family", FAMILIES, ids=[one.key for one in FAMILIES])
def test_every_family_has_the_motions_hands(family):
    pose = "AT"[FAMILIES.index(family) % 2]
    body = skeletons.person(replace(family, switches=()), pose)
    item = rigging.make_armature(body)
    assert reading.resolve_mapping(item, reading.read(item)).family == family.key
    check(f"{family.key}, {pose} pose", item)


@pytest.mark.parametrize("name", ["default", "mixamo", "game_engine", "rigify"])
def test_the_human_has_the_motions_hands(name):
    check(f"human: {name}", people.armature(name))


def test_the_mannequin_has_the_motions_hands():
    check("mannequin", mannequin.build().armature)


def test_a_hand_without_fingers_has_them():
    item, directions = people.armature("cmu_mb"), performance(20, size=0.3)
    bones, hands = reading.read(item), handed.hands(directions)
    bpy.context.scene.render.fps = 15
    goals = Goals(bones, reading.resolve_mapping(item, bones), directions, hands=hands)
    apply_motion(item, Motion(directions, hands=hands), 1, options=Options(clear_body=False, limits=False))
    for place, side in enumerate(SIDES):
        palm, bone = goals.hand(side), goals.mapping.chains[f"{side}_hand"][0]
        assert palm.fingers is None
        turns, at = rigging.turned(item, bone, FRAMES), [frame - 1 for frame in FRAMES]
        for rest, wanted in ((palm.knuckles, hands.knuckles), (palm.normal, hands.palms)):
            assert degrees(turns @ rest, skeleton.canonical_to_blender(wanted[at, place]) @ goals.frame).max() < 1


@pytest.mark.parametrize("name", ["Male_Adult_01", "Female_Adult_01"])
def test_rocketbox_has_the_motions_hands(shared, name):
    item = found_rigs.rocketbox(shared, name)
    for bone in item.pose.bones:  # the file comes posed, and posed legs do not shift their weight
        bone.matrix_basis.identity()
    check(f"Rocketbox: {name}", item)


@pytest.mark.slow
def test_rigifys_controls_have_the_motions_hands(rigify_saved):
    check("Rigify's control rig", found_rigs.opened(rigify_saved[1]), stands=False)


def test_mesh2motions_controls_have_the_motions_hands(shared):
    check("Mesh2Motion's control rig", found_rigs.mesh2motion(shared), stands=False)
