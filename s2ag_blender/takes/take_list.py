"""Manages the takes of a character: adds, shows, names, deletes them, and plans more takes like them."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import bpy

from ...core.provenance import restored
from .. import provenance
from ..datablocks import ArmatureObject
from ..keys import layers
from ..keys.apply import scene_fps
from ..translations import translate, translate_style
from . import drafts, menu_items, sound_strips, stored_settings

_LONGEST_LINE = 24
"""Letters of a recording's name in that of an action; Blender before 5.0 cuts names at 63 bytes."""
_DELETED = "s2ag_deleted"
"""Custom property of actions that were deleted while takes made from them still need them."""


def add_takes(
    armature: ArmatureObject, actions: list[bpy.types.Action], recording: str = "", warnings: Sequence[str] = ()
) -> None:
    """Append the actions of one run to the list and show the first of them.

    Each take stores the display name of its ``recording`` and the ``warnings`` of the run."""
    settings = armature.s2ag
    run = 1 + max((take.run for take in settings.takes), default=0)
    first = len(settings.takes)
    for number, action in enumerate(actions):
        name = title(armature, action)
        take = settings.takes.add()
        # Library overrides identify their own items by name, so names must be unique.
        take.name, take.action, take.run = f"{run}.{number}", action, run
        take.recording, take.warnings = recording, "\n".join(warnings)
        note_frames(take)
        take.title = name  # names its action, too
    settings.active_take = first  # shows it


def note_frames(take: Any) -> None:
    """Store on a take the frames of its action."""
    place = layers.Place.of(take.action)  # an idle has none
    take.first, take.last = (place.first, place.last) if place else map(round, take.action.frame_range)


def title(armature: ArmatureObject, action: bpy.types.Action) -> str:
    """Return a take's first name: its style, or that it listens or idles, with the lowest number that it has not used."""
    meta = provenance.require(action)
    style = translate("Listening") if meta.get("listen") else translate("Idle") if "idle" in meta else meta.get("style", "")
    style = " + ".join(translate_style(one) for one in (style if isinstance(style, dict) else [style]))
    used = {take.title for take in armature.s2ag.takes}
    return next(name for number in range(1, len(used) + 2) if (name := f"{style} {number}") not in used)


def rename(armature: ArmatureObject, take: Any) -> None:
    """Name the action of a take, and the strip that plays it, after its character, recording, title and version."""
    if take.action is None or take.action.library is not None:
        return
    number = next((number for number, one in enumerate(take.versions, 1) if one.action == take.action), 1)
    names = armature.name, Path(take.recording).stem[:_LONGEST_LINE], take.title
    take.action.name = " – ".join(name for name in names if name) + (f" ({number})" if number > 1 else "")
    for strip in layers.strips(armature):
        if strip.action == take.action:
            strip.name = take.action.name


def frames_beyond_scene(armature: ArmatureObject, scene: bpy.types.Scene) -> tuple[float, float] | None:
    """Return the seconds from the scene's start to the ends of the selected take and of the scene; None if that shows all."""
    take = active(armature)
    if take is None or take.last <= max(take.first, scene.frame_end):
        return None
    before, rate = scene.frame_start - 1, scene_fps(scene)
    return (take.last - before) / rate, (scene.frame_end - before) / rate


def fit_scene(armature: ArmatureObject, scene: bpy.types.Scene) -> None:
    """Extend the scene's frame range to the selected take."""
    take = active(armature)
    scene.frame_start, scene.frame_end = min(scene.frame_start, take.first), max(scene.frame_end, take.last)


def active(armature: ArmatureObject) -> Any:
    """Return the take (``S2AG_Take``) that is selected in the list, or None if there is none or its action is gone."""
    settings = armature.s2ag
    if not 0 <= settings.active_take < len(settings.takes):
        return None
    take = settings.takes[settings.active_take]
    return take if take.action is not None else None


def show(armature: ArmatureObject) -> None:
    """Play the selected take; called whenever the selection changes."""
    take = active(armature)
    if take is not None and provenance.read(take.action):
        drafts.drop(armature)
        layers.show(armature, take.action)
        sound_strips.unmute_strip_of(armature, take.action)


