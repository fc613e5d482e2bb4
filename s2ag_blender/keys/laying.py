"""Motions of one run onto a character: keys beside, over or added to the animation that is there, as actions of ours."""

from collections.abc import Callable, Generator
from dataclasses import replace

import bpy
import numpy as np

from ...core.errors import S2agError, UsageError
from ...core.motion import quaternion, skeleton
from ...core.motion.motion import Motion
from ...core.performance import living
from ...rigs.plain import Mapping
from ...rigs.proportions import Girth
from .. import compat, provenance
from ..datablocks import ArmatureObject
from ..rig import girth, readiness, reading
from ..translations import told
from . import apply, density, faces, keyframes, layers, mixing, pacing, posing, thinning

MEASURED = 10
"""A draft on a control rig is measured at one of so many frames of the motion, which has 15 a second."""
BATCH = 8
"""Bones that are keyed in a slice; a minute of one costs 3 ms."""
DRAFT = 15.0
"""Seconds of a draft around the playhead."""
_PARTS = {
    "TORSO": ("torso",),
    "HEAD": ("neck", "head"),
    "CLAVICLES": ("left_clavicle", "right_clavicle"),
    "LEFT_ARM": ("left_upper_arm", "left_forearm"),
    "RIGHT_ARM": ("right_upper_arm", "right_forearm"),
}
_ALIKE = "result", "parts", "bone_map"
"""Settings by which drafts key the same bones, beside whether hands live."""
_NEUTRAL: dict[int, tuple] = {}  # a character's number in this session -> (what its rotations at ease hang on, they)


