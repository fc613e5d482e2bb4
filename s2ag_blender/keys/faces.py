"""Keys a face on the shape keys of a character's meshes, in the body's action where Blender has slots, else in another one.

Shape keys are detected by name (:mod:`rigs.faces.shapes`); what no shape key can show, facial bones may
(:mod:`rigs.faces.bones`), which are keyed like those of the body. The body's action stores which shape keys it drives and
their former values, so that faces are shown and hidden with their take."""

import json
from collections.abc import Callable
from typing import Any

import bpy
import numpy as np

from ...core.motion.face import Face
from ...rigs.faces import bones as face_bones
from ...rigs.skeleton import Mapping
from .. import compat, json_properties, provenance
from ..characters import face_lookup
from ..datablocks import ArmatureObject, Bag, Slot
from ..rig import reading
from ..translations import translate
from . import keyframes

FACES = "s2ag_faces"
"""Name of an action's custom property: JSON of the face that it drives, a list with one entry per mesh."""
_ACTION, _BASE = "s2ag_face_action_{}", "s2ag_face_base_{}"  # pointers to actions, which survive renaming
_FADE_SECONDS = 0.2
"""Seconds in which a face fades to rest at the end of its motion if nothing else fades it out."""


def bone_channels(
    armature: ArmatureObject, face: Face, start: float, frames: np.ndarray, fps: float, mapping: Mapping,
    seen: np.ndarray | None = None
) -> list[keyframes.Channels]:  # fmt: skip
    """Return the channels of the facial bones for ``face``, which begins at frame ``start``, weighted by ``seen`` (n,)."""
    parts = face_lookup.find(armature, mapping)
    if parts is None or not parts.bones:
        return []
    weights = _weights(face, start, frames, fps, seen)
    rotations, places = face_bones.bone_motion(reading.read(armature), mapping, parts.bones, weights)
    pose = armature.pose.bones
    keyed = [keyframes.channels(pose[name], values) for name, values in rotations.items()]
    keyed += [keyframes.place_channels(pose[name], values) for name, values in places.items()]
    return [keyframes.Channels("", one.path, one.values) for one in keyed]  # without a bone name all their keys are kept


def end_fade(frames: np.ndarray, fps: float) -> np.ndarray:
    """Return the weight (n,) of a face that fades to rest at its end."""
    return np.clip((frames[-1] - np.asarray(frames, float)) / max(_FADE_SECONDS * fps, 1.0), 0, 1)


def key_face(
    armature: ArmatureObject, action: bpy.types.Action, face: Face, start: float, frames: np.ndarray, fps: float,
    tell: Callable[[str], None], seen: np.ndarray | None = None
) -> bool:  # fmt: skip
    """Key ``face``, which begins at frame ``start``, at the scene's ``frames`` (n,); return whether there are shape keys.

    ``action`` is the body's; nothing is assigned yet (:func:`show`). A sentence about parts that the face cannot show goes to
    ``tell``. ``seen`` (n,) are weights of the face."""
    parts = face_lookup.find(armature, look=False)
    if parts is None:
        tell(translate("No shape keys that speak were found on {name}, so the face stays as it is.", name=armature.name))
        return False
    if parts.missing:
        missing = ", ".join(translate(part) for part in parts.missing)
        tell(translate("The face of {name} has nothing for: {parts}", name=armature.name, parts=missing))
    frames = np.asarray(frames, float)
    values = parts.shapes.values(_weights(face, start, frames, fps, seen))
    entries = []
    for number, key in enumerate(parts.keys):
        playing = key.animation_data.action if key.animation_data else None
        own, slot, bag = _copied_bag(action, key) or compat.key_bag(action, key)
        if own != action:
            own.name = f"{action.name} face"
            provenance.stamp(own, face.meta)
            action[_ACTION.format(number)] = own
        if playing is not None and not is_ours(playing):
            action[_BASE.format(number)] = playing
        channels = [
            keyframes.Channels("", f'key_blocks["{bpy.utils.escape_identifier(name)}"].value', {0: _clip(key, name, column)})
            for name, column in values.items()
            if name in key.key_blocks
        ]
        keyframes.write_channels(bag, channels, frames)
        before = {name: key.key_blocks[name].value for name in values if name in key.key_blocks}
        entries.append({"key": key.name, "slot": compat.slot_name(slot), "before": before | _former(playing, key)})
    action[FACES] = json.dumps(entries)
    return True


