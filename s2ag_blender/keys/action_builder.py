"""Builds the actions of one run: keys of its motions, blended with, above or added to the existing animation."""

from collections.abc import Callable, Collection, Generator, Iterable
from dataclasses import replace
from typing import Any

import bpy
import numpy as np

from ...core.errors import S2agError, UsageError
from ...core.motion.motion import Motion
from ...core.motion.skeleton import ARMS
from ...rigs.proportions import SIDES, TrunkShape
from ...rigs.skeleton import Mapping
from .. import compat, provenance
from ..datablocks import ArmatureObject, Bag, Slot
from ..rig import body_shape, readiness, reading
from ..translations import translate
from . import apply, blending, density, faces, key_reduction, keyframes, layers, neutral, pacing, poses

DRAFT_MEASURE_STEP = 10
"""Drafts on control rigs are measured at every such frame of the motion, which has 15 frames per second."""
DRAFT_SECONDS = 15.0
"""Length of a draft around the playhead in seconds."""
_PARTS = {
    "TORSO": ("torso",),
    "HEAD": ("neck", "head"),
    "CLAVICLES": ("left_clavicle", "right_clavicle"),
    "LEFT_ARM": ("left_upper_arm", "left_forearm"),
    "RIGHT_ARM": ("right_upper_arm", "right_forearm"),
}
_SAME_KEYS = "result", "parts", "bone_map"
"""Drafts with equal values of these settings key the same bones, if both or neither animate hands."""
Rotations = dict[str, np.ndarray]
_Base = bpy.types.Action | None


