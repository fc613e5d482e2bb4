"""Rigs with twist bones in the chain: what carries the skin is found and points where the motion says."""

import bpy
import numpy as np
import pytest
import rigging
import skeletons
import twisted
from bodies import degrees, performance
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.rigs.detect import BY_POSITION
from s2ag.rigs.family import families
from s2ag.rigs.goals import Options
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import reading, skin
from solved import detect

pytestmark = pytest.mark.slow

EXACT = Options(clear_body=False, fingers=0.0)
FRAMES = (1, 6, 12, 19)


def posed_skin(item, mesh, frame):
    """Where the vertices of each bone's skin are (n, 3), ``{bone: points}``, in armature space."""
    rigging.evaluated(item, frame)
    seen = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = {}
    for vertex, rest in zip(seen.data.vertices, mesh.data.vertices, strict=True):
        points.setdefault(mesh.vertex_groups[rest.groups[0].group].name, []).append(vertex.co)
    return {bone: np.array(found) for bone, found in points.items()}


@pytest.mark.parametrize("fingers", [True, False])
@pytest.mark.parametrize("facing", [np.eye(3), twisted.FACING_X], ids=["y", "x"])
@pytest.mark.parametrize("kind", twisted.KINDS)
def test_bones_that_carry_the_arms_are_found_and_no_family_is_named(kind, facing, fingers):
    item, _, body = twisted.skinned(kind, facing=facing, fingers=fingers)
    found, refusal = reading.survey(item)
    assert refusal is None and found.warnings == ()
    assert found.chains == body.chains and found.hips == "b_hip" and found.family == BY_POSITION


@pytest.mark.parametrize("pose", ["T", "A"])
@pytest.mark.parametrize("kind", twisted.KINDS)
def test_all_skin_of_an_arm_follows_the_motion(kind, pose):
    item, mesh, body = twisted.skinned(kind, pose, facing=twisted.FACING_X)
    motion = Motion(performance(20))
    apply_motion(item, motion, FRAMES[0], options=EXACT)
    wanted = rigging.in_blender(rigging.scene_motion(motion)) @ twisted.FACING_X.T
    for frame in FRAMES:
        now, skins = rigging.evaluated(item, frame), posed_skin(item, mesh, frame)
        for part, following in (("upper_arm", "forearm"), ("forearm", "hand")):
            for side in ("left", "right"):
                chain, end = body.chains[f"{side}_{part}"], body.chains[f"{side}_{following}"][0]
                first, last = (now[bone][:3, 3] for bone in (chain[0], end))
                edge = skeleton.EDGE_NAMES.index(f"{side}_{part}")
                assert degrees(last - first, wanted[frame - FRAMES[0], edge]) < 0.1
                along = (last - first) / np.linalg.norm(last - first)
                for middle in (skins[bone].mean(0) - first for bone in chain):
                    assert np.linalg.norm(middle - along * (middle @ along)) < 1.0  # centimetres


def test_twist_is_shared_by_the_skin_that_hangs_on_each_bone():
    item, *_ = twisted.skinned("trailing")
    found = reading.resolve_mapping(item, reading.read(item))
    np.testing.assert_allclose(found.shares["left_upper_arm"], [0.8, 1.0], atol=0.05)
    np.testing.assert_allclose(found.shares["right_forearm"], [0.5, 1.0], atol=0.05)


def test_scale_of_the_object_and_of_the_mesh_do_not_matter():
    shares = []
    for scale in (0.01, 1.0, 2.5):
        item, *_ = twisted.skinned("middle", scale=scale)
        shares.append(reading.resolve_mapping(item, reading.read(item)).shares["left_upper_arm"])
    np.testing.assert_allclose(shares, [shares[0]] * 3, atol=1e-6)


def test_skin_is_looked_at_where_the_bones_are():
    item, *_ = twisted.skinned("trailing", "A", facing=twisted.FACING_X)
    bones = reading.read(item)
    seen = skin.read(item, bones)
    middle = 100 * twisted.FACING_X @ twisted.along("left", "A", 1.4)
    assert np.linalg.norm(seen.centres[bones.row("b_l_arm")] - middle) < 0.5


def test_a_family_with_a_twist_bone_between_keeps_its_name():
    mixamo = next(family for family in families() if family.key == "mixamo")
    joints = dict(skeletons.person(mixamo, "T").joints)
    for side in ("Left", "Right"):
        elbow, above = joints[f"{side}ForeArm"]
        joints[f"{side}ArmTwist"] = (0.5 * (np.asarray(elbow) + joints[above][0]), above)
        joints[f"{side}ForeArm"] = (elbow, f"{side}ArmTwist")
    found = detect(skeletons.placed(skeletons.Body(skeletons.in_order(joints), {})))
    assert found.family == "mixamo" and found.chains["left_upper_arm"] == ("LeftArm", "LeftArmTwist")
