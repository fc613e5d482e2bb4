"""From a character's settings to gestures on it, in three steps: plan, let the engine work, finish.

:func:`plan` reads everything from Blender, :func:`finish` writes everything; between them no Blender data is held, so undo,
renaming and loading another file cannot hurt. Scripts and ``-b`` use :func:`wait`, which does all three.
"""

from dataclasses import dataclass, field

import bpy
import numpy as np

from ..core import skeleton
from ..core.errors import AudioUnreadable, S2agError, UsageError
from ..core.motion import Motion
from ..rigs.goals import Options
from ..rigs.plain import PARTS as BODY_PARTS
from ..rigs.plain import Mapping
from . import (
    apply,
    choices,
    compat,
    gesture,
    handpicked,
    keyframes,
    layers,
    markers,
    mixing,
    posing,
    readiness,
    recall,
    rig,
    sound,
    sources,
    takes,
)
from .translations import told

MEASURED = 10
"""A draft on a control rig is measured at one of so many frames of the motion, which has 15 a second."""
_PARTS = {
    "TORSO": ("torso",),
    "HEAD": ("neck", "head"),
    "CLAVICLES": ("left_clavicle", "right_clavicle"),
    "LEFT_ARM": ("left_upper_arm", "left_forearm"),
    "RIGHT_ARM": ("right_upper_arm", "right_forearm"),
}


@dataclass(frozen=True)
class Handle:
    """A datablock to find again: by what it is in this session, else by its name."""

    uid: int
    name: str

    @classmethod
    def of(cls, datablock: bpy.types.ID) -> "Handle":
        return cls(datablock.session_uid, datablock.name)

    def find(self, collection):
        """The datablock, or None if it is gone."""
        return next((item for item in collection if item.session_uid == self.uid), None) or collection.get(self.name)


@dataclass(frozen=True)
class Plan:
    """All that a run needs to know: ``params`` for the engine, and what to do with its answer."""

    armature: Handle
    scene: Handle
    params: dict
    voice: sources.Voice
    settings: dict
    mapping: Mapping | dict | None = None
    options: Options = field(default_factory=Options)
    pose: dict[str, np.ndarray] = field(default_factory=dict)
    draft: bool = False
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """What :func:`finish` made: actions, one a take, seconds of speech, and warnings for the user."""

    actions: list
    seconds: float
    warnings: list[str]


def plan(
    context,
    armature: bpy.types.Object,
    draft: bool = False,
    kept: dict | None = None,
    keyed_pose: dict[str, list] | None = None,
    **changes,
) -> Plan:
    """Read a character's settings and pose; ``changes`` go to the engine as they are (``styles``, ``near`` and so on).

    ``kept`` are settings of an earlier take (:func:`recall.snapshot`) to use instead of those that are set, and
    ``keyed_pose`` the pose ``{bone: (4,)}`` that it grew out of.

    Raises :class:`S2agError` for all that the user must mend first.
    """
    rig.require_armature(armature)
    settings, scene = recall.view(kept) if kept else armature.s2ag, context.scene
    voice = sources.voice(settings, scene)
    params = {**gesture.request(settings, voice.path), **({"takes": 1} if draft else {}), **changes}
    params = {name: value for name, value in params.items() if value is not None}
    warnings = _without_controls(params, settings)
    mapping = handpicked.chosen(settings)
    bones = rig.read(armature)
    resolved = (readiness.mapping(armature) if draft else None) or rig.resolve_mapping(armature, bones, mapping)
    pose = {bone: np.array(values) for bone, values in (keyed_pose or {}).items()}
    layered = settings.result == "LAYER"  # what is below it has the poses already
    if not pose and not layered and "CURRENT" in (settings.start_pose, settings.end_pose):
        pose = posing.current_rotations(armature, [name for part in BODY_PARTS for name in resolved.chains.get(part, ())])
    if settings.start_pose == "CURRENT" and not layered and "pose" not in params:
        params["pose"] = posing.directions(armature, bones, resolved, options(settings)).tolist()
    return Plan(
        Handle.of(armature),
        Handle.of(scene),
        params,
        voice,
        kept or recall.snapshot(settings),
        resolved if draft else mapping,
        options(settings),
        pose,
        draft,
        warnings,
    )


def _without_controls(params: dict, settings) -> tuple[str, ...]:
    """Take sliders that the checkpoint does not know from the engine's parameters; tells if any was set."""
    if choices.control_names(settings.checkpoint):
        return ()
    asked = [*params.pop("affect", {}).values(), params.pop("rate", 0), params.pop("hand", 0)]
    return (told("This checkpoint has intensity only: the other sliders were left out."),) if any(asked) else ()


def options(settings) -> Options:
    """How motions are laid onto a character, from its settings."""
    return Options(
        torso=settings.torso_strength if "TORSO" in settings.parts else 0.0,
        head=settings.head_strength if "HEAD" in settings.parts else 0.0,
        clavicle=settings.clavicle_strength if "CLAVICLES" in settings.parts else 0.0,
        palms=settings.palms,
    )


