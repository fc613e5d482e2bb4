"""Generates gestures for a character in three steps: plan, run the engine, finish.

:func:`plan` reads everything from Blender, :func:`finish` writes everything; between them no Blender data is referenced, so
undo, renaming and opening another file are safe. Scripts and background mode use :func:`wait`, which does all three."""

from collections.abc import Callable, Generator
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...core.editing.time_alignment import unsaid_edits
from ...core.errors import S2agError
from ...core.motion.motion import Motion
from ...core.settings import names_with
from ...rigs.skeleton import PARTS as BODY_PARTS
from ...rigs.slices import run_to_end
from .. import compat, provenance
from ..datablocks import ArmatureObject, Context, current_context
from ..keys import apply, layers, poses, test_pose
from ..keys.action_builder import ActionBuilder
from ..rig import chosen_bones, readiness, reading
from ..translations import translate
from . import (
    constraints,
    context_poses,
    control_curves,
    conversation,
    decisions,
    drafts,
    engine_requests,
    gesture_edits,
    markers,
    menu_items,
    plan_parameters,
    retiming,
    sound_strips,
    sources,
    stored_settings,
    take_list,
    timing,
    versions,
)
from .plans import Handle, Outcome, Plan


def plan(
    context: Context, armature: ArmatureObject, draft: bool = False, kept: dict | None = None,
    keyed_pose: dict[str, list] | None = None, around: list | None = None, former: bpy.types.Action | None = None,
    pins: list | None = None, like: bpy.types.Action | None = None, span: tuple[int, int] | None = None,
    count: int | None = None, **changes: Any
) -> Plan:  # fmt: skip
    """Read a character's settings and pose; ``changes`` are passed to the engine (``styles``, ``near`` and so on).

    ``kept`` are settings of an earlier take (:func:`stored_settings.snapshot`) to use instead of the current ones,
    ``keyed_pose`` is the pose ``{bone: (4,)}`` that it started from, and ``around`` are the poses before and after it
    (:func:`context_poses.poses_around`). With ``former`` the result becomes the next version of the take that plays this
    action, and keeps its constraints ``pins``. If the take of ``like`` followed its sound, the result has its timing, or the
    frames ``span``. The engine is asked for ``count`` takes, by default one if it is told which, else as many as are set.

    Raises :class:`S2agError` for everything that the user must fix first."""
    reading.require_armature(armature)
    apply.require_rate(context.scene)
    test_pose.end_test_pose(armature)
    settings, scene = stored_settings.settings_view(kept) if kept else armature.s2ag, context.scene
    if former is not None:
        retiming.check_recording(former)
    voice = (retiming.voice(like, scene, span) if like is not None else None) or sources.find_voice(settings, scene)
    if not kept and not keyed_pose:
        keyed_pose, changes = _pose_of_draft(armature, settings, changes)
    felt, unknown = plan_parameters.of_curves(armature, scene, voice.span, kept)
    count = 1 if count is None and (draft or kept or "styles" in changes) else count
    params = {**engine_requests.request(settings, voice.path), **felt, **({"takes": count} if count else {}), **changes}
    params = {name: value for name, value in params.items() if value is not None}
    warnings = plan_parameters.drop_unknown_controls(params, settings) + unknown
    mapping = chosen_bones.mapping_of_settings(settings)
    bones = reading.read(armature)
    resolved = (readiness.mapping(armature) if draft else None) or reading.resolve_mapping(armature, bones, mapping)
    others = plan_parameters.of_partner(
        kept, lambda: conversation.conversation_parameters(armature, scene, voice, settings, (bones, resolved))
    )
    busy, held = plan_parameters.of_busy_hands(armature, resolved, settings.parts) if not kept else ({}, ())
    params = {**params, **others, **{name: value for name, value in busy.items() if name in params}}
    pose = {bone: np.array(values) for bone, values in (keyed_pose or {}).items()}
    layered = settings.result == "LAYER"  # the animation below has the poses already
    if not pose and not layered and "CURRENT" in (settings.start_pose, settings.end_pose):
        pose = poses.current_rotations(armature, [name for part in BODY_PARTS for name in resolved.chains.get(part, ())])
    if settings.start_pose == "CURRENT" and not layered and "pose" not in params:
        params["pose"] = poses.directions(armature, bones, resolved, stored_settings.options(settings)).tolist()
    if not kept:
        around = context_poses.poses_around(
            armature, scene, voice.span, settings, (bones, resolved, stored_settings.options(settings))
        )
    if around:
        params["kept"] = around
    return Plan(
        Handle.of(armature),
        Handle.of(scene),
        params,
        voice,
        kept or {**stored_settings.snapshot(settings), plan_parameters.TIMED: felt, plan_parameters.PARTNER: others, **busy},
        resolved if draft else mapping,
        None if draft else (readiness.state(armature), resolved),
        stored_settings.options(settings),
        pose,
        draft,
        warnings + held,
        apply.scene_fps(scene),
        frozenset(armature.pose.bones.keys()),
        Handle.of(former) if former is not None else None,
        tuple(pins or ()),
        span is not None,
        started=params.get("pose"),
        around=around,
        count=len(params.get("styles") or "1") * params["takes"],
    )