class ActionBuilder:
    """Builds the takes of a run, sharing the animation below, the poses to start from and to reach, and the rig."""

    def __init__(self, planned: Any, armature: ArmatureObject, scene: bpy.types.Scene, warn: Callable[[str], None]) -> None:
        """Prepare for a plan (``takes.generate.Plan``); ``warn`` is called once with each warning."""
        self.planned, self.armature, self.scene, self.warn = planned, armature, scene, warn
        self.settings, self.span = planned.settings, planned.voice.span
        self.told: set[str] = set()
        self.there: dict[tuple[int, ...], Rotations] = {}
        self.mapping: Mapping | None = None
        self.trunk: TrunkShape | None = None
        self.former = layers.former_values_of_playing(armature)

    def acting(self, motion: Motion, keys: apply.Keys, made: list[int]) -> Generator[None, None, bpy.types.Action]:
        """Build a new action with the ``keys`` of one motion, stamped with its provenance, in slices.

        A draft reuses its own action. The session_uid of a new action is added to ``made`` at once. Between slices anything
        may happen to Blender's data: the caller must set ``armature`` and ``scene`` again before resuming."""
        frames, rotations, settings, places, stood, _ = keys
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
        copied = base if place.result == "ACTION" else None
        present = compat.curves(copied, layers.slot_of(self.armature, copied)) if copied is not None else ()
        cut = {(curve.data_path, curve.array_index) for curve in present}
        target = self._draft(place) if self.planned.draft else None
        if target is None and copied is not None:
            target = compat.copy_action(copied, layers.slot_of(self.armature, copied), self._name())
        action, slot, bag = target or compat.new_action(self._name(), self.armature)
        made += [action.session_uid] if action != layers.draft_of(self.armature) else []
        if copied is None:
            keyframes.set_range(action, frames)
        provenance.stamp(action, self._provenance(motion, place))
        layers.store_base(action, slot, base)
        keyframes.store_former_values(action, self.armature, {one.path for one in keyed + spoken}, self.former)
        density.store_keyed_paths(action, keyed, stood)
        uid = action.session_uid
        for first in range(0, len(keyed), keyframes.BONES_PER_SLICE):
            some = keyed[first : first + keyframes.BONES_PER_SLICE]
            keyframes.write_channels(bag, some, frames, interpolation, thinner, cut)
            yield
            action, bag = self._again(uid)
        if motion.face is not None:
            keyframes.write_channels(bag, spoken, every, "LINEAR", None, cut)
            yield
            action, bag = self._again(uid)
            rate, seen = apply.scene_fps(self.scene), self._face_seen(every, place)
            faces.key_face(self.armature, action, motion.face, self.span.start, every, rate, self._tell, seen)
        return action

    def _spoken(self, motion: Motion, frames: np.ndarray, place: layers.Place) -> tuple[list[keyframes.Channels], np.ndarray]:
        """Return the channels of facial bones, which have a key on every frame, and these frames."""
        every = np.arange(frames[0], frames[-1] + 1)
        if motion.face is None:
            return [], every
        rate, strip = apply.scene_fps(self.scene), place.result != "ACTION" and not self.planned.draft
        seen = faces.end_fade(every, rate) if strip else self._face_seen(every, place)  # a strip has its own influence
        return faces.bone_channels(self.armature, motion.face, self.span.start, every, rate, self._body(), seen), every

    def _face_seen(self, every: np.ndarray, place: layers.Place) -> np.ndarray | None:
        """Return the weight (n,) of a face: the layer's influence, fading at the end; None (all) for a piece within a take."""
        if place.piece:
            return None
        return layers.influence_over_frames(place, every) * faces.end_fade(every, apply.scene_fps(self.scene))

    def _again(self, uid: int) -> tuple[bpy.types.Action, Bag]:
        """Return the action with this session_uid and its bag. Raises :class:`S2agError` if it is gone."""
        action = next((one for one in bpy.data.actions if one.session_uid == uid), None)
        if action is None:
            raise S2agError("Gestures were undone while they came.", "Nothing was changed.")
        return action, compat.bag(action, layers.slot_of(self.armature, action))

    @property
    def few(self) -> bool:
        """Return whether to reduce keys; a draft keeps all, which is quicker."""
        return self.settings.get("curves") == "POSES" and not self.planned.draft

    @property
    def step(self) -> int:
        """Return the frames between keys before reduction."""
        return 1 if self.settings.get("curves") == "POSES" else self.settings["key_step"]

    @property
    def fps(self) -> float:
        """Return the keys per second before reduction."""
        return apply.scene_fps(self.scene) / self.step

    def _body(self) -> Mapping:
        """Return the mapping, which :meth:`keying` has resolved."""
        assert self.mapping is not None
        return self.mapping

    def _thinner(self, frames: np.ndarray, rotations: Rotations, stood: Collection[str]) -> key_reduction.KeyReducer | None:
        if not self.few:
            return None
        limbs = density.limbs(reading.read(self.armature), self._body())
        return key_reduction.KeyReducer(rotations, limbs, frames, self.fps, self.settings["tolerance"], stood)

    def keying(self, motion: Motion) -> Generator[None, None, apply.Keys]:
        """Compute the keys for one motion, in slices like :meth:`vocal_delivery`; changes nothing."""
        motion = pacing.change_speed(motion, self.settings.get("speed", 1.0))
        if "TORSO" not in self.settings["parts"]:  # hips and legs belong to the trunk
            motion = replace(motion, pelvis=None)
        planned = self.planned
        if self.mapping is None:  # resolved once for all takes
            self.mapping = self._mapping()
            yield
            self.trunk = body_shape.read_trunk(self.armature, reading.read(self.armature), self.mapping)
            yield
        if planned.draft:
            self.span = near_playhead(planned.voice.span, motion.duration, self.scene)
        left_out = self._left_out()
        keys = yield from apply.solve_keys_in_slices(
            self.armature,
            self._with_still_arms(motion, self.mapping),
            self.span.start,
            scene=self.scene,
            mapping=replace(self.mapping, held=self.mapping.held | left_out),
            options=planned.options,
            step=self.step,
            first=self.span.first,
            last=np.inf if self.span.last is None else self.span.last,
            measured=DRAFT_MEASURE_STEP if planned.draft else 1,
            report=self._tell,
            trunk=lambda: self.trunk,
        )
        kept = {bone: values for bone, values in keys.rotations.items() if bone not in left_out}
        legs = {bone: kept[bone] for bone in keys.stood if bone in kept}  # smoothing each bone would move the feet
        return keys._replace(rotations=pacing.smooth_rotations(kept, self.fps, self.settings.get("smoothing", 0.0)) | legs)

    def _with_still_arms(self, motion: Motion, mapping: Mapping) -> Motion:
        """Return the motion with arms that get no keys as they are posed now, so that the other one keeps clear of them."""
        edges = [edge for side, arm in zip(SIDES, ARMS, strict=True) if f"{side.upper()}_ARM" not in self.settings["parts"]
                 for edge in arm]  # fmt: skip
        if not edges:
            return motion
        directions = motion.directions.copy()
        bones = reading.read(self.armature)
        directions[:, edges] = poses.directions(self.armature, bones, mapping, self.planned.options)[edges]
        hands = motion.hands and motion.hands.moved_with_arms(motion.directions, directions)
        return replace(motion, directions=directions, hands=hands)

    def _left_out(self) -> set[str]:
        """Return the bones of the parts that are not to be keyed, with all descendants of their arms."""
        parts = [part for name, parts in _PARTS.items() if name not in self.settings["parts"] for part in parts]
        if len(self.settings["parts"]) == 0:
            raise UsageError("No part of the body is to be keyed.", "Choose parts under Body.")
        chains = self._body().chains
        names = {bone for part in parts for bone in chains.get(part, ())}
        arms = [chains[part][0] for part in parts if part.endswith("upper_arm") and part in chains]
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
        """Return the place of a take with keys at these frames; blending takes at most half of them each."""
        kept = self.settings
        first, last = int(frames[0]), int(frames[-1])
        # A strip has the keys of a new action; a draft is previewed as an action, which is quicker.
        result = "ACTION" if self.planned.draft and kept["result"] == "STRIP" else kept["result"]
        room = max((last - first) // 2, 0)
        blend_in, blend_out = min(kept["blend_in"], room), min(kept["blend_out"], room)
        if result == "STRIP":  # the keys themselves blend with the start and end poses
            blend_in, blend_out = blend_in * (kept["start_pose"] == "REST"), blend_out * (kept["end_pose"] == "FREE")
        influence = kept["influence"] if result != "ACTION" else 1.0
        return layers.Place(result, first, last, influence, blend_in, blend_out, self.planned.voice.span.piece)

    def _channels(
        self, motion: Motion, frames: np.ndarray, rotations: Rotations, legs: Rotations, place: layers.Place, base: _Base
    ) -> list[keyframes.Channels]:
        """Return the channels of all rotations: differences for a layer, else blended with poses and animation."""
        if place.result == "LAYER":
            rotations = rotations | legs
            # Constant rotations are no difference.
            rotations = {bone: values for bone, values in rotations.items() if len(values) == len(frames)}
            near = [name for name in rotations if self.armature.pose.bones[name].rotation_mode != "QUATERNION"]
            if near:
                told = translate("{count} bones turn by angles: far from rest the layer is only near on them.", count=len(near))
                self._tell(told)
            seen = (
                layers.influence_over_frames(place, frames) if self.planned.draft else None
            )  # a take's strip has a keyed influence
            hands = motion.hands is not None
            rest = neutral.rotations(self.armature, self.scene, self.planned, list(rotations), hands, self.former)
            return layers.layer_channels(self.armature, rotations, rest, seen)
        mixed = self._mixed(frames, rotations, place, base)
        mixed |= blending.mix(legs, {}, self._standing(frames, place, base))
        return [keyframes.channels(self.armature.pose.bones[bone], values) for bone, values in mixed.items()]

    def _places(self, frames: np.ndarray, places: Rotations, place: layers.Place, base: _Base) -> list[keyframes.Channels]:
        """Return the channels of locations ``{bone: (frames, 3)}``; nothing else moves these bones."""
        drafted = place.result == "LAYER" and self.planned.draft
        share = layers.influence_over_frames(place, frames) if drafted else self._standing(frames, place, base)
        pose = self.armature.pose.bones
        return [keyframes.place_channels(pose[bone], share[:, None] * values) for bone, values in places.items()]

    def _standing(self, frames: np.ndarray, place: layers.Place, base: _Base) -> np.ndarray:
        """Return the weight (keys,) of a weight shift; blending with poses and animation fades it to 0."""
        kept, share = self.settings, np.ones(len(frames))
        if place.result == "LAYER":
            return share
        animated = place.result == "ACTION" and layers.is_animated(self.armature, base)
        if kept["start_pose"] == "CURRENT" or (animated and place.blend_in):
            share = share * blending.ramp(frames, max(kept["blend_in"], 1))
        if kept["end_pose"] != "FREE" or (animated and place.blend_out):
            share = share * blending.ramp(frames, max(kept["blend_out"], 1), at_end=True)
        return share

    def _settings(self, settings: dict[str, float], place: layers.Place) -> list[keyframes.Channels]:
        """Return the channels of the properties that make the rig follow its keys; differences for a layer."""
        if place.result == "LAYER":
            before = self.former if self.planned.draft else {}  # values before the draft that plays now
            present = {path: before.get(path, self.armature.path_resolve(path)) for path in settings}
            settings = {path: value - present[path] for path, value in settings.items() if value != present[path]}
        return keyframes.setting_channels(settings)

    def _mixed(self, frames: np.ndarray, rotations: Rotations, place: layers.Place, base: _Base) -> Rotations:
        """Blend rotations with the start and end poses, and in a new action with the existing animation."""
        kept = self.settings
        animated = place.result == "ACTION" and layers.is_animated(self.armature, base)
        if kept["start_pose"] == "CURRENT":
            share = blending.ramp(frames, max(kept["blend_in"], 1))
            rotations = blending.mix(rotations, self.planned.pose, share)
        elif animated and place.blend_in:
            rotations = self._over(frames, rotations, base, place.blend_in, at_end=False)
        if kept["end_pose"] != "FREE":
            pose = self.planned.pose
            if kept["end_pose"] == "THERE":
                pose = {bone: values[0] for bone, values in self._there(rotations, frames[-1:], base).items()}
            rotations = blending.mix(rotations, pose, blending.ramp(frames, max(kept["blend_out"], 1), at_end=True))
        elif animated and place.blend_out:
            rotations = self._over(frames, rotations, base, place.blend_out, at_end=True)
        return rotations

    def _over(self, frames: np.ndarray, rotations: Rotations, base: _Base, length: int, at_end: bool) -> Rotations:
        """Blend rotations with the existing animation over ``length`` frames at the start or end."""
        share = blending.ramp(frames, length, at_end)
        few = share < 1
        below = self._there(rotations, frames[few], base)
        mixed = {}
        for bone, values in rotations.items():
            mixed[bone] = np.array(np.broadcast_to(values, (len(frames), 4)))
        part = blending.mix({bone: values[few] for bone, values in mixed.items()}, below, share[few])
        for bone, values in part.items():
            mixed[bone][few] = values
        return mixed

    def _there(self, bones: Iterable[str], frames: np.ndarray, base: _Base) -> Rotations:
        """Return the rotations of the existing animation at these frames, read once for all takes."""
        key = tuple(int(frame) for frame in frames)
        if key not in self.there:
            with layers.animation_below(self.armature, base, self.span):
                self.there[key] = poses.local_rotations(self.armature, list(bones), key, self.scene)
        return self.there[key]

    def _draft(self, place: layers.Place) -> tuple[bpy.types.Action, Slot | None, Bag] | None:
        """Return the draft that the character plays, with slot and bag, if it has these frames and bones, else None."""
        action = layers.draft_of(self.armature)
        meta = provenance.read(action)
        if action is None or meta is None or not place.same(layers.Place.of(action)):
            return None
        before = meta["settings"]
        hands = [bool(settings.get("hands")) for settings in (before, self.settings)]
        if hands[0] != hands[1] or any(before.get(name) != self.settings[name] for name in _SAME_KEYS):
            return None
        slot = layers.slot_of(self.armature, action)
        return action, slot, compat.bag(action, slot)

    def _name(self) -> str:
        return f"{self.armature.name} {'draft' if self.planned.draft else 'gesture'}"

    def _provenance(self, motion: Motion, place: layers.Place) -> dict[str, Any]:
        planned = self.planned
        origin = {
            **motion.meta,
            **planned.lies,
            "place": place.__dict__,
            "start": self.span.start,
            "settings": self.settings,
            "pose": planned.started,
            "around": planned.around,
            "keyed_pose": {bone: values.round(6).tolist() for bone, values in planned.pose.items()},
        }
        return {**origin, layers.DRAFT: True} if planned.draft else origin


def near_playhead(span: Any, seconds: float, scene: bpy.types.Scene) -> Any:
    """Limit a ``takes.sources.Span`` of a recording of ``seconds`` to :data:`DRAFT_SECONDS` around the playhead."""
    rate = apply.scene_fps(scene)
    room, end = round(DRAFT_SECONDS * rate), span.start + int(np.ceil(seconds * rate))
    last = end if span.last is None else min(span.last, end)
    first = max(span.first, min(scene.frame_current - room // 2, last - room))
    return replace(span, first=first, last=min(last, first + room))
