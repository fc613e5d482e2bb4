"""Blender's own importers against our reading of the captured material: BVH skeleton and FBX person."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from s2ag.core.learning.corpus import library, smartbody, unity
from s2ag.core.motion import skeleton

Rotation = pytest.importorskip("scipy.spatial.transform", reason="the engine's packages are not beside this Blender").Rotation
import matrices  # noqa: E402 (needs scipy)

FAMILY = "PNGestures"
KINDS = ("XPos", "YPos", "ZPos", "Quat")
ARM = ("UpperArm", "Forearm", "Hand")


def write_bvh(skeleton_file, columns, rows, path):
    """The skeleton's hierarchy with a ``.skm``'s frames as its motion: 6 channels a joint, Z X Y rotations."""
    hierarchy = skeleton_file.read_text().partition("MOTION")[0]
    joints = matrices.read_skeleton(skeleton_file)
    lines = []
    for row in rows:
        numbers = []
        for name, (_, local) in joints.items():
            value = {kind: row[[k for k, column in enumerate(columns) if column == (name, kind)]] for kind in KINDS}
            numbers += [local[axis, 3] + value[kind].sum() for axis, kind in enumerate(KINDS[:3])]
            vector = value["Quat"] if len(value["Quat"]) else np.zeros(3)
            numbers += Rotation.from_rotvec(vector).as_euler("ZXY", degrees=True).tolist()
        lines.append(" ".join(f"{number:.7f}" for number in numbers))
    path.write_text(f"{hierarchy}MOTION\nFrames: {len(rows)}\nFrame Time: 0.0416667\n" + "\n".join(lines) + "\n")


def angle(a, b):
    a, b = skeleton.normalize(a), skeleton.normalize(b)
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))


@pytest.mark.parametrize("stem", ["pointleft_intense2", "inclusivity2"])
def test_blenders_bvh_importer_stands_where_ours_stands(shared, tmp_path, stem):
    folder = shared / "smartbody" / FAMILY
    if not folder.is_dir():
        pytest.skip("the SmartBody sets are absent")
    file, roles = library.SETS[FAMILY]
    columns, rows = matrices.read_frames(folder / "motions" / f"{stem}.skm")
    picked = np.arange(0, len(rows), 11)
    write_bvh(folder / "skeletons" / file, columns, rows[picked], tmp_path / "motion.bvh")
    bpy.ops.import_anim.bvh(filepath=str(tmp_path / "motion.bvh"))
    item = bpy.context.object

    def y_up(place):
        x, y, z = item.matrix_world @ place
        return [x, z, -y]

    joints = smartbody.load_skeleton(folder / "skeletons" / file)
    names = roles.all()
    rest, _ = smartbody.forward_kinematics(joints, None, names)
    for name in names:
        np.testing.assert_allclose(y_up(item.data.bones[name].head_local), rest[name][0], atol=1e-3, err_msg=name)
    positions, _ = smartbody.forward_kinematics(joints, smartbody.load_recording(folder / "motions" / f"{stem}.skm"), names)
    for frame, row in enumerate(picked):
        bpy.context.scene.frame_set(1 + frame)
        for name in names:
            # centimetres: the file's numbers and Blender's floats have seven digits
            np.testing.assert_allclose(y_up(item.pose.bones[name].head), positions[name][row], atol=2e-3, err_msg=name)


def local_turns(animation, times):
    """Each bone's rotation in its parent as 4 by 4 matrices ``(frames, 4, 4)``, mirrored from Unity's left-handed frame."""
    mirror = np.diag([-1, 1, 1])
    turns = {}
    for path, curve in animation.rotations.items():
        turn = np.tile(np.eye(4), (len(times), 1, 1))
        turn[:, :3, :3] = mirror @ Rotation.from_quat(curve.at(times)).as_matrix() @ mirror
        turns[path.rpartition("/")[2]] = turn
    return turns


def reparent(item, pairs):
    """Hang bones on other parents, as the clip has them; where they rest does not change."""
    bpy.context.view_layer.objects.active = item
    bpy.ops.object.mode_set(mode="EDIT")
    for name, parent in pairs.items():
        bone = item.data.edit_bones[name]
        bone.use_connect = False
        bone.parent = item.data.edit_bones[parent]
    bpy.ops.object.mode_set(mode="OBJECT")


@pytest.fixture
def person(shared):
    """The person that the conversation was made for, as Blender imports it, with the clip's parents."""
    path = shared / "rocketbox" / "Male_Adult_01.fbx"
    if not path.is_file() or not (shared / unity.CONVERSATION).is_file():
        pytest.skip("the Rocketbox material is absent")
    bpy.ops.import_scene.fbx(filepath=str(path))
    item = next(each for each in bpy.data.objects if each.type == "ARMATURE")
    parents = {f"Bip01 {side} Clavicle": "Bip01 Spine2" for side in "LR"}
    reparent(item, parents | {f"Bip01 {side} Thigh": "Bip01 Pelvis" for side in "LR"})
    return item


