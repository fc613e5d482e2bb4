"""A face onto the shape keys of a character's meshes, in the action of its body where Blender has slots, else beside it.

Which key shows what is found by name (:mod:`rigs.faces.shapes`). An action of ours remembers the keys it drives and what they
had before, so that faces come and go with the take that they belong to.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from ...core.motion.face import Face
from ...rigs.faces import shapes
from .. import compat, provenance, stored
from ..cast import cast
from ..translations import told
from . import keyframes

FACES = "s2ag_faces"
"""Name of an action's custom property: JSON of the face that it drives, a list with an entry for every mesh."""
_ACTION, _BASE = "s2ag_face_action_{}", "s2ag_face_base_{}"  # pointers to actions, which survive renaming


@dataclass(frozen=True)
class Found:
    """A character's face: which of its keys show what, and the datablocks that have them."""

    shapes: shapes.Shapes
    keys: tuple[bpy.types.Key, ...]


def find(armature: bpy.types.Object, given: shapes.Shapes | None = None) -> Found | None:
    """The face of a character, by a map that is ``given`` or by the names of its shape keys; None where nothing speaks."""
    blocks = _keys(armature)
    known = given or shapes.detect({block.name: None for key in blocks for block in key.key_blocks}.keys())
    if known is None:
        return None
    keys = tuple(key for key in blocks if any(name in key.key_blocks for name in known.keys))
    return Found(known, keys) if keys else None


def lay(
    armature: bpy.types.Object,
    action: bpy.types.Action,
    face: Face,
    start: float,
    frames: np.ndarray,
    fps: float,
    tell: Callable[[str], None],
) -> bool:
    """Key ``face``, which begins at frame ``start``, on every one of the scene's ``frames`` (n,); whether there was one to key.

    ``action`` is the body's; nothing is assigned yet (:func:`show`). ``tell`` hears what the face cannot show.
    """
    found = find(armature)
    if found is None:
        tell(told("No shape keys that speak were found on {name}, so the face stays as it is.", name=armature.name))
        return False
    missing = found.shapes.missing()
    if missing:
        parts = ", ".join(told(part) for part in missing)
        tell(told("The face of {name} has nothing for: {parts}", name=armature.name, parts=parts))
    frames = np.asarray(frames, float)
    values = found.shapes.values(face.at((frames - start) / fps, fps))
    entries = []
    for number, key in enumerate(found.keys):
        own, slot, bag = _copied(action, key) or compat.key_bag(action, key)
        if own != action:
            own.name = f"{action.name} face"
            provenance.stamp(own, face.meta)
            action[_ACTION.format(number)] = own
        base = key.animation_data.action if key.animation_data else None
        if base is not None and not ours(base):
            action[_BASE.format(number)] = base
        channels = [
            keyframes.Channels("", f'key_blocks["{bpy.utils.escape_identifier(name)}"].value', {0: _within(key, name, column)})
            for name, column in values.items()
            if name in key.key_blocks
        ]
        keyframes.write_channels(bag, channels, frames)
        before = {name: key.key_blocks[name].value for name in values if name in key.key_blocks}
        entries.append({"key": key.name, "slot": compat.slot_name(slot), "before": before})
    action[FACES] = json.dumps(entries)
    return True


def _copied(action: bpy.types.Action, key: bpy.types.Key):
    """What the curves of a mesh's keys are in already, where the action is a copy of one with a face; else None."""
    for number, entry in enumerate(_entries(action)):
        slot, own = compat.find_slot(action, entry["slot"]), action.get(_ACTION.format(number))
        if entry["key"] == key.name and slot is not None:
            return action, slot, compat.bag(action, slot)
        if entry["key"] == key.name and own is not None:
            copy = own.copy()
            return copy, None, compat.bag(copy)
    return None


def ours(action: bpy.types.Action | None) -> bool:
    """Whether an action that a mesh's keys play is one of a face of ours."""
    return action is not None and (FACES in action or provenance.of(action) is not None)


def show(armature: bpy.types.Object, action: bpy.types.Action) -> None:
    """Let the meshes of a character play the face of an action of ours; faces of others of ours go."""
    entries = {entry["key"]: (number, entry) for number, entry in enumerate(_entries(action))}
    for key in _keys(armature):
        playing = key.animation_data.action if key.animation_data else None
        if key.name in entries:
            number, entry = entries[key.name]
            own = action.get(_ACTION.format(number)) or action
            if playing is not None and not ours(playing) and playing.library is None:
                playing.use_fake_user = True
            compat.assign_action(key, own, compat.find_slot(own, entry["slot"]))
        elif ours(playing):
            key.animation_data.action = None


def hide(armature: bpy.types.Object, action: bpy.types.Action) -> None:
    """Take the face of an action of ours off again: keys play what they played before, or are as they were."""
    for number, entry in enumerate(_entries(action)):
        own, base = action.get(_ACTION.format(number)) or action, action.get(_BASE.format(number))
        for key in _keys(armature):
            if key.name != entry["key"] or key.animation_data is None or key.animation_data.action != own:
                continue
            key.animation_data.action = base
            for name, value in entry["before"].items():
                if base is None and name in key.key_blocks:
                    key.key_blocks[name].value = value


def _entries(action: bpy.types.Action) -> list[dict]:
    kinds = {"key": str, "slot": str, "before": dict}
    found = stored.read(action, FACES, list)
    return [one for one in found if isinstance(one, dict) and kinds.keys() <= one.keys() and stored.fits(one, kinds)]


def _keys(armature: bpy.types.Object) -> list[bpy.types.Key]:
    found = {mesh.data.shape_keys for mesh in cast.meshes(armature) if mesh.data.shape_keys is not None}
    return sorted(found, key=lambda key: key.name)


def _within(key: bpy.types.Key, name: str, column: np.ndarray) -> np.ndarray:
    """Values within what the key's slider lets it have."""
    block = key.key_blocks[name]
    return np.clip(column, block.slider_min, block.slider_max)