class Laying:
    """What all takes of a run share: the animation below, poses to start from and to reach, and the rig."""

    def __init__(self, planned, armature: ArmatureObject, scene: bpy.types.Scene, warn: Callable[[str], None]):
        """Lay out a ``generate.Plan``; ``warn`` hears every warning once."""
        self.planned, self.armature, self.scene, self.warn = planned, armature, scene, warn
        self.settings, self.span = planned.settings, planned.voice.span
        self.told: set[str] = set()
        self.there: dict[tuple, dict] = {}
        self.mapping: Mapping | None = None
        self.trunk: Girth | None = None
        self.former = layers.formers(armature)

    def acting(self, motion: Motion, keys: apply.Keys, made: list[int]) -> Generator[None, None, bpy.types.Action]:
        """A new action with the ``keys`` of one motion, stamped with everything that it came from, in slices.

        A draft is made in its own action. The number of a new one is put into ``made`` as soon as it is there. Between slices
        anything may happen to Blender's data: whoever goes on sets ``armature`` and ``scene`` anew.
        """
        frames, rotations, settings, places, stood = keys
        place = self._place(frames)
        base = layers.base_action(self.armature, place.first, place.last, place.piece)
        interpolation = "LINEAR" if self.step == 1 else "BEZIER"
        legs = {bone: rotations[bone] for bone in stood if bone in rotations}
        body = {bone: values for bone, values in rotations.items() if bone not in stood}
        keyed = self._channels(motion, frames, body, legs, place, base) + self._settings(settings, place)
        keyed += self._places(frames, places, place, base)
        spoken, every = self._spoken(motion, frames, place)
        yield
        thinner = self._thinner(frames, rotations, stood)
        base = layers.base_action(self.armature, place.first, place.last, place.piece)
        copied = place.result == "ACTION" and base is not None
        there = compat.curves(base, layers.slot_of(self.armature, base)) if copied else ()
        cut = {(curve.data_path, curve.array_index) for curve in there}
        action, slot, bag = self._draft(place) if self.planned.draft else (None, None, None)
        if action is None and copied:
            action, slot, bag = compat.copy_action(base, layers.slot_of(self.armature, base), self._name())
        elif action is None:
            action, slot, bag = compat.new_action(self._name(), self.armature)
        made += [action.session_uid] if action != layers.draft_of(self.armature) else []
        if not copied:
            keyframes.set_range(action, frames)
        provenance.stamp(action, self._provenance(motion, place))
        layers.remember(action, slot, base)
        keyframes.remember(action, self.armature, {one.path for one in keyed + spoken}, self.former)
        density.note(action, keyed, stood)
        uid = action.session_uid
        for first in range(0, len(keyed), BATCH):
            keyframes.write_channels(bag, keyed[first : first + BATCH], frames, interpolation, thinner, cut)
            yield
            action, bag = self._again(uid)
        if motion.face is not None:
            keyframes.write_channels(bag, spoken, every, "LINEAR", None, cut)
            yield
            action, bag = self._again(uid)
            rate, seen = apply.scene_fps(self.scene), self._face_seen(every, place)
            faces.lay(self.armature, action, motion.face, self.span.start, every, rate, self._tell, seen)
        return action

    def _spoken(self, motion: Motion, frames: np.ndarray, place) -> tuple[list, np.ndarray]:
        """Channels of the bones of a face, which has keys on every frame, and these."""
        every = np.arange(frames[0], frames[-1] + 1)
        if motion.face is None:
            return [], every
        rate, strip = apply.scene_fps(self.scene), place.result != "ACTION" and not self.planned.draft
        seen = faces.settled(every, rate) if strip else self._face_seen(every, place)  # a strip has its own influence
        return faces.bone_channels(self.armature, motion.face, self.span.start, every, rate, self.mapping, seen), every

    def _face_seen(self, every, place) -> np.ndarray | None:
        """How much of a face (n,) is seen: as much as of a layer, and none as it ends; all of a piece within another."""
        if place.piece:
            return None
        return layers.share(place, every) * faces.settled(every, apply.scene_fps(self.scene))

    def _again(self, uid: int) -> tuple:
        """The action of that number in this session and what holds its curves, or :class:`S2agError`."""
        action = next((one for one in bpy.data.actions if one.session_uid == uid), None)
        if action is None:
            raise S2agError("Gestures were undone while they came.", "Nothing was changed.")
        return action, compat.bag(action, layers.slot_of(self.armature, action))

    @property
    def few(self) -> bool:
        """Whether only keys that matter are wanted; a draft has all, which is quicker."""
        return self.settings.get("curves") == "POSES" and not self.planned.draft

    @property
    def step(self) -> int:
        """Frames between keys before any are left out."""
        return 1 if self.settings.get("curves") == "POSES" else self.settings["key_step"]

    @property
    def fps(self) -> float:
        """Keys a second."""
        return apply.scene_fps(self.scene) / self.step

    def _thinner(self, frames: np.ndarray, rotations, stood) -> thinning.Thinner | None:
        if not self.few:
            return None
        limbs = density.limbs(reading.read(self.armature), self.mapping)
        return thinning.Thinner(rotations, limbs, frames, self.fps, self.settings["tolerance"], stood)

    def keying(self, motion: Motion) -> Generator[None, None, apply.Keys]:
        """What to key for one motion, in slices as :meth:`acting`; changes nothing."""
        motion = pacing.paced(motion, self.settings.get("speed", 1.0))
        if "TORSO" not in self.settings["parts"]:  # with the trunk stay the hips that carry it, and the legs
            motion = replace(motion, pelvis=None)
        planned = self.planned
        if self.mapping is None:  # found once for all takes
            self.mapping = self._mapping()
            yield
            self.trunk = girth.read(self.armature, reading.read(self.armature), self.mapping)
            yield
        if planned.draft:
            self.span = near_playhead(planned.voice.span, motion.duration, self.scene)
        keys = yield from apply.posing(
            self.armature,
            motion,
            self.span.start,
            scene=self.scene,
            mapping=self.mapping,
            options=planned.options,
            step=self.step,
            first=self.span.first,
            last=np.inf if self.span.last is None else self.span.last,
            measured=MEASURED if planned.draft else 1,
            report=self._tell,
            trunk=lambda: self.trunk,
        )
        left_out = self._left_out()
        kept = {bone: values for bone, values in keys.rotations.items() if bone not in left_out}
        legs = {bone: kept[bone] for bone in keys.stood if bone in kept}  # smoothed one by one they would move the feet
        return keys._replace(rotations=pacing.smoothed(kept, self.fps, self.settings.get("smoothing", 0.0)) | legs)

    def _left_out(self) -> set[str]:
        parts = [part for name, parts in _PARTS.items() if name not in self.settings["parts"] for part in parts]
        if len(self.settings["parts"]) == 0:
            raise UsageError("No part of the body is to be keyed.", "Choose parts under Body.")
        names = {bone for part in parts for bone in self.mapping.chains.get(part, ())}
        arms = [self.mapping.chains[part][0] for part in parts if part.endswith("upper_arm") and part in self.mapping.chains]
        # with an arm stay its hand, fingers and twist bones
        return names | {bone.name for arm in arms for bone in self.armature.pose.bones[arm].children_recursive}

    def _mapping(self) -> Mapping:
        state, mapping = self.planned.resolved or (None, None)
        if mapping is not None and state == readiness.state(self.armature):
            return mapping
        return reading.resolve_mapping(self.armature, reading.read(self.armature), self.planned.mapping)

    def _tell(self, warning: str) -> None:
        if warning not in self.told:
            self.told.add(warning)
            self.warn(warning)

    def _place(self, frames: np.ndarray) -> layers.Place:
        kept = self.settings
        first, last = int(frames[0]), int(frames[-1])
        # Keys of a strip are those of a new action; for a draft the one is as good as the other, and quicker.
        result = "ACTION" if self.planned.draft and kept["result"] == "STRIP" else kept["result"]
        room = max((last - first) // 2, 0)
        fades = [min(kept[name], room) for name in ("blend_in", "blend_out")]
        if result == "STRIP":  # poses to continue from and to reach are in the keys
            fades = [fades[0] * (kept["start_pose"] == "REST"), fades[1] * (kept["end_pose"] == "FREE")]
        influence = kept["influence"] if result != "ACTION" else 1.0
        return layers.Place(result, first, last, influence, *fades, self.planned.voice.span.piece)

    def _channels(self, motion: Motion, frames: np.ndarray, rotations, legs, place, base) -> list:
        if place.result == "LAYER":
            rotations = rotations | legs
            # What is the same on all frames is no departure from anything.
            rotations = {bone: values for bone, values in rotations.items() if len(values) == len(frames)}
            near = layers.added_numbers(self.armature, rotations)
            if near:
                self._tell(told("{count} bones turn by angles: far from rest the layer is only near on them.", count=len(near)))
            seen = layers.share(place, frames) if self.planned.draft else None  # a take's strip has it keyed
            return layers.deltas(self.armature, rotations, self._neutral(rotations, motion.hands is not None), seen)
        mixed = self._mixed(frames, rotations, place, base)
        mixed |= mixing.mix(legs, {}, self._standing(frames, place, base))
        return [keyframes.channels(self.armature.pose.bones[bone], values) for bone, values in mixed.items()]

    def _places(self, frames: np.ndarray, places: dict[str, np.ndarray], place, base) -> list:
        """Channels of locations; what has them is moved by nobody else."""
        drafted = place.result == "LAYER" and self.planned.draft
        share = layers.share(place, frames) if drafted else self._standing(frames, place, base)
        pose = self.armature.pose.bones
        return [keyframes.place_channels(pose[bone], share[:, None] * values) for bone, values in places.items()]

    def _standing(self, frames: np.ndarray, place, base) -> np.ndarray:
        """How much of a weight shift (keys,) is seen: poses and animation that are blended in have none."""
        kept, share = self.settings, np.ones(len(frames))
        if place.result == "LAYER":
            return share
        there = place.result == "ACTION" and layers.is_animated(self.armature, base)
        if kept["start_pose"] == "CURRENT" or (there and place.blend_in):
            share = share * mixing.ramp(frames, max(kept["blend_in"], 1))
        if kept["end_pose"] != "FREE" or (there and place.blend_out):
            share = share * mixing.ramp(frames, max(kept["blend_out"], 1), at_end=True)
        return share

    def _neutral(self, rotations, hands: bool) -> dict:
        """Rotations (4,) of the bones when the body stands at ease; for drafts kept while the rig stays as it is.

        Legs, which only some motions turn, rest.
        """
        uid, planned = self.armature.session_uid, self.planned
        rig = readiness.made_of(self.armature), planned.mapping, planned.options
        made_of = (*rig, _dials(self.armature, self.former), hands)
        if not planned.draft or _NEUTRAL.get(uid, (None,))[0] != made_of:
            rest = np.repeat(skeleton.REST[None], 2, 0)
            still = Motion(rest, hands=living.hanging(rest) if hands else None)
            alike = {"scene": self.scene, "mapping": planned.mapping, "options": planned.options}
            found = apply.pose_keys(self.armature, still, 0, **alike, report=lambda warning: None)
            _NEUTRAL[uid] = made_of, {bone: values[0] for bone, values in found.rotations.items()}
        return {bone: _NEUTRAL[uid][1].get(bone, quaternion.IDENTITY) for bone in rotations}

    def _settings(self, settings: dict[str, float], place) -> list:
        """Channels of what lets the rig follow its keys; a layer adds to what is there."""
        if place.result == "LAYER":
            before = self.former if self.planned.draft else {}  # what the draft that plays has set is not there
            present = {path: before.get(path, self.armature.path_resolve(path)) for path in settings}
            settings = {path: value - present[path] for path, value in settings.items() if value != present[path]}
        return keyframes.setting_channels(settings)

    def _mixed(self, frames: np.ndarray, rotations, place, base) -> dict:
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

    def _over(self, frames: np.ndarray, rotations, base, length, at_end) -> dict:
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

    def _there(self, bones, frames: np.ndarray, base) -> dict:
        """What the animation that is there has on these frames, read once for all takes."""
        key = tuple(int(frame) for frame in frames)
        if key not in self.there:
            with layers.below(self.armature, base, self.span):
                self.there[key] = posing.local_rotations(self.armature, list(bones), key, self.scene)
        return self.there[key]

    def _draft(self, place) -> tuple:
        """The draft that the character plays already, with slot and curves, if it has these frames and bones, else nothing."""
        action = layers.draft_of(self.armature)
        if action is None or not place.same(layers.Place.of(action)):
            return None, None, None
        before = provenance.of(action)["settings"]
        handed = [bool(settings.get("hands")) for settings in (before, self.settings)]
        if handed[0] != handed[1] or any(before.get(name) != self.settings[name] for name in _ALIKE):
            return None, None, None
        slot = layers.slot_of(self.armature, action)
        return action, slot, compat.bag(action, slot)

    def _name(self) -> str:
        return f"{self.armature.name} {'draft' if self.planned.draft else 'gesture'}"

    def _provenance(self, motion, place) -> dict:
        planned = self.planned
        origin = {
            **motion.meta,
            **planned.lies,
            "place": place.__dict__,
            "start": self.span.start,
            "settings": self.settings,
            "pose": planned.params.get("pose"),
            "around": planned.params.get("kept"),
            "keyed_pose": {bone: values.round(6).tolist() for bone, values in planned.pose.items()},
        }
        return {**origin, layers.DRAFT: True} if planned.draft else origin


def near_playhead(span, seconds: float, scene: bpy.types.Scene):
    """The frames of a draft of so many ``seconds``: no more of a long recording than what is around the playhead."""
    rate = apply.scene_fps(scene)
    room, end = round(DRAFT * rate), span.start + int(np.ceil(seconds * rate))
    last = end if span.last is None else min(span.last, end)
    first = max(span.first, min(scene.frame_current - room // 2, last - room))
    return replace(span, first=first, last=min(last, first + room))


def _dials(armature: ArmatureObject, former: dict) -> tuple:
    """The numbers that a rig's bones carry for its constraints and drivers, as they are without a draft."""
    found = []
    for bone in armature.pose.bones:
        for key, value in bone.items():
            if isinstance(value, (int, float)):
                path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"]["{bpy.utils.escape_identifier(key)}"]'
                found.append((path, former.get(path, value)))
    return tuple(found)
