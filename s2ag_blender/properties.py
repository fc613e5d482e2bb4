"""What the animator set for a character, kept on its object and saved with the file."""

import json
from pathlib import Path

import bpy


def style_names() -> list[str]:
    """Names of the shipped checkpoint's speakers, read from its metadata without torch."""
    metadata = Path(__file__).resolve().parents[1] / "core" / "assets" / "default.json"
    if not metadata.is_file():
        return []
    return [speaker["name"] for speaker in json.loads(metadata.read_text("utf-8"))["speakers"]]


def _search_styles(self, context, text: str):
    return [name for name in [*style_names(), "random"] if text.lower() in name.lower()]


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
    mirror: bpy.props.BoolProperty(name="Mirror", description="Exchange left and right")
    start_frame: bpy.props.IntProperty(name="Start Frame", description="Frame on which the recording starts", default=1)
    add_sound: bpy.props.BoolProperty(name="Sound Strip", description="Put the recording into the sequencer", default=True)
