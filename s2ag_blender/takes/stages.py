"""What goes on while gestures are made, in the words of who waits for them."""

from ..translations import told

KEYING = "key the takes"
"""The stage in which Blender lays what the engine has made; the others are the engine's."""
SHOWN = {
    "": "Getting ready",
    "decode audio": "Reading the recording",
    "read audio": "Reading the recording",
    "load model": "Getting ready",
    "align words": "Finding the words",
    "load word vectors": "Understanding the words",
    "extract MFCC": "Listening to the recording",
    "hear sounds": "Finding mouth shapes",
    "find pauses": "Finding the pauses",
    "listen": "Listening to the other",
    "generate": "Making the gestures",
    "finish": "Finishing the gestures",
    KEYING: "Writing keyframes",
}
"""Stages and what is shown of them."""


def shown(stage: str) -> str:
    """A stage for people, in the user's language."""
    return told(SHOWN.get(stage, stage))
