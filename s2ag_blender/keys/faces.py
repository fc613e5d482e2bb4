"""A face onto the shape keys of a character's meshes, in the action of its body where Blender has slots, else beside it.

Which key shows what is found by name (:mod:`rigs.faces.shapes`); what no key shows, bones of the armature may
(:mod:`rigs.faces.bones`), which are keyed like those of the body. An action of ours remembers the keys it drives and what they
had before, so that faces come and go with the take that they belong to.
"""

import json
from collections.abc import Callable

import bpy
import numpy as np

from ...core.motion.face import Face
from ...rigs.faces import bones as face_bones
from ...rigs.plain import Mapping
from .. import compat, provenance, stored
from ..cast import facial
from ..datablocks import ArmatureObject
from ..rig import reading
from ..translations import told
from . import keyframes

FACES = "s2ag_faces"
"""Name of an action's custom property: JSON of the face that it drives, a list with an entry for every mesh."""
_ACTION, _BASE = "s2ag_face_action_{}", "s2ag_face_base_{}"  # pointers to actions, which survive renaming


_SETTLE = 0.2
"""Seconds in which a face comes to rest where its motion ends and nothing else fades it out."""


def bone_channels(
    armature: ArmatureObject,
    face: Face,
    start: float,
    frames: np.ndarray,
    fps: float,
    mapping: Mapping,
    seen=None,
) -> list:
    """Channels of the bones that show ``face``, which begins at frame ``start``; with ``seen`` (n,) only so much of it."""
    found = facial.find(armature, mapping)
    if found is None or not found.bones:
        return []
    weights = _weights(face, start, frames, fps, seen)
    rotations, places = face_bones.moved(reading.read(armature), mapping, found.bones, weights)
    pose = armature.pose.bones
    keyed = [keyframes.channels(pose[name], values) for name, values in rotations.items()]
    keyed += [keyframes.place_channels(pose[name], values) for name, values in places.items()]
    return [keyframes.Channels("", one.path, one.values) for one in keyed]  # of no limb: none of their keys is left out


def settled(frames: np.ndarray, fps: float) -> np.ndarray:
    """How much of a face (n,) is seen that comes to rest as it ends."""
    return np.clip((frames[-1] - np.asarray(frames, float)) / max(_SETTLE * fps, 1.0), 0, 1)


def lay(
    armature: ArmatureObject,
    action: bpy.types.Action,
    face: Face,
    start: float,
    frames: np.ndarray,
    fps: float,
    tell: Callable[[str], None],
    seen: np.ndarray | None = None,
) -> bool:
    """Key ``face``, which begins at frame ``start``, on every one of the scene's ``frames`` (n,); whether there was one to key.

    ``action`` is the body's; nothing is assigned yet (:func:`show`). ``tell`` hears what the face cannot show. With ``seen``
    (n,) only so much of it is shown.
    """
    found = facial.find(armature, look=False)
    if found is None:
        tell(told("No shape keys that speak were found on {name}, so the face stays as it is.", name=armature.name))
        return False
    if found.missing:
        parts = ", ".join(told(part) for part in found.missing)
        tell(told("The face of {name} has nothing for: {parts}", name=armature.name, parts=parts))
    frames = np.asarray(frames, float)
    values = found.shapes.values(_weights(face, start, frames, fps, seen))
    entries = []
    for number, key in enumerate(found.keys):
        playing = key.animation_data.action if key.animation_data else None
        own, slot, bag = _copied(action, key) or compat.key_bag(action, key)
        if own != action:
            own.name = f"{action.name} face"
            provenance.stamp(own, face.meta)
            action[_ACTION.format(number)] = own
        if playing is not None and not ours(playing):
            action[_BASE.format(number)] = playing
        channels = [
            keyframes.Channels("", f'key_blocks["{bpy.utils.escape_identifier(name)}"].value', {0: _within(key, name, column)})
            for name, column in values.items()
            if name in key.key_blocks
        ]
        keyframes.write_channels(bag, channels, frames)
        before = {name: key.key_blocks[name].value for name in values if name in key.key_blocks}
        entries.append({"key": key.name, "slot": compat.slot_name(slot), "before": before | _former(playing, key)})
    action[FACES] = json.dumps(entries)
    return True


def _weights(face: Face, start: float, frames: np.ndarray, fps: float, seen: np.ndarray | None) -> np.ndarray:
    weights = face.at((np.asarray(frames, float) - start) / fps, fps)
    return weights if seen is None else weights * np.asarray(seen)[:, None]


def _former(playing: bpy.types.Action | None, key: bpy.types.Key) -> dict:
    """What an action of ours that plays remembers of a mesh's keys: its own values are nobody's rest."""
    entries = _entries(playing) if playing is not None else []
    return next((entry["before"] for entry in entries if entry["key"] == key.name), {})


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


def show(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Let the meshes of a character play the face of an action of ours; faces of others of ours go."""
    entries = {entry["key"]: (number, entry) for number, entry in enumerate(_entries(action))}
    for key in facial.keys(armature):
        playing = key.animation_data.action if key.animation_data else None
        if key.name in entries:
            number, entry = entries[key.name]
            own = action.get(_ACTION.format(number)) or action
            if playing is not None and not ours(playing) and playing.library is None:
                playing.use_fake_user = True
            compat.assign_action(key, own, compat.find_slot(own, entry["slot"]))
        elif ours(playing):
            key.animation_data.action = None


def hide(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Take the face of an action of ours off again: keys play what they played before, or are as they were."""
    for number, entry in enumerate(_entries(action)):
        own, base = action.get(_ACTION.format(number)) or action, action.get(_BASE.format(number))
        for key in facial.keys(armature):
            if key.name != entry["key"] or key.animation_data is None or key.animation_data.action != own:
                continue
            key.animation_data.action = base
            for name, value in entry["before"].items():
                if base is None and name in key.key_blocks:
                    key.key_blocks[name].value = value


def apart(action: bpy.types.Action) -> list[bpy.types.Action]:
    """The actions in which the face of an action of ours is, where it is not in that one: before 4.4."""
    found = [action.get(_ACTION.format(number)) for number in range(len(_entries(action)))]
    return [own for own in found if own is not None]


def _entries(action: bpy.types.Action) -> list[dict]:
    kinds = {"key": str, "slot": str, "before": dict}
    found = stored.read(action, FACES, list)
    return [one for one in found if isinstance(one, dict) and kinds.keys() <= one.keys() and stored.fits(one, kinds)]


def _within(key: bpy.types.Key, name: str, column: np.ndarray) -> np.ndarray:
    """Values within what the key's slider lets it have."""
    block = key.key_blocks[name]
    return np.clip(column, block.slider_min, block.slider_max)
