"""From a character's settings to gestures on it, in three steps: plan, let the engine work, finish.

:func:`plan` reads everything from Blender, :func:`finish` writes everything; between them no Blender data is held, so undo,
renaming and loading another file cannot hurt. Scripts and ``-b`` use :func:`wait`, which does all three.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...core.declaration import KINDS
from ...core.errors import AudioUnreadable, S2agError
from ...core.motion.motion import Motion
from ...core.settings import CONTROLS, Settings, named, table
from ...rigs.goals import Options
from ...rigs.plain import PARTS as BODY_PARTS
from ...rigs.plain import Mapping
from ...rigs.slices import whole
from .. import compat, provenance, stored
from ..datablocks import ArmatureObject, Context
from ..keys import layers, posing, trying
from ..keys.laying import Laying
from ..rig import handpicked, readiness, reading
from ..translations import told
from . import (
    choices,
    company,
    directing,
    drafts,
    feelings,
    gesture,
    keeping,
    markers,
    recall,
    retiming,
    sources,
    surroundings,
    takes,
    timing,
    versions,
    voices,
)

_FELT, _OTHERS = "over_time", "others"
"""Names of what goes on in time, and of whom it talks with, among the settings of a take."""
_COMPANY = {name: KINDS[table(Settings)[name].kind] for name in named(partner=True)}


@dataclass(frozen=True)
class Handle:
    """A datablock to find again: by what it is in this session, else by its name."""

    uid: int
    name: str

    @classmethod
    def of(cls, datablock: bpy.types.ID) -> "Handle":
        return cls(datablock.session_uid, datablock.name)

    def find(self, collection: bpy.types.Collection):
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
    resolved: tuple[tuple, Mapping] | None = None
    """What the rig was made of (:func:`readiness.state`) as its mapping was worked out, and that."""
    options: Options = field(default_factory=Options)
    pose: dict[str, np.ndarray] = field(default_factory=dict)
    draft: bool = False
    warnings: tuple[str, ...] = ()
    former: Handle | None = None
    """The action of a take that is directed: what is made is its next version."""
    pins: tuple[dict, ...] = ()
    """What that keeps besides (:mod:`keeping`)."""
    grown: bool = False
    """Whether more of the recording is seen than the former version had."""
    follows: bool = False
    """Whether nothing is made: the selected take follows its sound, which is this recording now (:mod:`retiming`)."""

    @property
    def lies(self) -> dict:
        """What provenance tells of a take that does not lie on the timeline as its recording is."""
        voice = self.voice
        known = {timing.WAY: timing.stated(voice.way), retiming.FOLLOWS: retiming.performed_for(voice.path)}
        return known if voice.followed or voice.way is not None else {}


@dataclass(frozen=True)
class Outcome:
    """What :func:`finish` made: actions, one a take, seconds of speech, and warnings and other news for the user."""

    actions: list
    seconds: float
    warnings: list[str]
    notes: list[str] = field(default_factory=list)


def plan(
    context: Context,
    armature: ArmatureObject,
    draft: bool = False,
    kept: dict | None = None,
    keyed_pose: dict[str, list] | None = None,
    around: list | None = None,
    former: bpy.types.Action | None = None,
    pins: list | None = None,
    like: bpy.types.Action | None = None,
    span: tuple[int, int] | None = None,
    **changes,
) -> Plan:
    """Read a character's settings and pose; ``changes`` go to the engine as they are (``styles``, ``near`` and so on).

    ``kept`` are settings of an earlier take (:func:`recall.snapshot`) to use instead of those that are set,
    ``keyed_pose`` the pose ``{bone: (4,)}`` that it grew out of, and ``around`` the poses before and after it
    (:func:`surroundings.poses`). With ``former`` it becomes the next version of the take that plays this action, and keeps
    ``pins`` of it. Where the take of ``like`` followed its sound, it lies as that does, or on the frames of ``span``.

    Raises :class:`S2agError` for all that the user must mend first.
    """
    reading.require_armature(armature)
    trying.end(armature)
    settings, scene = recall.view(kept) if kept else armature.s2ag, context.scene
    if former is not None:
        retiming.check_recording(former)
    voice = (retiming.voice(like, scene, span) if like is not None else None) or sources.voice(settings, scene)
    if not kept and not keyed_pose:
        keyed_pose, changes = _posed_before(armature, settings, changes)
    felt, unknown = _felt(armature, scene, voice.span, kept)
    params = {**gesture.request(settings, voice.path), **felt, **({"takes": 1} if draft else {}), **changes}
    params = {name: value for name, value in params.items() if value is not None}
    warnings = _without_controls(params, settings) + unknown
    mapping = handpicked.chosen(settings)
    bones = reading.read(armature)
    resolved = (readiness.mapping(armature) if draft else None) or reading.resolve_mapping(armature, bones, mapping)
    others = _others(kept, lambda: company.asked(armature, scene, voice, settings, (bones, resolved)))
    params = {**params, **others}
    pose = {bone: np.array(values) for bone, values in (keyed_pose or {}).items()}
    layered = settings.result == "LAYER"  # what is below it has the poses already
    if not pose and not layered and "CURRENT" in (settings.start_pose, settings.end_pose):
        pose = posing.current_rotations(armature, [name for part in BODY_PARTS for name in resolved.chains.get(part, ())])
    if settings.start_pose == "CURRENT" and not layered and "pose" not in params:
        params["pose"] = posing.directions(armature, bones, resolved, recall.options(settings)).tolist()
    if not kept:
        around = surroundings.poses(armature, scene, voice.span, settings, (bones, resolved, recall.options(settings)))
    if around:
        params["kept"] = around
    return Plan(
        Handle.of(armature),
        Handle.of(scene),
        params,
        voice,
        kept or {**recall.snapshot(settings), _FELT: felt, _OTHERS: others},
        resolved if draft else mapping,
        None if draft else (readiness.state(armature), resolved),
        recall.options(settings),
        pose,
        draft,
        warnings,
        Handle.of(former) if former is not None else None,
        tuple(pins or ()),
        span is not None,
    )


def following(context: Context, armature: ArmatureObject) -> Plan:
    """What lets the selected take follow its sound where that says the words anew, or shows more of them than was made."""
    action, scene = takes.active(armature).action, context.scene
    what, strip = retiming.change(action, scene), retiming.strip_of(action, scene)
    if not what.replaced:
        span = round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
        return plan(context, armature, **directing.directed(action, directing.made(action)), span=span)
    path, again = sources.strip_file(strip), takes.again(action, like=None)
    again["kept"] = {**again["kept"], "audio_source": "FILE", "audio": path, "range": "OWN"}
    planned = plan(context, armature, **again)
    replaced = {*named(words=True), "kept", "curves", "changes"}
    params = {name: value for name, value in planned.params.items() if name not in replaced}
    beside, spoken = sources.beside(path), " ".join(word for word, *_ in directing.words(action))
    said = {"transcript": beside} if beside else {"text": spoken}
    said = {"recognise": True} if "recognise" in planned.params else said
    return replace(planned, params={**params, **said, "audio": path}, follows=True)


def _others(kept: dict | None, look) -> dict:
    """The engine's parameters of whom a character talks with, as it is now or was for the take of these ``kept`` settings."""
    if not kept:
        return look()
    known = kept.get(_OTHERS)
    known = {name: known[name] for name in _COMPANY if name in known} if isinstance(known, dict) else {}
    return known if stored.fits(known, _COMPANY) else {}