def _weights(face: Face, start: float, frames: np.ndarray, fps: float, seen: np.ndarray | None) -> np.ndarray:
    """Return the face's weights (n, channels) at scene frames."""
    weights = face.at((np.asarray(frames, float) - start) / fps, fps)
    return weights if seen is None else weights * np.asarray(seen)[:, None]


def _former(playing: bpy.types.Action | None, key: bpy.types.Key) -> dict[str, float]:
    """Return the former values of a mesh's shape keys as stored by the action that plays on them; {} if none is stored."""
    entries = _entries(playing) if playing is not None else []
    return next((entry["before"] for entry in entries if entry["key"] == key.name), {})


def _copied_bag(action: bpy.types.Action, key: bpy.types.Key) -> tuple[bpy.types.Action, Slot | None, Bag] | None:
    """Return ``(action, slot, bag)`` of a mesh's shape keys if the action is a copy of one with a face, else None."""
    for number, entry in enumerate(_entries(action)):
        slot, own = compat.find_slot(action, entry["slot"]), provenance.linked(action, _ACTION.format(number))
        if entry["key"] == key.name and slot is not None:
            return action, slot, compat.bag(action, slot)
        if entry["key"] == key.name and own is not None:
            copy = own.copy()
            return copy, None, compat.bag(copy)
    return None


def is_ours(action: bpy.types.Action | None) -> bool:
    """Return whether an action of a mesh's shape keys was made by this package."""
    return action is not None and (FACES in action or provenance.read(action) is not None)


def show(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Assign the face of an action to a character's meshes; other faces made by this package are unassigned."""
    entries = {entry["key"]: (number, entry) for number, entry in enumerate(_entries(action))}
    for key in face_lookup.keys(armature):
        playing = key.animation_data.action if key.animation_data else None
        if key.name in entries:
            number, entry = entries[key.name]
            own = provenance.linked(action, _ACTION.format(number)) or action
            if playing is not None and not is_ours(playing) and playing.library is None:
                playing.use_fake_user = True
            compat.assign_action(key, own, compat.find_slot(own, entry["slot"]))
        elif is_ours(playing):
            compat.assign_action(key, None)


def hide(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Unassign the face of an action: shape keys get back their former action, or their former values."""
    for number, entry in enumerate(_entries(action)):
        own, base = provenance.linked(action, _ACTION.format(number)) or action, provenance.linked(action, _BASE.format(number))
        for key in face_lookup.keys(armature):
            if key.name != entry["key"] or key.animation_data is None or key.animation_data.action != own:
                continue
            key.animation_data.action = base
            for name, value in entry["before"].items():
                if base is None and name in key.key_blocks:
                    key.key_blocks[name].value = value


def separate_actions(action: bpy.types.Action) -> list[bpy.types.Action]:
    """Return the separate actions of an action's face, as before Blender 4.4; none where it is in slots of the action."""
    actions = [provenance.linked(action, _ACTION.format(number)) for number in range(len(_entries(action)))]
    return [own for own in actions if own is not None]


def _entries(action: bpy.types.Action) -> list[dict[str, Any]]:
    """Return the valid entries of the property :data:`FACES`."""
    kinds = {"key": str, "slot": str, "before": dict}
    entries = json_properties.read(action, FACES, list)
    return [
        one for one in entries if isinstance(one, dict) and kinds.keys() <= one.keys() and json_properties.has_types(one, kinds)
    ]


def _clip(key: bpy.types.Key, name: str, column: np.ndarray) -> np.ndarray:
    """Clip values to the range of a shape key's slider."""
    block = key.key_blocks[name]
    return np.clip(column, block.slider_min, block.slider_max)