def delete(armature: ArmatureObject, indices: Iterable[int]) -> None:
    """Delete takes, and their actions unless something else uses them.

    If the playing take is deleted, its neighbour plays, or the action from before the takes."""
    settings = armature.s2ag
    shown = active(armature)
    playing = shown.action if shown else None
    nearest = settings.active_take
    for index in sorted(set(indices), reverse=True):
        take = settings.takes[index]
        gone = dict.fromkeys(action for action in (take.action, *(one.action for one in take.versions)) if action is not None)
        settings.takes.remove(index)
        for action in gone:
            if not any(take.action == action for take in settings.takes):
                playing = None if action == playing else playing
                discard(armature, action)
    sound_strips.remove_unused()
    survived = next((number for number, take in enumerate(settings.takes) if playing and take.action == playing), None)
    settings.active_take = min(nearest, len(settings.takes) - 1) if survived is None else survived


def discard(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Stop playing an action of ours, and delete it, now or as soon as nothing else uses it.

    What it was made from plays again, unless that was deleted before it."""
    seen = {action.session_uid}
    while True:
        data = armature.animation_data
        played = data is not None and data.action == action
        layers.hide(armature, action)
        if action.users - action.use_fake_user <= 0:
            bpy.data.actions.remove(action)
        elif action.library is None:
            action[_DELETED] = True
            action.use_fake_user = False  # that of a kept take would outlive the takes that were made from it
        below = data.action if data is not None and played else None
        if below is None or below.session_uid in seen or _DELETED not in below:
            return
        action = below
        seen.add(action.session_uid)


def others(armature: ArmatureObject) -> list[int]:
    """Return the numbers of takes that are neither kept nor selected."""
    settings = armature.s2ag
    return [number for number, take in enumerate(settings.takes) if not take.keep and number != settings.active_take]


def delete_others(armature: ArmatureObject) -> int:
    """Delete takes that are neither kept nor selected; return their number."""
    doomed = others(armature)
    delete(armature, doomed)
    return len(doomed)


def remake_arguments(action: bpy.types.Action, **changes: Any) -> dict[str, Any]:
    """Return arguments for ``generate.plan`` that make the same take again, apart from ``changes``."""
    meta = provenance.require(action)
    same = {"kept": meta["settings"], "keyed_pose": meta.get("keyed_pose"), "pose": meta.get("pose")}
    same |= {"around": meta.get("around"), "like": action}
    return {**same, **restored(meta, "take"), **changes}


def has_other_weights(meta: Mapping[str, Any]) -> bool:
    """Return whether the take with this provenance was made by other weights than its settings name now."""
    hash_ = menu_items.speakers_and_controls(stored_settings.settings_view(meta["settings"])).get("hash")
    return bool(hash_) and meta.get("checkpoint") not in (None, hash_)


def recall_settings(armature: ArmatureObject, action: bpy.types.Action) -> str:
    """Restore the settings with which a take was made; return a sentence on what they do not make again, "" for nothing."""
    meta = provenance.require(action)
    stored_settings.restore(armature.s2ag, meta["settings"])
    armature.s2ag.seed = meta["seed"]
    if has_other_weights(meta):
        return translate("The take was made by other weights, so phrases would not fit in.")
    if "chance" in meta:
        return ""
    return translate("An earlier version made this take: these settings make another one now. Changes of it still fit in")


def reroll_arguments(armature: ArmatureObject, action: bpy.types.Action) -> dict[str, Any]:
    """Return arguments for ``generate.plan``: the settings of a take with the lowest seed above its own that no take has."""
    metas = [provenance.read(take.action) or {} for take in armature.s2ag.takes if take.action is not None]
    used = {meta.get("seed") for meta in metas}
    seed = int(provenance.require(action)["seed"]) + 1
    while seed in used:
        seed += 1
    return remake_arguments(action, seed=seed, take=0, near=[], chance=None)


def variation_arguments(armature: ArmatureObject, action: bpy.types.Action, spread: float, count: int) -> dict[str, Any]:
    """Return arguments for ``generate.plan``: ``count`` new variations of a take at the distance ``spread`` (0..1)."""
    meta = provenance.require(action)
    here = meta.get("take", 0), meta.get("near") or []
    metas = [provenance.read(take.action) or {} for take in armature.s2ag.takes if take.action is not None]
    steps = [one["near"] for one in metas if one.get("near") and (one["take"], one["near"][:-1]) == here]
    step = 1 + max((near[-1][0] for near in steps), default=0)
    return remake_arguments(action, spread=round(spread, 4), count=count, step=step, made_by=meta.get("checkpoint", ""))