def pose(item, turns, frame):
    """Give every bone its rotation in its parent; its place in its parent stays as it rests."""
    for bone in item.pose.bones:
        if bone.name not in turns:
            continue
        rest = bone.bone.matrix_local
        if bone.parent:
            rest = bone.parent.bone.matrix_local.inverted() @ rest
        wanted = Matrix(turns[bone.name][frame])
        wanted.translation = rest.translation
        bone.matrix_basis = rest.inverted() @ wanted
    bpy.context.view_layer.update()


def test_blenders_person_makes_the_conversations_movements(shared, person):
    animation = unity.load(shared / unity.CONVERSATION)
    joints, recording = unity.to_recording(animation)
    picked = np.arange(0, len(recording.times), 37)
    turns = local_turns(animation, recording.times[picked])
    names = ("Spine", "Spine1", "Spine2", "Neck", "Head", *(f"{s} {n}" for s in "LR" for n in ("Clavicle", *ARM)))
    names = [f"Bip01 {name}" for name in names]
    positions, _ = smartbody.forward_kinematics(joints, recording, set(names))
    parents = {joint.name: joints[joint.parent].name for joint in joints}
    # the file has the collar bones on another bone, elsewhere: only what they carry can be compared
    carried = [name for name in names[1:] if not name.endswith("Clavicle")]
    frame_of_person = np.array(person.matrix_world.to_3x3().normalized())
    for frame, row in enumerate(picked):
        pose(person, turns, frame)
        for name in carried:
            start, end = person.pose.bones[parents[name]].head, person.pose.bones[name].head
            found = skeleton.blender_to_canonical(frame_of_person @ np.array(end - start))
            wanted = skeleton.y_up_to_canonical(positions[name][row] - positions[parents[name]][row])
            assert angle(found, wanted) < 0.05, (name, row)


def test_the_person_faces_forward_and_its_left_is_left(person):
    """Without our code: Blender's person looks along -y with its left hand at +x, which is canonical +z and -x."""
    frame = np.array(person.matrix_world)
    at = {bone.name: (frame @ [*bone.head_local, 1])[:3] for bone in person.data.bones}
    assert at["Bip01 L Hand"][0] > 0.4 > -0.4 > at["Bip01 R Hand"][0]
    assert at["Bip01 L Toe0"][1] < at["Bip01 L Foot"][1] - 0.05 and at["Bip01 Head"][2] > 1.5


def test_arms_of_the_directions_are_those_of_blenders_person(shared, person):
    """To the directions' end: upper arms and forearms, up to the turn about the vertical that is taken out."""
    animation = unity.load(shared / unity.CONVERSATION)
    start, end = unity.STRETCH
    directions = unity.to_directions(animation, start, end)
    times = np.arange(start, end, 1.7)
    turns = local_turns(animation, times)
    frame_of_person = np.array(person.matrix_world.to_3x3().normalized())
    for frame, time in enumerate(times):
        pose(person, turns, frame)
        heads = {f"{side} {name}": person.pose.bones[f"Bip01 {side} {name}"].head for side in "LR" for name in ARM}
        along = [heads[f"{s} {b}"] - heads[f"{s} {a}"] for s in "LR" for a, b in zip(ARM, ARM[1:], strict=False)]
        found = skeleton.normalize(skeleton.blender_to_canonical(np.array(along) @ frame_of_person.T))
        wanted = directions[round((time - start) * animation.fps), list(skeleton.ARM_EDGES)].astype(float)
        np.testing.assert_allclose(found[:, 1], wanted[:, 1], atol=2e-3)
        # one turn about the vertical takes all four to where they are
        complex_found, complex_wanted = (v[:, 0] + 1j * v[:, 2] for v in (found, wanted))
        turn = np.vdot(complex_found, complex_wanted)
        np.testing.assert_allclose(complex_found * turn / abs(turn), complex_wanted, atol=3e-3)
