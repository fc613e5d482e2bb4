"""Exports a character and its animation as .blend, .bvh, .fbx, .glb or .usd, by Blender's own exporters."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

from ...core.errors import OutputUnwritable, UsageError
from ...core.files import atomic_file
from .. import compat
from ..characters.character import Character
from ..datablocks import ArmatureObject, current_context

SUFFIXES = (".blend", ".bvh", ".fbx", ".glb", ".usd", ".usda", ".usdc")
_MAX_PACKED_BYTES = 64 * 2**20
"""Recordings up to this size are packed into the .blend."""


def export(scene: bpy.types.Scene, character: Character, path: str | Path) -> None:
    """Write ``path`` by its suffix, completely or not at all.

    A ``.blend`` has the whole scene, other formats only the character, in the scene's frame range. Raises
    :class:`UsageError` for another suffix and :class:`OutputUnwritable` where writing fails."""
    path = Path(path)
    writers = {".blend": _blend, ".bvh": _bvh, ".fbx": _fbx, ".glb": _glb} | dict.fromkeys(SUFFIXES[4:], _usd)
    if path.suffix.lower() not in writers:
        raise UsageError(f"Nothing writes {path.suffix or path.name} files.", f"Use one of: {', '.join(SUFFIXES)}.")
    with atomic_file(path) as temporary:
        try:
            with _selected(character):
                writers[path.suffix.lower()](scene, character, temporary)
        except RuntimeError as error:
            reason = str(error).strip().splitlines()[-1]
            raise OutputUnwritable(f"{path} could not be written: {reason}", "Free space or choose another folder.") from error
        if not temporary.stat().st_size:
            raise OutputUnwritable(f"{path} could not be written.", "Free space or choose another folder.")


def animation_name(armature: ArmatureObject) -> str:
    """Return the name of a character's animation: its action's, else that of its top NLA strip, else its own."""
    data = armature.animation_data
    if data is None:
        return armature.name
    strips = [strip.name for track in data.nla_tracks if not track.mute for strip in track.strips if not strip.mute]
    return data.action.name if data.action is not None else (strips or [armature.name])[-1]


def _blend(scene: bpy.types.Scene, character: Character, path: Path) -> None:
    path.unlink(missing_ok=True)  # Blender would keep the empty file as a backup
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, compress=True, relative_remap=True, check_existing=False)


@contextlib.contextmanager
def portable_sound(sound: bpy.types.Sound, folder: str | Path) -> Iterator[None]:
    """Pack a recording unless it is huge, and make its path relative, while a ``.blend`` is saved into ``folder``."""
    absolute = bpy.path.abspath(sound.filepath)
    source = Path(absolute)
    if not sound.packed_file and source.is_file() and source.stat().st_size <= _MAX_PACKED_BYTES:
        sound.pack()
    with contextlib.suppress(ValueError):  # another drive
        sound.filepath = bpy.path.relpath(absolute, start=str(Path(folder).resolve()))
    try:
        yield
    finally:
        sound.filepath = absolute


def _bvh(scene: bpy.types.Scene, character: Character, path: Path) -> None:
    bpy.ops.export_anim.bvh(
        filepath=str(path), check_existing=False, frame_start=scene.frame_start, frame_end=scene.frame_end,
        rotate_mode="NATIVE", root_transform_only=True,
    )  # fmt: skip


def _fbx(scene: bpy.types.Scene, character: Character, path: Path) -> None:
    with _renamed(scene, animation_name(character.armature)):
        bpy.ops.export_scene.fbx(
            filepath=str(path), check_existing=False, use_selection=True, object_types={"ARMATURE", "MESH"},
            add_leaf_bones=False, path_mode="COPY", embed_textures=True,
            bake_anim_use_nla_strips=False, bake_anim_use_all_actions=False,
            bake_anim_force_startend_keying=True, bake_anim_simplify_factor=0.0,
        )  # fmt: skip


@contextlib.contextmanager
def _renamed(scene: bpy.types.Scene, name: str) -> Iterator[None]:
    """Rename the scene while an FBX is written, whose animation gets the scene's name."""
    before = scene.name
    if scene.library is None:
        scene.name = name
    try:
        yield
    finally:
        if scene.library is None:
            scene.name = before


def _glb(scene: bpy.types.Scene, character: Character, path: Path) -> None:
    bpy.ops.export_scene.gltf(
        filepath=str(path), check_existing=False, export_format="GLB", use_selection=True, export_yup=True,
        export_animation_mode="ACTIVE_ACTIONS",
        export_anim_single_armature=False,  # Blender 4.2 would mix in all actions that fit the armature
        export_nla_strips_merged_animation_name=animation_name(character.armature),
        export_frame_range=True, export_force_sampling=True, export_anim_slide_to_zero=True,
    )  # fmt: skip


def _usd(scene: bpy.types.Scene, character: Character, path: Path) -> None:
    """Export skeleton and skinned meshes, without images, which would become separate files."""
    options: dict[str, Any] = dict(compat.PICTURES_STAY)
    bpy.ops.wm.usd_export(
        filepath=str(path),
        check_existing=False,
        selected_objects_only=True,
        export_animation=True,
        export_armatures=True,
        convert_world_material=False,
        evaluation_mode="RENDER",
        **options,
    )


@contextlib.contextmanager
def _selected(character: Character) -> Iterator[None]:
    """Select only the character, its armature active, and restore the selection afterwards."""
    layer = current_context().view_layer
    before, active = [item for item in layer.objects if item.select_get()], layer.objects.active
    hidden = [item for item in (character.armature, *character.meshes) if item.hide_get()]
    for item in before:
        item.select_set(False)
    for item in (character.armature, *character.meshes):
        item.hide_set(False)
        item.select_set(True)
    layer.objects.active = character.armature
    try:
        yield
    finally:
        for item in (character.armature, *character.meshes):
            item.select_set(False)
        for item in hidden:
            item.hide_set(True)
        for item in before:
            item.select_set(True)
        layer.objects.active = active
