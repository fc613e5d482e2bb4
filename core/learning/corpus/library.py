"""The gesture library: clips with meaning, hand and intensity from their file names and with measured height and size."""

import re
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path

import numpy as np

from ...motion import skeleton
from . import authored, clips, smartbody
from .clips import Clip

SETS = {
    "Gestures": ("ChrBrad.sk", clips.SMARTBODY),
    "Gestures2": ("ChrBrad2.sk", clips.SMARTBODY),
    "FemaleGestures": ("ChrConnor.sk", clips.SMARTBODY),
    "MaleGestures": ("ChrGarza.sk", clips.SMARTBODY),
    "PNGestures": ("pnskeleton.bvh", clips.PERCEPTION_NEURON),
}

MEANINGS = {
    "beat": "BeatLow BeatMid BeatHigh BeatFlip BeatForward BeatFistMid BeatPointMid",
    "list": "Chop ChopBoth",
    "me": "Me",
    "you": "You YouForward YouLeft YouRight YouPoint",
    "we": "We us",
    "here": "Here PointHere PointCenter",
    "there": "IndicateLeft IndicateRight Point PointLeft PointRight DeicticLeft DeicticRight",
    "not": "Negative Negation NegateForwardLow NegateForwardMid NegateLeftLow NegateLeftMid NegateRightLow NegateRightMid "
    "NoForward NoLeft NoRight",
    "none": "InclusivityNeg Safe ThrowAway",
    "however": "However Besides",
    "example": "Example When",
    "all": "InclusivityPos Inclusivity Surround",
    "big": "Bigger EmptyLarge",
    "thing": "EmptyMedium Frame",
    "offer": "Offer",
    "receive": "Receive",
    "please": "Plea",
    "maybe": "Shrug",
    "question": "Question",
    "stop": "Stop StopForward StopLeft StopRight",
    "think": "Contemplate Think",
}
"""Meaning -> labels in file names. Other labels (stretching, walking, a guitar) are no co-speech gestures."""

ALL_MEANINGS = ("beat", *sorted({*MEANINGS, "unknown", "small", "count"} - {"beat"}))
"""All meanings of strokes; corpora store the index."""

_LABELS = {label.lower(): meaning for meaning, labels in MEANINGS.items() for label in labels.split()}
_NAME = re.compile(r"(?:\w+@(?P<rest>\w+?)_)?(?P<label>[A-Za-z]+?)(?P<intense>_intense)?(?P<hand>Lf|Rt|Bt)?(?P<variant>\d*)$")


@dataclass(frozen=True)
class Gesture:
    """A clip with properties from its name and its motion.

    ``height`` and ``size`` are measured in metres on the canonical skeleton: the higher wrist's height above the hip at the
    emphasis, and the largest distance of a wrist from rest.
    """

    clip: Clip
    family: str
    label: str
    meaning: str
    intense: bool
    height: float
    size: float

    @property
    def name(self) -> str:
        """The clip's name, unique in the library."""
        return self.clip.name

    @cached_property
    def bend(self) -> float:
        """Bend of the gesturing elbow at the emphasis in degrees; the straighter one of two."""
        pose = self.clip.at(np.array([self.clip.emphasis]))[0]
        cosine = (pose[[4, 7]] * pose[[5, 8]]).sum(-1)
        working = [side == self.hand or self.hand == "both" for side in ("left", "right")]
        return float(np.degrees(np.arccos(np.clip(cosine, -1, 1)))[working].min())

    @cached_property
    def hand(self) -> str:
        """``"left"``, ``"right"`` or ``"both"``: the arms that take part."""
        left, right = self.clip.hands
        return "both" if min(left, right) > 0.55 * max(left, right) else "left" if left > right else "right"

    def mirrored(self) -> "Gesture":
        """Return the gesture with sides swapped."""
        return Gesture(self.clip.mirrored(), self.family, self.label, self.meaning, self.intense, self.height, self.size)


def parse_name(stem: str) -> tuple[str, str, str, bool] | None:
    """Parse a file's stem into ``(rest pose, label, meaning, intense)``; None if it is no co-speech gesture."""
    match = _NAME.match(stem)
    if not match:
        return None
    label = match["label"]
    meaning = _LABELS.get(label.lower())
    return (match["rest"] or "", label, meaning, bool(match["intense"])) if meaning else None


def load(material: str | PathLike) -> list[Gesture]:
    """Load all co-speech gestures below ``material``/smartbody and the authored ones in a fixed order, each also mirrored.

    Raises ``FileNotFoundError`` if the sets are missing.
    """
    gestures: list[Gesture] = []
    for family, (skeleton_file, roles) in SETS.items():
        folder = Path(material) / "smartbody" / family
        joints = smartbody.load_skeleton(folder / "skeletons" / skeleton_file)
        seen = set()
        for path in sorted((folder / "motions").glob("*.skm")):
            parsed = parse_name(path.stem)
            if parsed is None or path.stem in seen:
                continue
            seen.add(path.stem)
            clip = clips.load(path, joints, roles, f"{family}/{path.stem}")
            if _usable(clip, parsed[0], parsed[2]):
                gestures.append(_describe(clip, family, *parsed[1:]))
    gestures += [_describe(clip, authored.FAMILY, label, meaning, False) for meaning, label, clip in authored.clips()]
    return gestures + [gesture.mirrored() for gesture in gestures]


def _usable(clip: Clip, rest: str, meaning: str) -> bool:
    """Return whether the arms move (a shrug may be all shoulders) and do not start folded or with hands on the hips; a few
    large gestures that leave the hips at once are usable."""
    if rest == "IdleCross01" or (rest == "Idle03" and meaning not in ("big", "thing", "there")):
        return False
    return max(clip.hands) >= 0.6 or meaning == "maybe"


def _describe(clip: Clip, family: str, label: str, meaning: str, intense: bool) -> Gesture:
    positions = skeleton.to_positions(clip.directions)[:, [6, 9]]
    height = float(-positions[round(clip.emphasis * clip.fps), :, 1].min())
    size = float(np.linalg.norm(positions - positions[:1], axis=-1).max())
    return Gesture(clip, family, label, meaning, intense, height, size)
