"""The table of all settings of a request and of the models.

A setting is declared only here: name, type, default, range, and the texts of command line and panel. The checks of
:class:`request.Request`, the worker's parameters, the options of ``s2ag``, the columns of manifests, provenance, and Blender's
properties, presets and sliders are derived from it (:class:`declaration.Setting` explains the attributes). To add a setting,
declare it here and read ``request.NAME`` where it is used."""

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

from . import characters
from .declaration import Setting, command_options, setting, sliders, table

if TYPE_CHECKING:
    import numpy as np

__all__ = ["AFFECTS", "CONTROLS", "CURVES", "SWITCHES", "Documents", "Models", "Setting", "Settings"]
__all__ += ["checkpoint_of", "command_options", "names_with", "sliders", "table"]

_CONTROL: dict[str, Any] = {"low": -1.0, "high": 1.0, "control": True, "curve": True, "group": "expression", "preset": True}
_MAX_SCENE = 13 * 3600.0
"""Longest scene, in seconds."""
_ALONE = "A performer cannot listen in several ways.", "Give one of listen, turn and hears."
_BOTH = "Both a transcript file and a text were given.", "Give one of them."


@dataclass(frozen=True, kw_only=True)
class Affects:
    """The numbers of the setting ``affect``, -1..1 each, where 0 leaves the style as it is; each has a slider in Blender."""

    arousal: float = setting(
        0.0, **_CONTROL, label="Energy",
        tip="-1 sleepy: small, slow and low gestures; 1 excited: large, fast, frequent and high ones",
    )  # fmt: skip
    valence: float = setting(
        0.0, **_CONTROL, label="Mood",
        tip="-1 displeased: sluggish, arms low and closed; 1 pleased: livelier, hands lifted and open, chin up",
    )  # fmt: skip
    dominance: float = setting(
        0.0, **_CONTROL, label="Confidence",
        tip="-1 timid: narrow, hasty and unsteady; 1 in command: wide elbows, slower and steadier, long holds, upright",
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of a request, beside its recording.

    Words: ``transcript`` (a path) or ``text``; without either, gestures follow the sound alone. With ``recognise`` a speech
    recogniser writes the transcript, which needs the extra of that name.

    Style: ``style`` is an expression (:func:`styles.parse`), steered by ``affect`` (any of :data:`AFFECTS`), ``rate`` and
    ``hand``, -1..1 each. ``curves`` replace the number of a control or of ``intensity`` by points over time,
    ``{name: [[seconds, value], ...]}``, linear in between; ``changes`` are later styles, ``((seconds, style), ...)``.

    Identity: ``seed``, the number ``take`` of the first take, and the count ``takes``. ``near`` are the steps
    ``(number, spread)`` from a take to a variation of it; with ``spread`` (0..1, a share of the distance between takes) all
    takes are variations of that one, numbered from ``step`` (:func:`styles.take_identities`).
    ``chance`` is the recording whose random numbers a take has (:func:`audio.fingerprint`): None for the one that is heard, 0
    for none, so that seed and take alone matter, as in takes made before recordings had a part in it. ``latent``
    ``(steps, size)``, as in :class:`Result`, is a point of the latent space for each step of the style, instead of random
    ones. ``made_by`` is the hash of the checkpoint that made the take to be varied; the result has a warning if another
    checkpoint is used now.

    Conversation: with ``listen`` the recording is another speaker's, and the character listens to all of it; ``turn`` names
    the speaker of a transcript with names whose lines the character speaks, listening to the others; ``hears`` is the
    recording of another speaker of the same scene, which begins ``later`` seconds after this one (negative: before). That
    speaker stands ``toward`` degrees to the left.

    Constraints, as unit edge directions ``(9, 3)`` in the canonical frame: ``pose`` is the first frame (rest if None),
    ``end_pose`` the last, and ``kept`` a pair of frame numbers ``(n,)`` and directions ``(n, 9, 3)``; these frames are kept
    exactly, and the motion connects them."""

    transcript: str | PathLike | None = setting(
        None, kind="path", words=True, recording=True, column=True, cell=("sheet",), alternatives="words", conflict=_BOTH,
        metavar="FILE", label="Transcript", group="words", previewed=False,
        tip="Words of the recording: a text, subtitles, a TextGrid, or a .json of [word, start, end]; "
        "if empty, the transcript of the same name beside the recording",
        help="what is said: plain text, subtitles (SRT, WebVTT), TextGrid, CTM, or JSON of recognisers and aligners; by "
        "default a .txt, .srt, .vtt or .TextGrid of the recording's name beside it (see docs/transcripts.md)",
    )  # fmt: skip
    text: str | None = setting(
        None, kind="text", words=True, recording=True, column=True, cell=("sheet",), alternatives="words", conflict=_BOTH,
        metavar="WORDS", help="what is said, on the command line",
    )  # fmt: skip
    recognise: bool = setting(
        False, words=True, recording=True, column=True, cell=("sheet",),
        help="have the words recognised; needs the extra s2ag[recognise]",
    )  # fmt: skip
    style: str | dict = setting(
        "", kind="style", column=True, cell=("own",), restored=("arms", "take"), indexed=True, metavar="STYLE",
        help="NAME, a blend NAME:0.6+NAME:0.4, a walk NAME>NAME, or random (see: s2ag styles; default: the one marked there)",
        label="Style", short="Mixture", tip="A speaker, a blend such as calm lecturer:0.6+stern:0.4, or random",
        group="performer", preset=True,
    )  # fmt: skip
    seed: int = setting(
        0, low=0, wrong="Seed {} is negative.", remedy="Give zero or a positive whole number.", column=True, cell=("own",),
        meta="always", restored=("arms", "face", "take"), indexed=True, metavar="N",
        help="same seed, same performance (default 0)",
        label="Seed", tip="Same seed, same gestures", group="takes",
    )  # fmt: skip
    take: int = setting(0, column=True, cell=("own",), restored=("arms", "take"))
    takes: int = setting(
        1, low=1, high=64, wrong="{} takes were asked for.", remedy="Ask for 1 to 64.", column=True, cell=("own",),
        metavar="K", help="that many variations (default {default})",
        label="Takes", tip="How many variations to make in one go", rna="take_count", panel_high=16, previewed=False,
        group="takes",
    )  # fmt: skip
    chance: int | None = setting(
        None, kind="whole", low=0, wrong="Chance {} is negative.", remedy="Give zero or a positive whole number.", column=True,
        cell=("own",), meta="set", restored=("arms", "face", "take"), metavar="N",
        help="the chance of another take: the number in its provenance, 0 if there is none (default: the recording's own)",
    )  # fmt: skip
    intensity: float = setting(
        1.0, low=0.0, high=3.0, soft_high=1.5, curve=True, column=True, cell=("own", "sheet"), meta="always",
        restored=("arms",), metavar="X", help="size of the gestures (default 1)",
        label="Intensity", tip="How far gestures depart from rest", group="expression", preset=True,
    )  # fmt: skip
    affect: dict[str, float] = setting(
        dict, kind="affects", parts=Affects, control=True, column=True, cell=("own",), meta="always", restored=("arms", "face"),
        metavar="NAME=X",
        help="arousal, valence or dominance from -1 to 1, as in arousal=0.8; several with commas (see: s2ag styles)",
    )  # fmt: skip
    follow: float = setting(
        1.0, low=0.0, high=2.0, column=True, cell=("own", "sheet"), meta="set", restored=("arms", "face"), metavar="X",
        help="how far arousal, valence and dominance follow the voice, 0 to 2 (default 1); the numbers of --affect are added",
        label="Follow the Voice", short="Follow Voice", group="expression", preset=True,
        tip="How far energy, mood and confidence follow what is heard in the voice; their sliders are added, keyed ones win",
    )  # fmt: skip
    rate: float = setting(
        0.0, **_CONTROL, column=True, cell=("own",), meta="always", restored=("arms",),
        metavar="X", help="-1 fewer gestures, 1 more (default 0)",
        label="Rate", tip="-1 rests through most accents; 1 gestures on nearly every accent",
    )  # fmt: skip
    hand: float = setting(
        0.0, **_CONTROL, kind="side", column=True, cell=("own", "sheet"), meta="always", restored=("arms",),
        metavar="SIDE", help="left, right, or from -1 (left) to 1 (right); default 0: as the performer does",
        label="Handedness", tip="-1 prefers the left hand; 1 the right; 0 is the performer's own habit",
    )  # fmt: skip
    curves: dict[str, list] = setting(
        dict, kind="document", timed=True, column=True, cell=("own",), meta="set", restored=("arms",),
        metavar="FILE", help="controls, intensity and style over time: a JSON document of curves (see docs/directing.md)",
    )  # fmt: skip
    changes: tuple = setting((), kind="list", timed=True, meta="set", restored=("arms",))
    meaning: float = setting(
        1.0, low=0.0, high=1.0, column=True, cell=("own", "sheet"), meta="always", restored=("arms",), metavar="X",
        help='how readily phrases as in "I don\'t know" get gestures of their own, 0 to 1 (default 1: as the performer would)',
        label="Meaning", group="expression", preset=True,
        tip='How readily phrases such as "I don\'t know" get gestures of their own; 1 is as readily as the style would',
    )  # fmt: skip
    meanings: dict = setting(
        dict, kind="document", column=True, cell=("own",), meta="set", restored=("arms",), metavar="FILE",
        help="which words are shown by which gestures, instead of what is understood: a document as s2ag meaning prints it "
        "(see docs/meaning.md)",
        label="Meanings", group="expression", previewed=False,
        tip="Which words are shown by which gestures: a file as s2ag meaning prints it; "
        "if empty, what is understood of the words",
    )  # fmt: skip
    hands: float = setting(
        0.0, usual=1.0, low=0.0, high=1.0, wrong="Hands of {} are out of range.", column=True, meta="always",
        restored=("arms",), metavar="X",
        help="how much wrists and fingers live, from 0 (they follow the forearms) to 1 (default); the arms stay the same",
        label="Hand Motion", tip="How much wrists and fingers live; 0 leaves them to the forearms, and the arms are the same",
        group="expression", preset=True,
    )  # fmt: skip
    stance: float = setting(
        0.0, low=0.0, high=1.0, by_character=lambda name: float(name is None or characters.is_builtin(name)), empty=None,
        column=True, meta="always", restored=("arms",), beside_arms=True, metavar="X",
        help="how far weight goes from foot to foot, 0 to 1 (default 1, for a character of your own 0: its legs get no keys)",
        label="Stance", group="expression",
        tip="How far weight goes from foot to foot: keys pelvis and legs, which must be at rest; feet stay where they are",
    )  # fmt: skip
    face: float = setting(
        0.0, low=0.0, high=2.0, soft_high=1.5, wrong="Face of {} is out of range.", shown=1.0, column=True, heard=True,
        meta="set", by_character=lambda name: float(bool(name) and characters.is_builtin(name) and name != "mannequin"),
        restored=("face",), beside_arms=True, metavar="X",
        help="a speaking face: how far the mouth opens, 0 to 2 (--face alone: 1; default 0: none, 1 on human; docs/face.md)",
        label="Face Intensity", short="Intensity", tip="How far the mouth opens and brows rise",
        rna="face_intensity", switch="face", previewed=False, group="face",
    )  # fmt: skip
    face_smoothness: float = setting(
        0.5, low=0.0, high=1.0, wrong="A face's smoothness of {} is out of range.", column=True,
        metavar="X", help="how lazily lips move, 0 to 1 (default 0.5)",
        label="Face Smoothness", short="Smoothness", tip="How lazily lips move: closed lips close in any case",
        switch="face", previewed=False, group="face",
    )  # fmt: skip
    mirror: bool = setting(
        False, column=True, cell=("own", "sheet"), meta="always", restored=("arms", "face"), help="exchange left and right",
        label="Mirror", tip="Exchange left and right", group="expression", preset=True,
    )  # fmt: skip
    listen: bool = setting(
        False, recording=True, alternatives="listening", conflict=_ALONE, column=True, meta="set", restored=("arms",),
        help="the recording is somebody else's: listen to it, with nods and denials",
        label="Listen", group="expression",
        tip="The recording is somebody else's: listen to it, with nods and sometimes a denial as its phrases end",
    )  # fmt: skip
    turn: str = setting(
        "", recording=True, alternatives="listening", conflict=_ALONE, column=True, meta="set", restored=("arms", "face"),
        metavar="NAME", help="whose lines of a transcript with names to speak (ANNA: Hello.), listening to the others",
        label="Speaks As", longest=60, hidden_by="listen", group="talk",
        tip="Whose lines of a transcript with names the character speaks (ANNA: Hello.); it listens to the others",
    )  # fmt: skip
    hears: str | PathLike | None = setting(
        None, kind="path", recording=True, alternatives="listening", conflict=_ALONE, column=True, partner=True,
        metavar="FILE",
        help="the recording of another speaker, begun together with this one: listen to it between one's own turns",
    )  # fmt: skip
    later: float = setting(
        0.0, low=-_MAX_SCENE, high=_MAX_SCENE, wrong="The other recording begins {} s later.",
        remedy="Give seconds within the scene.",
        unit="seconds", recording=True, column=True, partner=True, meta="set", restored=("arms", "face"),
        metavar="S", help="seconds by which that one begins later (negative: earlier)",
    )  # fmt: skip
    toward: float = setting(
        0.0, low=-90.0, high=90.0, wrong="Nobody is seen at {} degrees.", remedy="Give -90 (right) to 90 (left).",
        unit="degrees", column=True, partner=True, meta="set", restored=("arms", "face"), metavar="DEGREES",
        help="degrees to the left at which the other one stands (negative: right), to be looked at in listening",
    )  # fmt: skip
    pose: "np.ndarray | None" = setting(None, kind="list")
    end_pose: "np.ndarray | None" = setting(None, kind="list")
    kept: tuple | None = setting(None, kind="list", timed=True)
    near: tuple = setting((), kind="list", restored=("take",))
    spread: float = setting(0.0)
    step: int = setting(1)
    latent: "np.ndarray | None" = setting(None, kind="points", parameter=False, column=True, cell=("own",), restored=("arms",))
    made_by: str = setting("")


@dataclass(frozen=True, kw_only=True)
class Models:
    """Models and cache of a :class:`session.Session`.

    Paths, or None for the shipped ones. ``language`` is a code such as ``de``; ``backend`` and ``device`` say what computes the
    network; ``cache`` is a folder, or "off"."""

    checkpoint: str | PathLike | None = setting(
        None, kind="path", column=True, metavar="FILE",
        help="trained network instead of the shipped one: a file (.safetensors), or a name such as published (docs/bench.md)",
        label="Gesture Model",
        tip="Another network to gesture with, a file or the name published; empty for the one that comes with the extension",
        group="advanced", previewed=False,
    )  # fmt: skip
    vectors: str | PathLike | None = setting(
        None, kind="path", column=True, metavar="FILE",
        help="word vectors (FastText or word2vec .bin, .vec) instead of the shipped ones",
    )  # fmt: skip
    language: str | None = setting(
        None, kind="text", column=True, metavar="CODE",
        help="language of the transcript, as in de; needs the extra s2ag[languages] (see docs/transcripts.md)",
        label="Language", tip="Code of the language of the words, such as de or fr; empty for English",
        group="advanced", longest=16, previewed=False,
    )  # fmt: skip
    aligner_model: str | PathLike | None = setting(
        None, kind="path", column=True, metavar="FOLDER",
        help="pronunciation, and perhaps sounds, of another language for placing words (see docs/transcripts.md)",
    )  # fmt: skip
    vocabulary: str | PathLike | None = setting(
        None, kind="path", column=True, metavar="FILE",
        help="gestures for words and phrases beside those that are known (JSON, see docs/transcripts.md)",
    )  # fmt: skip
    recogniser_model: str | PathLike | None = setting(
        None, kind="path", column=True, metavar="FOLDER",
        help="Whisper model for faster-whisper instead of the one in the extra s2ag[recognise]",
    )  # fmt: skip
    backend: str | None = setting(
        None, kind="text", column=True, choices=("numpy", "torch"), metavar="NAME",
        help="what computes the network: numpy, or torch (default: numpy where it can; torch needs the extra s2ag[full])",
    )  # fmt: skip
    device: str = setting("cpu", column=True, metavar="NAME", help="where torch computes it, as in cuda (default cpu)")
    cache: str | PathLike | None = setting(
        None, kind="text", metavar="FOLDER",
        help="where word times are kept for the next run instead of the user's cache folder; off keeps none",
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Documents:
    """Files applied to a finished motion; they are options and columns, but not part of a request."""

    rhubarb: str | None = setting(
        None, kind="path", column=True, metavar="FILE", after="face",
        help="with --face: the mouth by Rhubarb's cues (.tsv or .json, as rhubarb writes them) instead of by the words",
    )  # fmt: skip
    edits: str | None = setting(
        None, kind="path", column=True, metavar="FILE",
        help="what an animator changed in the take: a JSON document of edits (see docs/directing.md)",
    )  # fmt: skip


SWITCHES = {
    "face": (
        "Face",
        "Move lips, eyes and brows with the gestures: keys the shape keys of this character's meshes, if it has any that speak",
    )
}
"""Boolean properties in Blender that switch settings on: identifier -> label and tip."""
AFFECTS = tuple(table(Affects))
CONTROLS = (*AFFECTS, *(name for name, one in table(Settings).items() if one.control and not one.parts))
"""Names of the settings that steer the style, -1..1 each, in the network's order; 0 leaves the style as it is."""
CURVES = tuple(one.name for one in sliders(Settings) if one.curve)
"""Names of the settings that can change over time."""


def names_with(**about: object) -> tuple[str, ...]:
    """Return the names of the settings with these attributes, as in ``names_with(meta="set")``; of a tuple
    one element suffices, as in ``names_with(restored="face")``."""

    def fits(one: Setting, name: str, value: object) -> bool:
        own = getattr(one, name)
        return value in own if isinstance(own, tuple) else own == value

    return tuple(key for key, one in table(Settings).items() if all(fits(one, *pair) for pair in about.items()))


def checkpoint_of(options: Any) -> Any:
    """Return the checkpoint that the options of a command, a row of a manifest or a panel's settings name, or parameters of the
    worker (a mapping): a file or a name as for :func:`checkpoint_metadata.locate`, None or an empty text for the shipped one.
    """
    return options.get("checkpoint") if isinstance(options, Mapping) else options.checkpoint
