"""What was decided about a take, edit by edit: in words, switched off, changed or removed."""

from collections.abc import Callable, Sequence
from typing import Any

import bpy

from ...core.editing.edits import OFF
from .. import provenance
from ..datablocks import ArmatureObject
from ..translations import translate, translate_style
from . import gesture_edits, menu_items, take_list

_NEAR = 0.35
"""Seconds within which a word belongs to a time."""


def words_of(edit: dict[str, Any], action: bpy.types.Action, label: Callable[[str], str] = str) -> str:
    """Return an edit of a take in a few words; ``label`` names kinds and hands."""
    at = edit.get("at")
    times = at if isinstance(at, list) else [at] if at is not None else []
    if len(times) > 1:
        values = {"count": len(times), "first": min(times), "last": max(times)}
        return translate("{count} deleted, {first:.1f} to {last:.1f} s", **values)
    when = _moment(times[0], action) if times else f"“{edit.get('word', '')}”"
    span = f"{edit['from']:.1f} – {edit['to']:.1f} s" if "from" in edit else ""
    details = [label(edit[name]) for name in ("kind", "hand") if name in edit]
    details += [f"× {edit['size']:.2g}"] if "size" in edit else []
    what = ", ".join(details)
    made = {
        "move": lambda: translate("Moved by {by:+.1f} s, {when}", by=edit["to"] - edit["at"], when=when),
        "delete": lambda: translate("Deleted, {when}", when=when),
        "change": lambda: translate("{what}, {when}", what=what, when=when),
        "add": lambda: translate("Added, {when}", when=f"{what}, {when}" if what else when),
        "reroll": lambda: translate("Made anew ({seed}), {when}", seed=edit.get("seed", 0), when=span),
        "rest": lambda: _rest(edit, span),
        "style": lambda: translate("{style} from {when}", style=translate_style(edit["style"]), when=when),
        "feel": lambda: translate("{style} from {when}", style=menu_items.mood_label(edit), when=when),
        "pose": lambda: translate("Pose kept, {when}", when=when),
        "place": lambda: translate("{hand} at its place, {when}", hand=label(edit["hand"]), when=span),
    }
    return made[edit["do"]]() if edit.get("do") in made else str(edit.get("do"))


def _rest(edit: dict[str, Any], span: str) -> str:
    if edit.get("how") == "calmer":
        return translate("Calmer, {when}", when=span)
    return translate("Fewer, {when}", when=span) if edit.get("how") == "fewer" else translate("At rest, {when}", when=span)


def _moment(at: float, action: bpy.types.Action) -> str:
    """Return a time with the word that is said then."""
    said = [(abs(0.5 * (start + end) - at), word) for word, start, end in gesture_edits.stored_words(action)]
    off, word = min(said, default=(_NEAR + 1, ""))
    return f"{at:.1f} s “{word}”" if off <= _NEAR else f"{at:.1f} s"


def switched(edits: Sequence[dict], number: int) -> list[dict]:
    """Return the edits with one of them switched off, or on again."""
    one = {name: value for name, value in edits[number].items() if name != OFF}
    return [*edits[:number], one if edits[number].get(OFF) else {**one, OFF: True}, *edits[number + 1 :]]


def without(edits: Sequence[dict], number: int) -> list[dict]:
    """Return the edits without one of them."""
    return [*edits[:number], *edits[number + 1 :]]


def what_changed(before: bpy.types.Action, after: bpy.types.Action, label: Callable[[str], str] = str) -> str:
    """Return in a few words by which decisions a version of a take differs from the ``before`` one."""
    old, new = gesture_edits.edits_of(before), gesture_edits.edits_of(after)
    same = next((at for at, (one, other) in enumerate(zip(old, new, strict=False)) if one != other), min(len(old), len(new)))
    if len(new) > len(old) and same == len(old):
        more = len(new) - len(old) - 1
        what = words_of(new[same], after, label)
        return translate("{what}, and {more} more", what=what, more=more) if more else what
    if len(new) < len(old):
        return translate("Taken back: {what}", what=words_of(old[same], before, label))
    if same == len(new):
        return translate("The same again")
    if bool(new[same].get(OFF)) != bool(old[same].get(OFF)):
        what = words_of(new[same], after, label)
        return translate("Off: {what}", what=what) if new[same].get(OFF) else translate("On again: {what}", what=what)
    return words_of(new[same], after, label)


def carried(armature: ArmatureObject, settings: Any) -> tuple[bpy.types.Action | None, str]:
    """Return the action of the selected take if a new take can keep its decisions, and a sentence on why not, "" for none."""
    take = take_list.active(armature)
    if take is None or not gesture_edits.edits_of(take.action):
        return None, ""
    before = provenance.require(take.action)["settings"]
    if any(before.get(name) != getattr(settings, name) for name in ("audio", "audio_source", "sound_strip")):
        return None, translate("The decisions about {name} stay with it: they are about another recording.", name=take.title)
    if settings.take_count > 1:
        return None, translate("The decisions about {name} stay with it: only a single take can keep them.", name=take.title)
    return take.action, ""


def unmet(action: bpy.types.Action) -> set[int]:
    """Return the numbers of the edits of a take, from 0, that could not be done."""
    found = (provenance.read(action) or {}).get("unmet", [])
    return {number for number in found if isinstance(number, int)} if isinstance(found, list) else set()
