"""Gestures as action assets: beside keys for one rig they hold the motion itself, which can be keyed on any other.

The motion is JSON in the custom property :data:`GESTURE`: frames a second, directions and hands of each frame, the second of
the stroke, kind, side (left, right or both) and performer."""

import contextlib
import json
import uuid
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ...core.errors import OutputUnwritable, UsageError
from ...core.files import atomic_file, read_bytes
from ...core.meaning import gesture_picture
from ...core.motion import hand_channels, skeleton
from ...core.motion.motion import MAX_FPS, Motion
from ...rigs.goals import Goals
from ...rigs.proportions import SIDES
from ...rigs.slices import run_to_end
from .. import json_properties, provenance
from ..datablocks import ArmatureObject, current_context
from ..keys import apply, keyframes, layers, poses
from ..rig import chosen_bones, reading
from . import stored_settings

GESTURE = "s2ag_gesture"
"""Name of the action's custom property."""
CATALOGUE = "s2ag_catalogue"
"""Name of the action's custom property with the path of its catalogue, which Blender itself knows by number alone."""
_CATALOGUES = "blender_assets.cats.txt"
_PICTURE = 256
_WIDTH = 27 + hand_channels.SIZE
_FACTS = {"stroke": 0.0, "kind": "", "side": "both", "performer": ""}
_MOST, _LONGEST = 5_000, 1000.0
"""Frames that an asset may have, and its seconds."""
_KINDS = {"stroke": (int, float), "kind": str, "side": str, "performer": str}


def capture(armature: ArmatureObject, scene: bpy.types.Scene, first: int, last: int) -> Motion:
    """Return what the character does from frame ``first`` to ``last``, whatever moves it, with its hands.

    Raises :class:`S2agError` for too many frames, and for characters and scenes that cannot be read."""
    if last - first > _MOST:
        raise UsageError(f"{armature.name} moves for {last - first} frames.", f"An asset has {_MOST} at most.")
    bones = reading.read(armature)
    mapping = reading.resolve_mapping(armature, bones, chosen_bones.mapping_of_settings(armature.s2ag))
    options, before = stored_settings.options(armature.s2ag), (scene.frame_current, scene.frame_subframe)
    goals = Goals(bones, mapping, skeleton.REST[None], clear=False)
    palms = {side: goals.hand(side) for side in SIDES}
    directions, hands = [], []
    try:
        for frame in range(first, max(last, first + 1) + 1):
            scene.frame_set(frame)
            directions.append(poses.directions(armature, bones, mapping, options))
            hands.append(poses.hands(armature, bones, mapping, palms))
    finally:
        scene.frame_set(before[0], subframe=before[1])
    shown = hand_channels.Hands.of(*(np.stack(part) for part in zip(*hands, strict=True)))
    return Motion(np.stack(directions), apply.scene_fps(scene), (), {"source": armature.name}, shown)


def save(
    armature: ArmatureObject, motion: Motion, name: str, catalogue: str, facts: Mapping[str, Any], **about: str
) -> bpy.types.Action:  # fmt: skip
    """Return a new asset of ``motion``, which has hands, keyed on this character but not played by it.

    ``catalogue`` is a path such as S2AG/Beats, ``facts`` are stroke, kind, side and performer, ``about`` fields of the asset:
    author, license, copyright, description. Raises :class:`S2agError`."""
    scene, settings = current_context().scene, armature.s2ag
    apply.require_rate(scene)
    told = {"mapping": chosen_bones.mapping_of_settings(settings), "options": stored_settings.options(settings)}
    keys = apply.solve_keys(armature, motion, 1, scene=scene, **told)
    action, slot = run_to_end(keyframes.write_action(name, armature, keys.rotations, keys.frames, settings=keys.settings))
    layers.store_base(action, slot, None)
    provenance.stamp(action, motion.meta)
    assert motion.hands is not None
    parts = motion.directions.reshape(-1, 27), hand_channels.to_channels(motion.hands, motion.directions)
    numbers = np.concatenate(parts, -1).astype(float).round(4).tolist()
    action[GESTURE] = json.dumps({**_FACTS, **facts, "fps": motion.fps, "numbers": numbers})
    action.asset_mark()
    told = action.asset_data
    assert told is not None
    for field, text in about.items():
        setattr(told, field, text)
    told.catalog_id = str(_identify(catalogue))
    for tag in dict.fromkeys(str(facts[key]) for key in ("kind", "side", "performer") if facts.get(key)):
        told.tags.new(tag)
    action[CATALOGUE] = catalogue
    picture = action.preview_ensure()
    picture.image_size = _PICTURE, _PICTURE
    shown = gesture_picture.gesture_of(motion, float(facts.get("stroke", 0)), str(facts.get("side", "both")))
    pixels: Any = picture.image_pixels_float
    pixels.foreach_set(gesture_picture.draw(shown, _PICTURE).ravel().astype(np.float32))
    return action