def wait(context, planned: Plan, progress=None) -> Outcome:
    """Let the engine work and finish: the way without a window. ``progress(stage, value)`` hears of it."""
    return finish(planned, gesture.call(context, planned.params, progress))


def finish(planned: Plan, result: dict) -> Outcome:
    """Lay the engine's motions onto the character; nothing is left behind if that fails.

    Raises :class:`S2agError`, also where the character or the scene is gone.
    """
    armature = planned.armature.find(bpy.data.objects)
    if armature is None:
        raise S2agError(f"The character {planned.armature.name} is gone.", "Nothing was changed.")
    scene = planned.scene.find(bpy.data.scenes) or bpy.context.scene
    rig.require_armature(armature)
    warnings = [*planned.warnings, *result.get("warnings", ())]
    laying = _Laying(planned, armature, scene, warnings.append)
    known = {action.name for action in bpy.data.actions}
    try:
        actions = [laying.action(motion) for motion in result["motions"]]
    except Exception:
        for action in [action for action in bpy.data.actions if action.name not in known]:
            bpy.data.actions.remove(action)
        raise
    if planned.draft:
        layers.show_draft(armature, actions[0])
        return Outcome(actions, result["motions"][0].duration, warnings)
    takes.add(armature, actions)
    _accompany(planned, scene, result["motions"][0], warnings)
    return Outcome(actions, result["motions"][0].duration, list(dict.fromkeys(warnings)))


