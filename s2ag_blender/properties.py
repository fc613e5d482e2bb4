"""What the animator set for a character, kept on its object and saved with the file."""

import functools

import bpy

from ..core import catalogue
from ..core.errors import CheckpointUnreadable
from ..core.styles import EXPLAINED


def style_names() -> list[str]:
    """Names of the shipped checkpoint's speakers, read from its metadata without torch."""
    return [speaker["name"] for speaker in _known()["speakers"]]


def control_names() -> list[str]:
    """Names of the controls that the shipped checkpoint has; none for one that was trained without."""
    return [control["name"] for control in _known()["controls"]]


def _known() -> dict:
    facts = catalogue.facts_path(catalogue.DEFAULT)
    return _described(facts.stat().st_mtime_ns if facts.is_file() else 0)


@functools.lru_cache(maxsize=1)
def _described(written: int) -> dict:
    """The shipped checkpoint as its JSON, ``written`` then, describes it; the panel asks at every redraw."""
    try:
        return catalogue.describe()
    except CheckpointUnreadable:
        return {"speakers": [], "controls": []}


def _search_styles(self, context, text: str):
    return [name for name in [*style_names(), "random"] if text.lower() in name.lower()]


def _control(name: str, label: str):
    return bpy.props.FloatProperty(name=label, description=EXPLAINED[name], min=-1.0, max=1.0, step=5, precision=2)


class S2AG_Settings(bpy.types.PropertyGroup):
    """Inputs of one character's gestures."""

    audio: bpy.props.StringProperty(name="Recording", description="Voice recording, in any common format", subtype="FILE_PATH")
    transcript: bpy.props.StringProperty(
        name="Transcript",
        description="Words of the recording: a .txt, or a .json of [word, start, end]; without it the audio alone gestures",
        subtype="FILE_PATH",
    )
    style: bpy.props.StringProperty(
        name="Style",
        description="A speaker, a blend such as calm lecturer:0.6+stern:0.4, or random",
        search=_search_styles,
        search_options={"SUGGESTION"},
    )
    seed: bpy.props.IntProperty(name="Seed", description="Same seed, same gestures", min=0)
    intensity: bpy.props.FloatProperty(
        name="Intensity", description="How far gestures depart from rest", default=1.0, min=0.0, max=3.0, soft_max=1.5
    )
    arousal: _control("arousal", "Arousal")
    valence: _control("valence", "Valence")
    dominance: _control("dominance", "Dominance")
    rate: _control("rate", "Rate")
    hand: _control("hand", "Hand")
    mirror: bpy.props.BoolProperty(name="Mirror", description="Exchange left and right")
    start_frame: bpy.props.IntProperty(name="Start Frame", description="Frame on which the recording starts", default=1)
    add_sound: bpy.props.BoolProperty(name="Sound Strip", description="Put the recording into the sequencer", default=True)