def read_motion(action: bpy.types.Action) -> tuple[Motion, dict[str, Any]] | None:
    """Return the motion that an asset holds, and the facts of :func:`save`; None if it holds none."""
    held = json_properties.read(action, GESTURE)
    facts = {name: held.get(name, usual) for name, usual in _FACTS.items()}
    fps = held.get("fps")
    try:
        numbers = np.array(held.get("numbers"), float)
    except (TypeError, ValueError):
        return None
    if numbers.ndim != 2 or len(numbers) < 2 or numbers.shape[1] != _WIDTH or not np.isfinite(numbers).all():
        return None
    if not isinstance(fps, (int, float)) or not 0 < fps <= MAX_FPS or not json_properties.has_types(facts, _KINDS):
        return None
    if not 0 <= facts["stroke"] <= len(numbers) / fps <= _LONGEST:
        return None
    directions = skeleton.normalize(numbers[:, :27].reshape(-1, 9, 3)).astype(np.float32)
    hands = hand_channels.from_channels(numbers[:, 27:], directions)
    return Motion(directions, float(fps), (), {"asset": action.name}, hands), facts


@contextlib.contextmanager
def borrowed(name: str, library: str = "") -> Iterator[bpy.types.Action | None]:
    """Yield the action ``name`` of this file, or of the .blend file ``library``, of which nothing stays; None if it has none.

    Raises :class:`UsageError` for a file that is no .blend file."""
    if library in ("", bpy.data.filepath):
        yield bpy.data.actions.get(name)
        return
    known, load = set(bpy.data.user_map()), cast(Any, bpy.data.libraries.load)
    try:
        with load(library) as (there, wanted):
            wanted.actions = [one for one in there.actions if one == name]
    except (OSError, ValueError) as error:
        raise UsageError(f"{library} cannot be read as a .blend file.", "Choose a library of gestures.") from error
    try:
        yield next(iter(wanted.actions), None)
    finally:  # what its custom properties point at has come along
        bpy.data.batch_remove(list(set(bpy.data.user_map()) - known))


def assets() -> list[bpy.types.Action]:
    """Return the gestures among the actions of this file, by name."""
    return sorted((one for one in bpy.data.actions if GESTURE in one), key=lambda one: one.name)


def write_catalogues(path: str | Path) -> None:
    """Make the catalogues of all gestures known to the asset library that the .blend file ``path`` belongs to.

    Raises :class:`OutputUnwritable`."""
    wanted = {json_properties.text(action, CATALOGUE) for action in assets()}
    wanted = {one for one in wanted if one.isprintable() and one.strip("/") and ":" not in one}
    roots = [Path(one.path) for one in current_context().preferences.filepaths.asset_libraries if one.path]
    folder = next((root for root in roots if Path(path).is_relative_to(root)), Path(path).parent)
    try:
        file = folder / _CATALOGUES
        text = read_bytes(file).decode().rstrip("\r\n") if file.exists() else "VERSION 1"
        ids = {line.split(":")[0] for line in text.split("\n")}
        lines = [f"{_identify(one)}:{one}:{one.replace('/', '-')}" for one in sorted(wanted)]
        missing = [line for line in lines if line.split(":")[0] not in ids]
        if missing:
            with atomic_file(file) as temporary:
                temporary.write_text("\n".join([text, *missing, ""]), "utf-8", newline="")
    except (OSError, UnicodeDecodeError) as error:
        what = f"The catalogues in {folder} cannot be written: {error}."
        raise OutputUnwritable(what, "The gestures are saved without catalogue.") from error


def _identify(catalogue: str) -> uuid.UUID:
    return uuid.uuid5(uuid.NAMESPACE_URL, f"s2ag:{catalogue}")