def _felt(armature: ArmatureObject, scene: bpy.types.Scene, span, kept: dict | None) -> tuple[dict, tuple[str, ...]]:
    """The engine's parameters of what goes on in time, as it is keyed now or was for the take of these ``kept`` settings; and
    warnings.
    """
    if kept:
        told_of = kept.get(_FELT)
        return {name: told_of[name] for name in ("curves", "changes") if name in told_of} if isinstance(
            told_of, dict
        ) else {}, ()
    changes, unknown = feelings.begun(armature, scene, span)
    found = {"curves": feelings.sampled(armature, scene, span), "changes": changes}
    return {name: value for name, value in found.items() if value}, unknown


def _posed_before(armature: ArmatureObject, settings: Any, changes: dict) -> tuple[dict | None, dict]:
    """``keyed_pose`` and ``changes`` with the pose that the draft which plays grew out of: its own pose is nobody's start.

    A draft that does not know it goes, so that the pose below it can be read.
    """
    shown = layers.draft_of(armature)
    if shown is None or "CURRENT" not in (settings.start_pose, settings.end_pose):
        return None, changes
    told = provenance.of(shown)
    if any(told["settings"][name] != getattr(settings, name) for name in ("start_pose", "end_pose", "result")):
        drafts.drop(armature)
        bpy.context.view_layer.update()
        return None, changes
    return told["keyed_pose"], ({"pose": told["pose"]} if told["pose"] else {}) | changes


def _without_controls(params: dict, settings: Any) -> tuple[str, ...]:
    """Take sliders that the checkpoint does not know from the engine's parameters; tells if any was set."""
    if choices.control_names(settings.checkpoint):
        return ()
    removed = [params.pop(name, 0) for name in named(control=True)]
    rest = {name: points for name, points in params.pop("curves", {}).items() if name not in CONTROLS}
    params |= {"curves": rest} if rest else {}
    if not any(any(value.values()) if isinstance(value, dict) else value for value in removed):
        return ()
    return (told("This gesture model has intensity only: the other sliders were left out."),)


def wait(context: Context, planned: Plan, progress=None) -> Outcome:
    """Let the engine work and finish: the way without a window. ``progress(stage, value)`` hears of it."""
    return finish(planned, gesture.call(context, planned.params, progress))


def finish(planned: Plan, result: dict) -> Outcome:
    """Lay the engine's motions onto the character; nothing is left behind if that fails.

    Raises :class:`S2agError`, also where the character or the scene is gone.
    """
    return whole(finishing(planned, result))


