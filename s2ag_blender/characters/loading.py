"""Adds characters to the scene by name: human, human:RIG, mannequin, or a file."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy

from ...core.errors import RigUnusable
from ...rigs.skeleton import Mapping
from ..datablocks import ArmatureObject, MeshObject, current_context, is_armature, is_mesh
from ..rig import reading
from . import human, mannequin, scene_safety
from .character import Character

FILES = (".blend", ".fbx", ".glb", ".gltf")
SPACING = 1.1
"""Metres between characters that are added to one scene."""
_CLAY = (0.42, 0.36, 0.31, 1)


def load_character(
    name: str, gender: str = "female", armature: str | None = None, mapping: Mapping | None = None,
    besides: Collection[bpy.types.Object] = ()
) -> tuple[Character, bool]:  # fmt: skip
    """Load the character called ``name``; return it and whether its scene is the user's own (a ``.blend``).

    ``name`` is ``human``, ``human:RIG``, ``mannequin`` or a file of :data:`FILES`; a ``.blend`` replaces the open file,
    anything else is added to the current scene. ``armature`` chooses one by name where a file has several, else the only
    one that ``mapping`` fits, or whose bones are recognised. Armatures in ``besides`` are ignored. Raises
    :class:`RigUnusable`."""
    kind, _, rig_name = name.partition(":")
    if kind == "human" and not Path(name).suffix:
        return replace(human.build(rig_name or "default", gender), mapping=mapping), False
    if name == "mannequin":
        return replace(mannequin.build(), mapping=mapping), False
    path = Path(name)
    if path.suffix.lower() not in FILES:
        raise RigUnusable(f"There is no character {name}.", f"Use human, human:RIG, mannequin or a {', '.join(FILES)} file.")
    if not path.is_file():
        raise RigUnusable(f"The character file {name} does not exist.", "Check its path.")
    _load(path)
    is_scene = path.suffix.lower() == ".blend"  # the other formats hold nothing that renders by itself
    disarmed = tuple(scene_safety.disarm()) if is_scene else ()
    if not is_scene:
        _forget_missing_images()
    item = choose_armature(path.name, armature, mapping, besides)
    return Character(item, tuple(meshes(item)), mapping=mapping, disarmed=disarmed), is_scene


def build_scene(wanted: Sequence[tuple[str, str, str | None, Mapping | None]]) -> tuple[bpy.types.Scene, list[Character], bool]:
    """Load a character for each ``(name, gender, armature, mapping)``; return scene, characters, and if it is a ``.blend``.

    A ``.blend`` is opened once, however many of its armatures are used; other characters are added to it, or to an empty
    scene, side by side. The open file is lost. Raises :class:`RigUnusable`."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    files = {name for name, *_ in wanted if Path(name).suffix.lower() == ".blend"}
    if len(files) > 1:
        raise RigUnusable(f"Two scenes were asked for: {', '.join(sorted(files))}.", "Let all characters stand in one.")
    characters, added = {}, []
    # The file first: opening it removes all other characters.
    for index in sorted(range(len(wanted)), key=lambda index: wanted[index][0] not in files):
        name, gender, armature, mapping = wanted[index]
        if name in files and characters:
            item = choose_armature(Path(name).name, armature, mapping)
            characters[index] = Character(item, tuple(meshes(item)), mapping=mapping)
            continue
        before = {item for item in current_context().scene.objects if is_armature(item)} if name not in files else set()
        characters[index], _ = load_character(name, gender, armature, mapping, before)
        added += [characters[index]] if name not in files else []
    if not files:
        _place_side_by_side(added)
    return current_context().scene, [characters[index] for index in range(len(wanted))], bool(files)


def _place_side_by_side(characters: Sequence[Character]) -> None:
    """Place characters side by side, the first on the left of the picture."""
    for index, character in enumerate(characters):
        top: bpy.types.Object = character.armature
        while top.parent:
            top = top.parent
        top.location.x += SPACING * (index - (len(characters) - 1) / 2)
    current_context().view_layer.update()


def choose_armature(
    source: str, name: str | None = None, mapping: Mapping | None = None, besides: Collection[bpy.types.Object] = ()
) -> ArmatureObject:
    """Return the scene's armature object with arms, or the one called ``name``; raises :class:`RigUnusable` with the choices.

    A single armature is returned even without arms: the caller reports what it lacks. ``besides`` are not chosen."""
    armatures = [item for item in current_context().scene.objects if is_armature(item) and item not in besides]
    listed = ", ".join(item.name for item in armatures)
    if not armatures:
        raise RigUnusable(f"{source} holds no armature.", "Give a character with a skeleton.")
    if name:
        named = [item for item in armatures if name in (item.name, item.data.name)]
        if not named:
            raise RigUnusable(f"{source} holds no armature called {name}.", f"Choose one of: {listed}.")
        return named[0]
    if len(armatures) == 1:
        return armatures[0]
    refusals = [reading.survey(item, mapping)[1] for item in armatures]
    usable = [item for item, refusal in zip(armatures, refusals, strict=True) if refusal is None]
    if not usable:
        remedy = refusals[0].remedy if refusals[0] is not None else ""
        raise RigUnusable(f"No armature of {source} has arms: {listed}.", f"See one with --armature NAME. {remedy}")
    if len(usable) > 1:
        names = ", ".join(item.name for item in usable)
        raise RigUnusable(f"{source} holds several characters: {names}.", "Choose one with --armature NAME.")
    return usable[0]


def _load(path: Path) -> None:
    """Open a ``.blend`` without running its scripts, or import a character without its animation."""
    try:
        if path.suffix.lower() == ".blend":
            bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
        elif path.suffix.lower() == ".fbx":
            bpy.ops.import_scene.fbx(filepath=str(path), use_anim=False)
        else:
            before = set(current_context().scene.objects)
            bpy.ops.import_scene.gltf(filepath=str(path))
            for item in set(current_context().scene.objects) - before:
                item.animation_data_clear()
    except RuntimeError as error:
        reason = str(error).strip().splitlines()[-1]
        raise RigUnusable(f"{path} cannot be opened: {reason}", "Save it again from a Blender of this version.") from error


def _forget_missing_images() -> None:
    """Give materials whose images are missing a clay colour, instead of Blender's magenta."""
    for material in bpy.data.materials:
        nodes: Any = material.node_tree.nodes if material.node_tree else ()
        read = [node for node in nodes if node.type == "TEX_IMAGE" and node.image and node.image.source == "FILE"]
        unpacked = [node for node in read if not node.image.packed_file]
        missing = [node for node in unpacked if not Path(bpy.path.abspath(node.image.filepath)).is_file()]
        for node in missing:
            nodes.remove(node)
        shader = next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)
        if missing and shader and not shader.inputs["Base Color"].is_linked:
            shader.inputs["Base Color"].default_value = material.diffuse_color = _CLAY
            shader.inputs["Alpha"].default_value, material.metallic, material.roughness = 1, 0, 0.6


def meshes(armature: ArmatureObject) -> Iterator[MeshObject]:
    """Yield the scene's mesh objects that follow an armature, by modifier or as its children."""

    def follows(modifier: Any) -> bool:
        return modifier.type == "ARMATURE" and modifier.object is armature

    for item in current_context().scene.objects:
        if is_mesh(item) and (any(map(follows, item.modifiers)) or item.parent is armature):
            yield item
