"""Items of the panel's menus and search fields: styles of the checkpoint, kinds of gestures, sound strips of the scene, bones.

Registering the extension runs this file, which therefore imports what is slow to load where it is used."""

import functools
import re
from pathlib import Path
from typing import Any

import blf
import bpy

from ...core import own_styles
from ...core.editing.names import BEAT, REST
from ...core.errors import CheckpointUnreadable
from ...core.settings import checkpoint_of
from ...core.style_names import RANDOM, split_sequence
from .. import compat
from ..datablocks import Context
from ..translations import translate

WRITTEN = "__written__"
"""Menu item of a style that is neither a name nor random, such as a blend written by hand."""
NOBODY = "__nobody__"
"""Menu item of no second style."""


def style_names(settings: Any = None) -> list[str]:
    """Return the names of the speakers of a character's checkpoint (the shipped one's without ``settings``), without torch."""
    return [speaker["name"] for speaker in speakers_and_controls(settings)["speakers"]]


def control_names(settings: Any = None) -> list[str]:
    """Return the names of a checkpoint's controls; none for one that was trained without."""
    return [control["name"] for control in speakers_and_controls(settings)["controls"]]


def speakers_and_controls(settings: Any = None) -> dict[str, Any]:
    """Return the speakers and controls of a character's checkpoint (the shipped one's without ``settings``); empty where it
    cannot be read."""
    from ...core.model import checkpoint_metadata

    checkpoint = checkpoint_of(settings) if settings is not None else ""
    path = checkpoint_metadata.locate(bpy.path.abspath(checkpoint))
    facts = checkpoint_metadata.metadata_path(path)
    parts = facts, own_styles.folder()
    return _read_checkpoint(path, *(part.stat().st_mtime_ns if part and part.exists() else 0 for part in parts))


@functools.lru_cache(maxsize=4)
def _read_checkpoint(path: Path, written: int, own: int) -> dict[str, Any]:
    """Return a checkpoint's metadata with the user's styles, cached by the times of its file and of their folder, since the
    panel reads it at every redraw."""
    from ...core.model import checkpoint_metadata

    try:
        return checkpoint_metadata.describe(path)
    except CheckpointUnreadable:
        return {"speakers": [], "controls": []}


def style_description(settings: Any) -> str:
    """Return the description of the chosen style; empty for a blend and for random."""
    name = settings.style or _default(settings)
    return next((one["description"] for one in speakers_and_controls(settings)["speakers"] if one["name"] == name), "")


def style_parameter(settings: Any) -> dict[str, str]:
    """Return the engine's parameter of the style."""
    return {"style": style_expression(settings)}


def style_expression(settings: Any) -> str:
    """Return the style for the engine: the chosen one, blended with the second style where there is one."""
    first, share = settings.style, round(settings.style_mix, 4)
    if not (settings.style_second and share and can_blend(settings)):
        return first
    first = first or _default(settings)
    return f"{first}:{1 - share:g}+{settings.style_second}:{share:g}"


def is_written(settings: Any) -> bool:
    """Return whether the style is an expression rather than a name."""
    return bool(set(settings.style) & set(":+"))


def walks(settings: Any) -> bool:
    """Return whether the style is a sequence of several, which change on the way."""
    return len(split_sequence(settings.style)) > 1


def can_blend(settings: Any) -> bool:
    """Return whether a second style can be blended in, which needs a single named style."""
    return settings.style != RANDOM and not is_written(settings)


ROOM = 204
"""Width of a line of text beside its icon in a sidebar of the default width (280 pixels), in pixels of Blender's font."""
_FONT_POINTS = 11


def text_width(text: str) -> float:
    """Return the width of a text in pixels at Blender's usual font size."""
    blf.size(0, _FONT_POINTS)
    return blf.dimensions(0, text)[0]


_PIECE = re.compile(r" ?[（「“]*(?:[^ ⺀-￯]+|[⺀-￯])[）」”。、，：；？ー…っゃゅょッャュョァィゥェォ]*")
"""What stays on one line: a word, or a letter of Chinese or Japanese with what may not begin a line."""


@functools.lru_cache(maxsize=64)
def wrap_text(text: str, room: float = ROOM) -> list[str]:
    """Wrap a sentence to lines that fit the sidebar; only a word that is too long itself exceeds it."""
    lines: list[str] = []
    for piece in _PIECE.findall(" ".join(text.split())):
        if lines and text_width(lines[-1] + piece) <= room:
            lines[-1] += piece
        else:
            lines.append(piece.strip())
    return lines


HANDS = (("left", "Left Hand", ""), ("right", "Right Hand", ""), ("both", "Both Hands", ""))
"""Items of the hands of a gesture."""


@functools.cache  # Blender keeps no reference to the texts of a menu
def kinds(first: tuple[tuple[str, str, str], ...] = ()) -> tuple[tuple[str, str, str], ...]:
    """Return the items of the kinds of a gesture, each with what it shows, behind the items ``first``, in columns."""
    from . import gesture_kinds

    items = [*first, (BEAT, "Beat", "A stroke that the performer makes elsewhere in the take")]
    items.append((REST, "Rest", "No gesture: both hands go home for a moment"))
    for heading, shown in gesture_kinds.GROUPS.items():
        items += [("", heading, "")] if heading else []
        items += [(name, "So-So" if name == "soso" else name.capitalize(), told) for name, told in shown.items()]
    return tuple(items)