def plan_directed(context: Context, armature: ArmatureObject) -> Plan:
    """Return the plan of a new take that keeps the decisions about the selected one, where they still apply."""
    former, why_not = decisions.carried(armature, armature.s2ag)
    if former is None:
        planned = plan(context, armature)
        return replace(planned, warnings=(*planned.warnings, why_not)) if why_not else planned
    edits = gesture_edits.edits_of(former)
    planned = plan(context, armature, edits=edits, forgiven=len(edits))
    return replace(planned, carried=Handle.of(former))


def follow_arguments(context: Context, armature: ArmatureObject) -> Plan:
    """Return the plan that makes the selected take follow a strip that plays another recording, or more of its own."""
    action, scene = take_list.active(armature).action, context.scene
    what, strip = retiming.change(action, scene), retiming.strip_of_take(action, scene)
    assert what is not None and strip is not None
    if not what.replaced:
        span = round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
        return plan(context, armature, **gesture_edits.plan_arguments(action, gesture_edits.edits_of(action)), span=span)
    path, again = sources.strip_file(strip), take_list.remake_arguments(action, like=None)
    again["kept"] = {**again["kept"], "audio_source": "FILE", "audio": path, "range": "OWN"}
    planned = plan(context, armature, **again)
    replaced = {*names_with(words=True), *names_with(timed=True)}
    params = {name: value for name, value in planned.params.items() if name not in replaced}
    spoken = " ".join(word for word, *_ in gesture_edits.stored_words(action))
    words = sources.words_again(planned.params, path, spoken)
    return replace(planned, params={**params, **words, "audio": path}, follows=True)


def _pose_of_draft(
    armature: ArmatureObject, settings: Any, changes: dict[str, Any]
) -> tuple[dict[str, Any] | None, dict[str, Any]]:
    """Return ``keyed_pose`` and ``changes`` with the pose from which the playing draft started, not the draft's own pose.

    A draft without a matching pose is removed, so that the pose below it can be read."""
    shown = layers.draft_of(armature)
    if shown is None or "CURRENT" not in (settings.start_pose, settings.end_pose):
        return None, changes
    meta = provenance.require(shown)
    if any(meta["settings"][name] != getattr(settings, name) for name in ("start_pose", "end_pose", "result")):
        drafts.drop(armature)
        current_context().view_layer.update()
        return None, changes
    return meta["keyed_pose"], ({"pose": meta["pose"]} if meta["pose"] else {}) | changes


def wait(context: Context, planned: Plan, progress: Callable[[str, float], None] | None = None) -> Outcome:
    """Run the engine and finish, without returning in between; ``progress(stage, value)`` is called meanwhile."""
    return finish(planned, engine_requests.call(context, planned.params, progress))


def finish(planned: Plan, result: dict[str, Any]) -> Outcome:
    """Key the engine's motions on the character; if that fails, nothing is left behind.

    Raises :class:`S2agError`, also if the character or the scene is gone."""
    return run_to_end(finish_in_slices(planned, result))


def finish_in_slices(planned: Plan, result: dict[str, Any]) -> Generator[float, None, Outcome]:
    """Run :func:`finish` in slices: yield the share done (0..1) whenever Blender may draw, and return the outcome.

    Blender's data is looked up again in every slice, since anything may happen to it in between. A draft is a single slice."""
    warnings = [*planned.warnings, *result.get("warnings", ())]
    motions, laying, made = [], None, []
    for motion in result["motions"]:  # a path, or loaded already
        motions.append(motion if isinstance(motion, Motion) else engine_requests.take_motion(motion))
        yield 0.0
    if planned.follows:
        armature, scene = _find_target(planned)
        taken, words = take_list.active(armature).action, gesture_edits.stored_words(take_list.active(armature).action)
        warnings += unsaid_edits(gesture_edits.edits_of(taken), words, motions[0].words)
        what = retiming.follow(armature, scene, motions[0])
        return Outcome([], motions[0].duration, warnings, [retiming.change_sentence(what)])
    try:
        for number, performed in enumerate(motions):
            motion = timing.retimed_motion(performed, planned.voice.way)
            armature, scene = _find_target(planned)
            if laying is None:
                if not planned.draft or (drafts.is_staged(armature) and planned.settings["result"] != "LAYER"):
                    drafts.drop(armature)
                laying = ActionBuilder(planned, armature, scene, warnings.append)
            if planned.draft:
                action = run_to_end(laying.acting(motion, run_to_end(laying.keying(motion)), made))
                drafts.show(armature, action)
                return Outcome([action], motion.duration, warnings)
            keys = yield from _run_slices(planned, laying, laying.keying(motion), number / len(motions))
            yield from _run_slices(planned, laying, laying.acting(motion, keys, made), (number + 0.5) / len(motions))
        return (yield from _finish(planned, made, motions, warnings))
    except BaseException:
        for action in [action for action in bpy.data.actions if action.session_uid in made]:
            bpy.data.actions.remove(action)
        raise


