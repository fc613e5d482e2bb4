"""Display names of the stages of a run."""

from ..translations import translate

KEYING = "key the takes"
"""The stage in which Blender keys the engine's motions; the other stages are the engine's."""
SHOWN = {
    "": "Getting ready",
    "decode audio": "Reading the recording",
    "read audio": "Reading the recording",
    "load model": "Getting ready",
    "align words": "Finding the words",
    "load word vectors": "Understanding the words",
    "extract MFCC": "Listening to the recording",
    "hear sounds": "Finding mouth shapes",
    "hear affect": "Listening to the recording",
    "find pauses": "Finding the pauses",
    "listen": "Listening to the other",
    "generate": "Making the gestures",
    "finish": "Finishing the gestures",
    KEYING: "Writing keyframes",
}
"""``{stage: display name}``."""


def shown(stage: str) -> str:
    """Return the display name of a stage in the user's language."""
    return translate(SHOWN.get(stage, stage))