def finishing(planned: Plan, result: dict):
    """:func:`finish` in slices: yields how much is done (0..1) as often as Blender may draw, and returns the outcome.

    Blender's data is found anew for every slice, for meanwhile anything may happen to it. A draft is a single slice.
    """
    warnings = [*planned.warnings, *result.get("warnings", ())]
    motions, laying, made = [], None, []
    for motion in result["motions"]:  # a path, or loaded already
        motions.append(motion if isinstance(motion, Motion) else Motion.load(motion))
        yield 0.0
    if planned.follows:
        what = retiming.follow(*_whom(planned), motions[0])
        return Outcome([], motions[0].duration, warnings, [retiming.warned(what)])
    try:
        for number, performed in enumerate(motions):
            motion = timing.played(performed, planned.voice.way)
            armature, scene = _whom(planned)
            if laying is None:
                if not planned.draft or (drafts.is_staged(armature) and planned.settings["result"] != "LAYER"):
                    drafts.drop(armature)
                laying = Laying(planned, armature, scene, warnings.append)
            if planned.draft:
                action = whole(laying.acting(motion, whole(laying.keying(motion)), made))
                drafts.show(armature, action)
                return Outcome([action], motion.duration, warnings)
            keys = yield from _sliced(planned, laying, laying.keying(motion), number / len(motions))
            yield from _sliced(planned, laying, laying.acting(motion, keys, made), (number + 0.5) / len(motions))
        return (yield from _finished(planned, made, motions, warnings))
    except BaseException:
        for action in [action for action in bpy.data.actions if action.session_uid in made]:
            bpy.data.actions.remove(action)
        raise


def _sliced(planned: Plan, laying: Laying, slices, done: float):
    """What ``slices`` of a take return; each begins with the character as it is by then."""
    while True:
        laying.armature, laying.scene = _whom(planned)
        try:
            next(slices)
        except StopIteration as end:
            yield done
            return end.value
        yield done


def _whom(planned: Plan) -> tuple:
    """Character and scene of a plan as they are now."""
    armature = planned.armature.find(bpy.data.objects)
    if armature is None:
        raise S2agError(f"The character {planned.armature.name} is gone.", "Nothing was changed.")
    reading.require_armature(armature)
    return armature, planned.scene.find(bpy.data.scenes) or bpy.context.scene


def _still(made: list[int]) -> list:
    """The actions of a run by their numbers in this session."""
    there = {action.session_uid: action for action in bpy.data.actions}
    if not there.keys() >= set(made):
        raise S2agError("Gestures were undone while they came.", "Nothing was changed.")
    return [there[uid] for uid in made]


def _finished(planned, made: list[int], motions: list[Motion], warnings):
    """The outcome, in slices as :func:`finishing`; what is seen of it comes in the last."""
    for number, performed in enumerate(motions):
        directing.note(_still(made)[number], performed, _whom(planned)[1])
        yield 1.0
    armature, scene = _whom(planned)
    actions, motion = _still(made), motions[0]
    own = _accompany(planned, scene, timing.played(motion, planned.voice.way), warnings)
    for action in actions:
        action[voices.TAG] = own
        if planned.settings["result"] == "ACTION":
            feelings.carry(armature, action, compat.bag(action, layers.slot_of(armature, action)))
    warnings = list(dict.fromkeys(warnings))
    former = planned.former.find(bpy.data.actions) if planned.former else None
    if former is not None:
        directing.settle(former, actions[0], scene)
        keeping.carry(former, actions[0], scene, list(planned.pins))
    for action in actions:
        if former is None or planned.grown:
            retiming.note(action, scene)
        else:
            retiming.carry(former, action)
    silent = voices.hear(armature, actions[0])
    if former is None or not versions.put(armature, former, actions[0], warnings):
        takes.add(armature, actions, planned.voice.name, warnings)
    news = [keeping.reach(armature, actions[0], scene, pin) for pin in planned.pins if "object" in pin]
    if any(news):
        takes.active(armature).warnings = "\n".join([*warnings, *filter(None, news)])
    notes = [told("The sound of an earlier take is silent now: {name}", name=name) for name in silent]
    return Outcome(actions, motion.duration, warnings, notes)


def _accompany(planned: Plan, scene: bpy.types.Scene, motion: Motion, warnings: list[str]) -> str:
    """The sound strip and the word markers, where they are wanted; returns the strip's tag."""
    span, kept, voice = planned.voice.span, planned.settings, planned.voice
    own = voice.tag
    if voice.placed:
        scene.sync_mode = "AUDIO_SYNC"
    else:
        name = f"{planned.armature.name} – {Path(voice.path).stem}"
        try:
            own, news = voices.lay(scene, voice.path, round(span.start), name, kept["add_sound"])
            warnings.extend(news)
        except AudioUnreadable as error:  # the engine reads more formats than Blender's sound system
            warnings.append(f"The gestures are there, the sound strip is not: {error}")
    if kept["add_markers"]:
        if motion.words:
            markers.add(scene, motion.words, span.start, kept["marker_prefix"], span.first, span.last)
        else:
            warnings.append("There are no word markers, because the words are not known.")
    return own
