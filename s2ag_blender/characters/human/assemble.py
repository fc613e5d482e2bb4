"""Builds the character ``human``: body, clothes, hair and eyes on one of five rigs."""

import json
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

from ...datablocks import current_context
from .. import materials, skinned_surface
from ..character import Character
from ..skinned_surface import Surface
from . import clothes, data, face, hair, rig, teeth, textures

_LOOKS = json.loads(Path(__file__).with_name("looks.json").read_text("utf-8"))
_EYES = ("helper-l-eye", "helper-r-eye")
_LASHES = ("helper-l-eyelashes-2", "helper-r-eyelashes-2")


def build(rig_name: str = "default", gender: str = "female", collection: bpy.types.Collection | None = None) -> Character:
    """Build the human into a new collection of the current scene.

    ``rig_name`` is one of :data:`data.RIGS`, ``gender`` one of :data:`data.GENDERS`. Raises :class:`RigUnusable` for an
    unknown rig or damaged body data."""
    bones, weights = data.weights(rig_name)
    points = data.person(gender)
    if collection is None:
        collection = bpy.data.collections.new("Human")
        current_context().scene.collection.children.link(collection)
    armature = rig.armature("Human", rig_name, points, collection)
    parts = []
    for name, mesh, looks, fine, rows in _parts(points, weights, gender):
        parts.append(skinned_surface.to_object(f"Human {name}", mesh, bones, looks, collection, fine))
        if rows is not None and not fine:
            face.add_keys(parts[-1], points, rows)
        elif rows is not None:
            face.add_fine_keys(parts[-1], mesh, rows, fine, collection)
    for part in parts:
        skinned_surface.follow(part, armature)
    rig.relax_hands(armature, points)
    return Character(armature, tuple(parts), collection)


def _parts(
    points: np.ndarray, weights: np.ndarray, gender: str
) -> Iterator[tuple[str, Surface, list[bpy.types.Material], int, np.ndarray | None]]:
    """Yield (name, surface, materials, subdivisions, rows of ``points`` for shape keys or None) of body parts and clothes."""
    palette, wardrobe, mesh = textures.Palette(**_LOOKS[gender]["palette"]), _LOOKS[gender]["wardrobe"], data.base_mesh()
    tailor = clothes.Tailor(points, weights)
    skin, looks, rows = _skin(tailor, palette, gender)
    yield "Skin", skin, looks, 0, rows
    yield "Eyes", *_eyes(points, weights, palette), 1, np.concatenate([np.unique(mesh.faces[name]) for name in _EYES])
    body = np.unique(data.base_mesh().faces["body"])
    crown = weights[body[np.argmax(points[body, 2])]]
    bitten = face.align_teeth(points)
    for name, quads, uvs, look in _mouth(bitten):  # shape keys move them with the jaw
        skin = Surface.of(bitten, quads, np.repeat(crown[None], len(points), 0), 0, uvs)
        yield name, skin, [look], 0, np.unique(quads)
    if gender == "female":
        lashes = np.concatenate([data.base_mesh().faces[name] for name in _LASHES])
        look = materials.plain("Lashes", (0.01, 0.008, 0.007))
        yield "Lashes", Surface.of(points, lashes, weights), [look], 0, np.unique(lashes)
    knit = materials.plain("Jumper", wardrobe["jumper"], 0.9, specular=0.15)
    rib = materials.plain("Rib", wardrobe["rib"], 0.9, specular=0.15)
    yield "Jumper", tailor.jumper(), [knit, rib], 1, None
    yield "Trousers", tailor.trousers(), [materials.plain("Trousers", wardrobe["trousers"], 0.85, specular=0.2)], 1, None
    leather, sole = materials.plain("Shoe", (0.035, 0.022, 0.016), 0.4), materials.plain("Sole", (0.012, 0.012, 0.012), 0.8)
    yield "Shoes", tailor.shoes(), [leather, sole], 1, None
    cut = hair.tied_back if gender == "female" else hair.short
    strands = materials.image("Human hair", textures.strands(palette))
    locks = materials.painted("Hair", strands, palette.hair, 0.45, 0.35)
    yield "Hair", cut(hair.Head.of(points), crown), [locks], 0, None


def _skin(
    tailor: clothes.Tailor, palette: textures.Palette, gender: str
) -> tuple[Surface, list[bpy.types.Material], np.ndarray]:
    """Return the surface of the visible skin, its materials, and its rows of the base mesh's points."""
    mesh = data.base_mesh()
    faces = mesh.faces["body"]
    shown = tailor.shown()[faces].all(1)
    canvas = textures.Canvas(hair.Head.of(tailor.points))
    brow = 0.0052 if gender == "female" else 0.0078
    picture = canvas.paint(palette, mesh.masks["lips"], face.lids(faces, len(tailor.points)), brow)
    uvs = canvas.uvs(faces[shown], mesh.masks["fingernails"][shown])
    skin = Surface.of(tailor.points, faces[shown], tailor.weights, 0, uvs)
    skin.slots[face.mouth_inside(faces, mesh.masks["lips"], len(tailor.points))[shown]] = 1
    looks = [materials.painted("Skin", materials.image("Human skin", picture), palette.skin)]
    return skin, [*looks, materials.plain("Mouth", (0.16, 0.03, 0.03), 0.7)], np.unique(faces[shown])


def _mouth(points: np.ndarray) -> Iterator[tuple[str, np.ndarray, np.ndarray | None, bpy.types.Material]]:
    """Yield (name, quads, texture coordinates or None, material) of teeth and tongue."""
    lower, upper = face.surface("helper-lower-teeth"), face.surface("helper-upper-teeth")
    uvs = np.concatenate([teeth.uvs(points, upper, True), teeth.uvs(points, lower, False)])
    enamel = materials.painted("Teeth", materials.image("Human teeth", teeth.image()), (0.6, 0.55, 0.46), 0.25)
    yield "Teeth", np.concatenate([upper, lower]), uvs, enamel
    yield "Tongue", face.surface("helper-tongue"), None, materials.plain("Tongue", (0.34, 0.10, 0.095), 0.4)


def _eyes(points: np.ndarray, weights: np.ndarray, palette: textures.Palette) -> tuple[Surface, list[bpy.types.Material]]:
    """Return both eyeballs, with the eye image projected from the front, and their materials."""
    mesh = data.base_mesh()
    both = []
    for name in _EYES:
        faces = mesh.faces[name]
        ball = points[np.unique(faces)]
        middle, radius = (ball.max(0) + ball.min(0)) / 2, (ball.max(0) - ball.min(0)).max() / 2
        uvs = ((points[faces] - middle) / radius)[..., [0, 2]] / 2 + 0.5
        both.append(Surface.of(points, faces, weights, 0, uvs))
    image = materials.image("Human eye", textures.eye(palette))
    return both[0].joined(both[1]), [materials.painted("Eye", image, (0.7, 0.69, 0.67), 0.1, 0.5)]
