"""Faces in files: what shape keys and bones of the face do comes back from FBX, GLB and USD as it was keyed."""

import re
from dataclasses import replace

import bpy
import numpy as np
import pytest
from s2ag.core.motion import skeleton
from s2ag.core.motion.face import CHANNELS, Face
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender.characters import face_lookup, human, mannequin
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.render import export

pytestmark = pytest.mark.slow

FRAMES = 25
KEYS = ("jawOpen", "mouthPucker", "mouthFunnel", "mouthPressLeft", "mouthSmileLeft", "eyeBlinkLeft", "eyeLookOutLeft")
BONES = ("jaw", "eye.L", "eye.R")
IMPORTERS = {".fbx": bpy.ops.import_scene.fbx, ".glb": bpy.ops.import_scene.gltf, ".usdc": bpy.ops.wm.usd_import}


@pytest.fixture
def motion():
    """A second of a face in which every channel moves, in its own way, with closed lips in the middle."""
    time = np.arange(101)[:, None] / 100
    weights = 0.3 + 0.3 * np.sin(2 * np.pi * time * (1 + 0.1 * np.arange(len(CHANNELS)))) ** 2
    face = Face(weights.astype(np.float32), np.array([[0.46, 0.54]]))
    return Motion(np.repeat(skeleton.REST[None], 16, 0), face=face)


def simple_head():
    """The mannequin with a head that has shape keys with ARKit's names."""
    character = mannequin.build()
    mesh = bpy.data.meshes.new("Head")
    mesh.from_pydata([(-0.1, -0.1, 1.6), (0.1, -0.1, 1.6), (0.0, -0.1, 1.8), (0.0, 0.1, 1.7)], [], [(0, 1, 2), (1, 3, 2)])
    item = bpy.data.objects.new("Head", mesh)
    bpy.context.scene.collection.objects.link(item)
    follow(item, character.armature)
    for number, name in enumerate(("Basis", *KEYS)):
        block = item.shape_key_add(name=name, from_mix=False)
        block.value, block.data[number % 4].co.y = 0.0, block.data[number % 4].co.y - 0.01 * number
    return replace(character, meshes=(*character.meshes, item))


def boned_head():
    """The mannequin with a jaw and eyes of bones, rolled anyhow."""
    character = mannequin.build()
    bpy.context.view_layer.objects.active = character.armature
    bpy.ops.object.mode_set(mode="EDIT")
    edit = character.armature.data.edit_bones
    for number, name in enumerate(BONES):
        bone, side = edit.new(name), {"L": 1, "R": -1}.get(name[-1], 0)
        bone.head = edit["head"].head + bone.head.__class__((0.032 * side, -0.06, 0.03 if side == 0 else 0.08))
        bone.tail = bone.head + bone.head.__class__((0, -0.03, -0.02 if side == 0 else 0))
        bone.roll, bone.parent = 0.7 * number, edit["head"]
    bpy.ops.object.mode_set(mode="OBJECT")
    return character


def follow(item, armature):
    item.parent = armature
    item.vertex_groups.new(name="head").add(range(len(item.data.vertices)), 1.0, "REPLACE")
    item.modifiers.new("Armature", "ARMATURE").object = armature


def plain(name: str) -> str:
    """A name without what importers and USD, where all meshes of a skeleton share its shapes, add to make it the only one."""
    return re.sub(r"\W", "_", name).rstrip("_0123456789")


def values(first: int) -> dict[tuple[str, str], np.ndarray]:
    """What every shape key is at :data:`FRAMES` frames, by its mesh and name."""
    found = {}
    for frame in range(first, first + FRAMES):
        bpy.context.scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        for item in bpy.data.objects:
            if item.type == "MESH" and item.data.shape_keys is not None:
                for block in item.data.shape_keys.evaluated_get(graph).key_blocks[1:]:
                    found.setdefault((plain(item.name), plain(block.name)), []).append(block.value)
    return {name: np.array(track) for name, track in found.items()}


def turned(first: int) -> dict[str, np.ndarray]:
    """How the face's bones are turned in the world from their rest ``(FRAMES, 3, 3)``."""
    (item,), found = [item for item in bpy.data.objects if item.type == "ARMATURE"], {}
    for frame in range(first, first + FRAMES):
        bpy.context.scene.frame_set(frame)
        posed = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
        world = posed.matrix_world
        for name in BONES:
            bone = next(one for one in posed.pose.bones if plain(one.name) == plain(name))
            way = world @ bone.matrix @ bone.bone.matrix_local.inverted() @ world.inverted()
            found.setdefault(name, []).append(np.array(way.to_quaternion().to_matrix()))
    return {name: np.array(track) for name, track in found.items()}


def there_and_back(character, motion, path, read):
    """What ``read(first frame)`` tells of a character that plays ``motion``, before and after it was in a file."""
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = 24, 1, FRAMES
    apply_motion(character.armature, motion, 1)
    before = read(1)
    export.export(scene, character, path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 24
    IMPORTERS[path.suffix](filepath=str(path))
    return before, read(round(min(action.frame_range[0] for action in bpy.data.actions)))


@pytest.mark.parametrize("build", [simple_head, pytest.param(human.build, marks=pytest.mark.slow)])
@pytest.mark.parametrize("suffix", IMPORTERS)
def test_shape_keys_come_back_as_they_were_keyed(empty_file, motion, tmp_path, suffix, build):
    character = build()
    driven = {plain(name) for name in face_lookup.find(character.armature).shapes.keys}
    before, after = there_and_back(character, motion, tmp_path / f"face{suffix}", values)
    moved = {name for name, track in before.items() if name[1] in driven and np.ptp(track) > 0.05}
    assert len({key for _, key in moved}) >= len(KEYS) and moved <= after.keys()
    assert max(np.abs(after[name] - before[name]).max() for name in moved) < 1e-4


@pytest.mark.parametrize("suffix", IMPORTERS)
def test_jaw_and_eyes_come_back_as_they_were_turned(empty_file, motion, tmp_path, suffix):
    before, after = there_and_back(boned_head(), motion, tmp_path / f"face{suffix}", turned)
    for name in BONES:
        cosine = (np.einsum("nij,kij->nk", before[name], before[name]).min() - 1) / 2
        assert np.degrees(np.arccos(cosine)) > 3
        assert np.abs(after[name] - before[name]).max() < 1e-3