def _run_slices(
    planned: Plan, laying: ActionBuilder, slices: Generator[None, None, Any], done: float
) -> Generator[float, None, Any]:
    """Run ``slices`` of a take, each with the character looked up again; return their result."""
    while True:
        laying.armature, laying.scene = _find_target(planned)
        try:
            next(slices)
        except StopIteration as end:
            yield done
            return end.value
        yield done


def _find_target(planned: Plan) -> tuple[ArmatureObject, bpy.types.Scene]:
    """Return the character and scene of a plan. Raises :class:`S2agError` if the character is gone."""
    armature = planned.armature.find(bpy.data.objects)
    if armature is None:
        raise S2agError(f"The character {planned.armature.name} is gone.", "Nothing was changed.")
    reading.require_armature(armature)
    if not planned.bones <= set(armature.pose.bones.keys()):
        raise S2agError("A bone of the character is gone.", "Nothing was changed.")
    scene = planned.scene.find(bpy.data.scenes) or current_context().scene
    if planned.rate not in (None, apply.scene_fps(scene)):
        raise S2agError("The scene's frame rate was changed while gestures came.", "Nothing was changed.")
    return armature, scene


def _find_actions(made: list[int]) -> list[bpy.types.Action]:
    """Return the actions of a run by their ``session_uid``."""
    actions = {action.session_uid: action for action in bpy.data.actions}
    if not actions.keys() >= set(made):
        raise S2agError("Gestures were undone while they came.", "Nothing was changed.")
    return [actions[uid] for uid in made]


def _finish(planned: Plan, made: list[int], motions: list[Motion], warnings: list[str]) -> Generator[float, None, Outcome]:
    """Annotate the actions and add them as takes, in slices as :func:`finish_in_slices`; only the last one changes the view."""
    for number, performed in enumerate(motions):
        gesture_edits.store_gestures(_find_actions(made)[number], performed, _find_target(planned)[1])
        yield 1.0
    armature, scene = _find_target(planned)
    actions, motion = _find_actions(made), motions[0]
    sync = scene.sync_mode
    own = _add_sound_and_markers(planned, scene, timing.retimed_motion(motion, planned.voice.way), warnings)
    for action in actions:
        action[sound_strips.TAG] = own
        if planned.settings["result"] == "ACTION":
            control_curves.copy_curves(armature, action, compat.bag(action, layers.slot_of(armature, action)))
    warnings = list(dict.fromkeys(warnings))
    former = planned.former.find(bpy.data.actions) if planned.former else None
    if former is not None:
        gesture_edits.restore_untouched_keys(former, actions[0], scene)
        take = next((take for take in armature.s2ag.takes if take.action == former), None)
        others = versions.version_actions(take) if take is not None else ()
        constraints.reapply_pins(former, actions[0], scene, list(planned.pins), others)
    carried = planned.carried.find(bpy.data.actions) if planned.carried else None
    if carried is not None:
        constraints.reapply_pins(carried, actions[0], scene, [])
    for action in actions:
        if former is None or planned.grown:
            retiming.store_strip(action, scene)
        else:
            retiming.copy_follow_state(former, action)
    silent, title, said = sound_strips.unmute_strip_of(armature, actions[0]), "", ""
    if former is not None:
        title = decisions.what_changed(former, actions[0], menu_items.gesture_label)
        before, after = (len(gesture_edits.shown_gestures(one, scene)) for one in (former, actions[0]))
        told = translate("{what}: {before} gestures before, {after} now", what=title, before=before, after=after)
        said = title if before == after else told
    if carried is not None:
        kept = len(gesture_edits.edits_of(actions[0])) - len(decisions.unmet(actions[0]))
        said = translate("{name}: {count} decisions kept", name=planned.armature.name, count=kept)
    if former is None or not versions.add_version(armature, former, actions[0], warnings, title):
        take_list.add_takes(armature, actions, planned.voice.name, warnings)
    news = [constraints.reach_target(armature, actions[0], scene, pin) for pin in planned.pins if "object" in pin]
    if any(news):
        take_list.active(armature).warnings = "\n".join([*warnings, *filter(None, news)])
    notes = [translate("The sound of an earlier take is silent now: {name}", name=name) for name in silent]
    if scene.sync_mode != sync:
        notes.append(translate("Playback is in sync with the sound from now on"))
    return Outcome(actions, motion.duration, warnings, notes, said)


def _add_sound_and_markers(planned: Plan, scene: bpy.types.Scene, motion: Motion, warnings: list[str]) -> str:
    """Add the sound strip and the word markers if they are wanted; return the strip's tag."""
    span, kept, voice = planned.voice.span, planned.settings, planned.voice
    own = voice.tag
    if voice.placed:
        scene.sync_mode = "AUDIO_SYNC"
    else:
        name = f"{planned.armature.name} – {Path(voice.path).stem}"
        own, news = sound_strips.add_strip(scene, voice.path, round(span.start), name, kept["add_sound"])
        warnings.extend(news)
    if kept["add_markers"]:
        if motion.words:
            markers.add(scene, motion.words, span.start, kept["marker_prefix"], span.first, span.last)
        else:
            warnings.append("There are no word markers, because the words are not known.")
    return own
