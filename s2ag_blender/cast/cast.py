"""Bringing a character into the scene by name: human, human:RIG, mannequin, or one from a file."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

import bpy

from ...core.errors import RigUnusable
from ...rigs.plain import Mapping
from ..datablocks import ArmatureObject
from ..rig import reading
from . import disarm, human, mannequin
from .character import Character

FILES = (".blend", ".fbx", ".glb", ".gltf")
SPACING = 1.1
"""Metres between characters that join one scene."""
_CLAY = (0.42, 0.36, 0.31, 1)


def summon(
    name: str,
    gender: str = "female",
    armature: str | None = None,
    mapping: Mapping | None = None,
    besides: Collection = (),
) -> tuple[Character, bool]:
    """The character called ``name``, and whether the scene it stands in is the user's own (a ``.blend``).

    ``name`` is ``human``, ``human:RIG``, ``mannequin`` or a file of :data:`FILES`; a ``.blend`` replaces everything that
    is open, anything else joins the current scene. ``armature`` chooses one by name where a file holds several, else the
    only one that ``mapping`` fits, or whose bones are recognised where there is none; it is not among the armatures
    ``besides``. Raises :class:`RigUnusable`.
    """
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
    whole = path.suffix.lower() == ".blend"  # the other formats hold nothing that renders by itself
    disarmed = tuple(disarm.disarm()) if whole else ()
    if not whole:
        _forget_missing_images()
    found = choose(path.name, armature, mapping, besides)
    return Character(found, tuple(meshes(found)), mapping=mapping, disarmed=disarmed), whole


def assemble(
    wanted: Sequence[tuple[str, str, str | None, Mapping | None]],
) -> tuple[bpy.types.Scene, list[Character], bool]:
    """The scene with a character for each ``(name, gender, armature, mapping)``, and whether it is the user's own.

    A ``.blend`` is opened once, however many of its armatures perform; everything else is brought into an empty scene or
    joins it, side by side. What was open before is lost. Raises :class:`RigUnusable`.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    files = {name for name, *_ in wanted if Path(name).suffix.lower() == ".blend"}
    if len(files) > 1:
        raise RigUnusable(f"Two scenes were asked for: {', '.join(sorted(files))}.", "Let all characters stand in one.")
    characters, fresh = {}, []
    # The file first: opening it would remove whoever is there already.
    for index in sorted(range(len(wanted)), key=lambda index: wanted[index][0] not in files):
        name, gender, armature, mapping = wanted[index]
        if name in files and characters:
            found = choose(Path(name).name, armature, mapping)
            characters[index] = Character(found, tuple(meshes(found)), mapping=mapping)
            continue
        before = {item for item in bpy.context.scene.objects if item.type == "ARMATURE"} if name not in files else set()
        characters[index], _ = summon(name, gender, armature, mapping, before)
        fresh += [characters[index]] if name not in files else []
    if not files:
        _line_up(fresh)
    return bpy.context.scene, [characters[index] for index in range(len(wanted))], bool(files)


def _line_up(characters: Sequence[Character]) -> None:
    """Side by side, the first on the left of the picture."""
    for index, character in enumerate(characters):
        top = character.armature
        while top.parent:
            top = top.parent
        top.location.x += SPACING * (index - (len(characters) - 1) / 2)
    bpy.context.view_layer.update()


def choose(source: str, name: str | None = None, mapping: Mapping | None = None, besides: Collection = ()):
    """The scene's armature object with arms, or the one called ``name``; raises :class:`RigUnusable` with the choices.

    One that stands alone is returned even without arms: whoever asked says what it lacks. ``besides`` are not chosen.
    """
    armatures = [item for item in bpy.context.scene.objects if item.type == "ARMATURE" and item not in besides]
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
    looks = [(item, reading.survey(item, mapping)[1]) for item in armatures]
    able = [item for item, refusal in looks if refusal is None]
    if not able:
        raise RigUnusable(f"No armature of {source} has arms: {listed}.", f"See one with --armature NAME. {looks[0][1].remedy}")
    if len(able) > 1:
        names = ", ".join(item.name for item in able)
        raise RigUnusable(f"{source} holds several characters: {names}.", "Choose one with --armature NAME.")
    return able[0]


def _load(path: Path) -> None:
    """Open a ``.blend`` (its scripts do not run), or import a character without its animation."""
    try:
        if path.suffix.lower() == ".blend":
            bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
        elif path.suffix.lower() == ".fbx":
            bpy.ops.import_scene.fbx(filepath=str(path), use_anim=False)
        else:
            before = set(bpy.context.scene.objects)
            bpy.ops.import_scene.gltf(filepath=str(path))
            for item in set(bpy.context.scene.objects) - before:
                item.animation_data_clear()
    except RuntimeError as error:
        reason = str(error).strip().splitlines()[-1]
        raise RigUnusable(f"{path} cannot be opened: {reason}", "Save it again from a Blender of this version.") from error


def _forget_missing_images() -> None:
    """Give clay to materials whose pictures did not come with the character, instead of Blender's magenta."""
    for material in bpy.data.materials:
        nodes = material.node_tree.nodes if material.node_tree else ()
        missing = [node for node in nodes if node.type == "TEX_IMAGE" and node.image and _is_missing(node.image)]
        for node in missing:
            nodes.remove(node)
        shader = next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)
        if missing and shader and not shader.inputs["Base Color"].is_linked:
            shader.inputs["Base Color"].default_value = material.diffuse_color = _CLAY
            shader.inputs["Alpha"].default_value, material.metallic, material.roughness = 1, 0, 0.6


def _is_missing(image: bpy.types.Image) -> bool:
    return image.source == "FILE" and not image.packed_file and not Path(bpy.path.abspath(image.filepath)).is_file()


def meshes(armature: ArmatureObject):
    """The meshes that follow an armature, by modifier or as its children."""
    for item in bpy.context.scene.objects:
        deformed = any(one.type == "ARMATURE" and one.object is armature for one in item.modifiers)
        if item.type == "MESH" and (deformed or item.parent is armature):
            yield item