MOODS = (
    ("excited", "Excited", "Large, fast, high and often", {"arousal": 1.0}),
    ("sleepy", "Sleepy", "Small, slow, low and seldom", {"arousal": -1.0}),
    ("pleased", "Pleased", "Open, arms away from the body", {"valence": 1.0}),
    ("displeased", "Displeased", "Closed, arms near the body", {"valence": -1.0}),
    ("leading", "In Command", "Broad and upright", {"dominance": 1.0}),
    ("timid", "Timid", "Narrow and held back", {"dominance": -1.0}),
    ("plain", "Neither", "No feeling, whatever the voice says", {"arousal": 0.0, "valence": 0.0, "dominance": 0.0}),
)
"""Feelings: name, label, what they look like, and affects."""


def gesture_label(name: str) -> str:
    """Return the label of a kind or a hand."""
    return translate(labels().get(name, name))


@functools.cache
def labels() -> dict[str, str]:
    """Return the labels of kinds and hands."""
    return {name: label for name, label, _ in (*kinds(), *HANDS)}


TEMPERAMENTS = {
    "Calm": (
        "calm lecturer", "diplomat", "dreamer", "elegant host", "news anchor", "old professor", "thoughtful explainer",
        "warm host",
    ),
    "Lively": (
        "brisk presenter", "coach", "eager storyteller", "excited teenager", "grand orator", "left-handed joker", "sales rep",
        "street preacher", "tour guide",
    ),
    "Reserved": ("deadpan", "nervous", "shy student", "skeptic", "stern", "technician", "tired"),
    "Your Own": (),
}
"""Headings of the menu of the shipped styles, by what their descriptions say, and the styles below each; others come last."""


def mood_label(affects: dict[str, float]) -> str:
    """Return the labels of the feelings that affects are, with how much of each."""
    single = [(label, *next(iter(felt.items()))) for _, label, _, felt in MOODS if len(felt) == 1]
    parts = [f"{translate(label)} {abs(affects[name]):.2g}" for label, name, one in single if affects.get(name, 0) * one > 0]
    return ", ".join(parts) or translate("Neither")


def style_items(settings: Any, context: Context) -> list[tuple]:
    """Return the items of the style menu: the checkpoint's speakers, random, and an expression written by hand."""
    return _style_items(tuple((one["name"], one["description"]) for one in speakers_and_controls(settings)["speakers"]))


def second_items(settings: Any, context: Context) -> list[tuple]:
    """Return the items of the menu of the second style."""
    return _second_items(tuple((one["name"], one["description"]) for one in speakers_and_controls(settings)["speakers"]))


@functools.lru_cache(maxsize=4)  # Blender keeps no reference to the texts of a menu
def _style_items(speakers: tuple[tuple[str, str], ...]) -> list[tuple]:
    more = [(RANDOM, "Random", "Another speaker with every seed", len(speakers))]
    more.append((WRITTEN, "As Written", "A style expression written by hand, such as A:0.6+B:0.4", len(speakers) + 1))
    return [*more, *_ordered(speakers, 0)]  # first, because what follows a heading is drawn below it


@functools.lru_cache(maxsize=4)
def _second_items(speakers: tuple[tuple[str, str], ...]) -> list[tuple]:
    return [(NOBODY, "Nobody", "Only the first style", 0), *_ordered(speakers, 1)]


CACHED = (_style_items, _second_items)
"""What holds numbers of pictures."""


def _ordered(speakers: tuple[tuple[str, str], ...], first: int) -> list[tuple]:
    """Return the items of speakers, numbered from ``first`` on, by temperament with headings, else by name."""
    from .gesture_kinds import style_icon

    items = {
        name: (name, name[:1].upper() + name[1:], text, style_icon(name), number)
        for number, (name, text) in enumerate(speakers, first)
    }
    if not items.keys() >= set().union(*TEMPERAMENTS.values()):  # the menu cannot sort them
        return [items[name] for name in sorted(items)]
    own = tuple(sorted(set(items).difference(*TEMPERAMENTS.values())))
    below = [(label, names or own) for label, names in TEMPERAMENTS.items() if names or own]
    return [one for label, names in below for one in [("", label, ""), *(items[name] for name in names)]]


def get_style(settings: Any) -> int:
    """Return the number of the style menu's item for the stored style."""
    names = style_names(settings)
    name = settings.style or _default(settings)
    if name in names:
        return names.index(name)
    return len(names) + (name != RANDOM)


def set_style(settings: Any, number: int) -> None:
    """Store the style menu's item."""
    names = [*style_names(settings), RANDOM]
    if number < len(names):
        settings.style = names[number]
    elif not is_written(settings):
        settings.style = f"{settings.style or _default(settings)}:1"


def get_second(settings: Any) -> int:
    """Return the number of the second menu's item for the stored style."""
    names = style_names(settings)
    return names.index(settings.style_second) + 1 if settings.style_second in names else 0


def set_second(settings: Any, number: int) -> None:
    """Store the second menu's item."""
    settings.style_second = style_names(settings)[number - 1] if number else ""


def search_styles(settings: Any, context: Context, text: str) -> list[str]:
    """Return the style names that contain ``text``."""
    return [name for name in [*style_names(settings), RANDOM] if text.lower() in name.lower()]


def search_strips(settings: Any, context: Context, text: str) -> list[str]:
    """Return the names of the scene's sound strips that contain ``text``."""
    return [strip.name for strip in compat.sound_strips(context.scene) if text.lower() in strip.name.lower()]


def search_bones(item: Any, context: Context, text: str) -> list[str]:
    """Return completions of a part's bones: the text up to the last comma, followed by any matching bone's name."""
    before, comma, last = text.rpartition(",")
    names = [bone.name for bone in item.id_data.data.bones if last.strip().lower() in bone.name.lower()]
    return [f"{before}{comma} {name}".strip() for name in names[:50]]


def _default(settings: Any) -> str:
    speakers = speakers_and_controls(settings)["speakers"]
    return next((one["name"] for one in speakers if one["default"]), speakers[0]["name"] if speakers else "")