class _Laying:
    """What all takes of a run share: the animation below, poses to start from and to reach, and the rig."""

    def __init__(self, planned: Plan, armature, scene, warn):
        self.planned, self.armature, self.scene, self.warn = planned, armature, scene, warn
        self.settings, self.span = planned.settings, planned.voice.span
        self.told: set[str] = set()
        self.there: dict[tuple, dict] = {}

    def action(self, motion: Motion) -> bpy.types.Action:
        """A new action with one motion, stamped with everything that it came from; a draft is made in its own action."""
        frames, rotations, settings = self._keys(motion)
        place = self._place(frames)
        base = layers.base_action(self.armature, place.first, place.last)
        interpolation = "LINEAR" if self.settings["key_step"] == 1 else "BEZIER"
        keyed = self._channels(frames, rotations, place, base) + self._settings(settings, place)
        copied = place.result == "ACTION" and base is not None
        action, slot, bag = self._draft(place) if self.planned.draft else (None, None, None)
        if action is None and copied:
            action, slot, bag = compat.copy_action(base, layers.slot_of(self.armature, base), self._name())
        elif action is None:
            action, slot, bag = compat.new_action(self._name(), self.armature)
        keyframes.write_channels(bag, keyed, frames, interpolation)
        if not copied:
            keyframes.set_range(action, frames)
        keyframes.stamp(action, self._provenance(motion, place))
        layers.remember(action, slot, base)
        playing = self.armature.animation_data and self.armature.animation_data.action
        keyframes.remember(action, self.armature, settings, keyframes.former(playing))
        return action

    def _keys(self, motion) -> apply.Keys:
        planned = self.planned
        keys = apply.pose_keys(
            self.armature,
            motion,
            self.span.start,
            scene=self.scene,
            mapping=planned.mapping,
            options=planned.options,
            step=self.settings["key_step"],
            first=self.span.first,
            last=np.inf if self.span.last is None else self.span.last,
            measured=MEASURED if planned.draft else 1,
            report=self._tell,
        )
        left_out = self._left_out()
        return keys._replace(rotations={bone: values for bone, values in keys.rotations.items() if bone not in left_out})

    def _left_out(self) -> set[str]:
        parts = [part for name, parts in _PARTS.items() if name not in self.settings["parts"] for part in parts]
        if len(self.settings["parts"]) == 0:
            raise UsageError("No part of the body is to be keyed.", "Choose parts under Advanced.")
        mapping = self._mapping()
        return {bone for part in parts for bone in mapping.chains.get(part, ())}

    def _mapping(self):
        return rig.resolve_mapping(self.armature, rig.read(self.armature), self.planned.mapping)

    def _tell(self, warning: str) -> None:
        if warning not in self.told:
            self.told.add(warning)
            self.warn(warning)

    def _place(self, frames) -> layers.Place:
        kept = self.settings
        first, last = int(frames[0]), int(frames[-1])
        result = "ACTION" if self.planned.draft else kept["result"]
        room = max((last - first) // 2, 0)
        fades = [min(kept[name], room) for name in ("blend_in", "blend_out")]
        if result == "STRIP":  # poses to continue from and to reach are in the keys
            fades = [fades[0] * (kept["start_pose"] == "REST"), fades[1] * (kept["end_pose"] == "FREE")]
        return layers.Place(result, first, last, kept["influence"] if result != "ACTION" else 1.0, *fades)

    def _channels(self, frames, rotations, place, base) -> list:
        if place.result == "LAYER":
            # What is the same on all frames is no departure from anything.
            rotations = {bone: values for bone, values in rotations.items() if len(values) == len(frames)}
            near = layers.added_numbers(self.armature, rotations)
            if near:
                self._tell(told("{count} bones turn by angles: far from rest the layer is only near on them.", count=len(near)))
            return layers.deltas(self.armature, rotations, self._neutral(rotations))
        mixed = self._mixed(frames, rotations, place, base)
        return [keyframes.channels(self.armature.pose.bones[bone], values) for bone, values in mixed.items()]

    def _neutral(self, rotations) -> dict:
        """Rotations (4,) of the bones when the body stands at ease."""
        still = Motion(np.repeat(skeleton.REST[None], 2, 0))
        found = apply.pose_keys(
            self.armature,
            still,
            0,
            scene=self.scene,
            mapping=self.planned.mapping,
            options=self.planned.options,
            report=lambda warning: None,
        )
        return {bone: found.rotations[bone][0] for bone in rotations}

    def _settings(self, settings: dict[str, float], place) -> list:
        """Channels of what lets the rig follow its keys; a layer adds to what is there."""
        if place.result == "LAYER":
            present = {path: self.armature.path_resolve(path) for path in settings}
            settings = {path: value - present[path] for path, value in settings.items() if value != present[path]}
        return keyframes.setting_channels(settings)

    def _mixed(self, frames, rotations, place, base) -> dict:
        """Rotations with the start, the end, and in a new action the animation that is there, blended in."""
        kept = self.settings
        there = place.result == "ACTION" and layers.is_animated(self.armature, base)
        if kept["start_pose"] == "CURRENT":
            share = mixing.ramp(frames, max(kept["blend_in"], 1))
            rotations = mixing.mix(rotations, self.planned.pose, share)
        elif there and place.blend_in:
            rotations = self._over(frames, rotations, base, place.blend_in, at_end=False)
        if kept["end_pose"] != "FREE":
            pose = self.planned.pose
            if kept["end_pose"] == "THERE":
                pose = {bone: values[0] for bone, values in self._there(rotations, frames[-1:], base).items()}
            rotations = mixing.mix(rotations, pose, mixing.ramp(frames, max(kept["blend_out"], 1), at_end=True))
        elif there and place.blend_out:
            rotations = self._over(frames, rotations, base, place.blend_out, at_end=True)
        return rotations

    def _over(self, frames, rotations, base, length, at_end) -> dict:
        share = mixing.ramp(frames, length, at_end)
        few = share < 1
        below = self._there(rotations, frames[few], base)
        mixed = {}
        for bone, values in rotations.items():
            mixed[bone] = np.array(np.broadcast_to(values, (len(frames), 4)))
        part = mixing.mix({bone: values[few] for bone, values in mixed.items()}, below, share[few])
        for bone, values in part.items():
            mixed[bone][few] = values
        return mixed

    def _there(self, bones, frames, base) -> dict:
        """What the animation that is there has on these frames, read once for all takes."""
        key = tuple(int(frame) for frame in frames)
        if key not in self.there:
            with layers.below(self.armature, base, self.span):
                self.there[key] = posing.local_rotations(self.armature, list(bones), key, self.scene)
        return self.there[key]

    def _draft(self, place) -> tuple:
        """The draft that the character plays already on these frames, with slot and curves, else nothing."""
        action = layers.draft(self.armature)
        if action is None or not place.same(layers.Place.of(action)):
            return None, None, None
        slot = layers.slot_of(self.armature, action)
        return action, slot, compat.bag(action, slot)

    def _name(self) -> str:
        return f"{self.armature.name} {'draft' if self.planned.draft else 'gesture'}"

    def _provenance(self, motion, place) -> dict:
        planned = self.planned
        origin = {
            **motion.meta,
            "place": place.__dict__,
            "start": self.span.start,
            "settings": self.settings,
            "pose": planned.params.get("pose"),
            "keyed_pose": {bone: values.round(6).tolist() for bone, values in planned.pose.items()},
        }
        return {**origin, layers.DRAFT: True} if planned.draft else origin


def _accompany(planned: Plan, scene, motion: Motion, warnings: list[str]) -> None:
    """The sound strip and the word markers, where they are wanted."""
    span, kept = planned.voice.span, planned.settings
    if kept["add_sound"] and not planned.voice.placed:
        try:
            sound.add_sound(scene, planned.voice.path, round(span.start))
        except AudioUnreadable as error:  # the engine reads more formats than Blender's sound system
            warnings.append(f"The gestures are there, the sound strip is not: {error}")
    elif planned.voice.placed:
        scene.sync_mode = "AUDIO_SYNC"
    if kept["add_markers"]:
        if motion.words:
            markers.add(scene, motion.words, span.start, kept["marker_prefix"], span.first, span.last)
        else:
            warnings.append("There are no word markers, because the words are not known.")

