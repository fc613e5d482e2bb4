"""The stage *hear*: everything of a recording that does not depend on style, pose or seed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from .. import styles
from ..errors import UnknownStyle
from ..face import animation
from ..meaning import gesture_selection
from ..meaning.document import Wanted
from ..meaning.vocabulary import Vocabulary
from ..motion import skeleton
from ..sound import affect, prosody, speech_units
from ..threads import run_in_background
from ..vectors.table import SHIPPED
from ..words import hints, speaker_turns, transcript
from . import stroke_conditions
from .request import Request
from .stages import Stages


@dataclass(frozen=True)
class OtherVoice:
    """Another speaker's voice: its ``phrases`` ``(p, 2)`` in seconds, how far the performer listens to it, ``share``
    ``(frames,)`` in 0..1, the ``digest`` of the recording (:func:`audio.digest`), and its ``words`` where a text tells them."""

    phrases: np.ndarray
    share: np.ndarray
    digest: str
    words: Sequence[tuple] = ()


class Features(Protocol):
    """What a network hears: :class:`VectorFeatures`, or :class:`TableFeatures` for an imported network."""

    def slice(self, start: int, stop: int, /) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return MFCCs, words and prosody of the frames ``start`` to ``stop``."""
        ...


@dataclass(frozen=True)
class SpeechFeatures:
    """A recording as performers hear it.

    ``words`` are (word, start, end); ``wishes`` the marks between them; ``shows`` the vocabulary of gestures, None without
    words, and ``occasions`` what they call for (:func:`gesture_selection.find_occasions`); ``activity`` ``(frames,)`` in 0..1
    where the performer's voice is. ``spoken`` is what a face needs, None without a face; ``others`` the other speaker, if
    any; ``rhythm`` prosody and accents, None for networks that hear none; ``affect`` ``(frames, 3)`` (:func:`affect.hear`),
    None for networks whose controls do not follow it. ``chance`` keys the random numbers of performances. ``seconds`` are
    durations of the stages so far."""

    digest: str
    words: tuple
    wishes: hints.HintEffects
    shows: Vocabulary | None
    warnings: list[str]
    features: Features
    activity: np.ndarray
    frames: int
    seconds: dict[str, float]
    spoken: animation.FaceSpeech | None = None
    others: OtherVoice | None = None
    rhythm: prosody.Prosody | None = None
    chance: int = 0
    affect: np.ndarray | None = None
    occasions: dict[int, Wanted] = field(default_factory=dict)


def hear(session: Any, request: Request, sound: np.ndarray, stages: Stages) -> SpeechFeatures:
    """Return words, pauses and features of ``sound`` ``(n,)`` at 16 kHz, as the network of the :class:`Session` wants them."""
    from ..sound import audio

    part = f"{request.turn.casefold()} {request.listen}" if request.turn or request.listen else ""
    named, chance, (sound, other) = audio.digest(sound), audio.fingerprint(sound, part), _voices(request, sound)
    # While another process aligns the words, this one measures what does not depend on them.
    measured = [] if request.turn else run_in_background(*_measurements(session.checkpoint, sound))
    said, theirs, voice = transcript.TimedTranscript(), (), other if request.listen else sound
    if not request.listen or any(request.words_from):
        said = stages.run("align words", lambda: session.words(voice, request, stages.within("align words")))
    if request.listen:  # the words are not the performer's
        said, theirs = transcript.TimedTranscript(warnings=said.warnings), said.words
    if request.turn:
        theirs = said.words
        said, spans = speaker_turns.words_of_speaker(said, *request.words_from, request.turn)
        theirs = [one for one in theirs if one not in said.words]
        sound, other = _separate(sound, spans)
        measured = run_in_background(*_measurements(session.checkpoint, sound))
    return replace(_assemble(session, request, stages, named, said, (sound, other, theirs), measured), chance=chance)


def _assemble(
    session: Any, request: Request, stages: Stages, named: str, said: Any, sounds: tuple, measured: list[Callable]
) -> SpeechFeatures:
    """Put together what is heard of the words ``said`` and of ``sounds``: both voices and the other's words."""
    from ..sound import audio, voice_activity

    sound, other, theirs = sounds
    words, wishes = said.words, hints.parse_hints(said.marks, said.words)
    wishes, style_warnings = _known_styles(wishes, session.checkpoint.speakers, session.checkpoint.hash)
    names = ", ".join(f"{{{name}}}" for name in wishes.unknown[:3])
    strange = [f"The transcript's hint {names} is not one that gestures know; it is left out (docs/transcripts.md lists them)."]
    warnings = said.warnings + (strange if names else []) + style_warnings
    unheard = not words or session.checkpoint.config.words
    vectors = None if unheard else stages.run("load word vectors", lambda: session.vectors)
    frames = max(int(len(sound) / audio.SAMPLE_RATE * skeleton.FPS), 2)
    known = hints.network_words(
        words, wishes, session.understands, stroke_conditions.conditioned_words(wishes, session.checkpoint.meanings)
    )

    def extract() -> tuple[Features, prosody.Prosody | None, np.ndarray]:
        if session.checkpoint.config.words:
            from ..model.table_features import TableFeatures

            tabled = TableFeatures.of(session.checkpoint, sound, known, warnings)
            return tabled, None, voice_activity.probability(sound)
        from ..model.vector_features import VectorFeatures

        mfcc, tracks = (result() for result in measured[:2])
        if not isinstance(tracks, prosody.Tracks):
            return VectorFeatures(mfcc, known, vectors, None), None, tracks
        rhythm = prosody.analyse(sound, words, frames, wishes.stressed, tracks)
        return VectorFeatures(mfcc, known, vectors, rhythm.features), rhythm, tracks.voice

    features, rhythm, voiced = stages.run("extract MFCC", extract)
    spoken = stages.run("hear sounds", lambda: animation.analyse(sound, words, said.phones, rhythm)) if request.face else None
    own = voice_activity.frame_count(sound)
    activity = stages.run("find pauses", lambda: _fit(voice_activity.fraction_per_frame(voiced, own), frames))
    shows = session.vocabulary if words else None
    others = None if other is None else stages.run("listen", lambda: _other_voice(other, activity, theirs))
    heard = SpeechFeatures(named, words, wishes, shows, warnings, features, activity, frames, stages.seconds, spoken, others)
    written = [(text, *times) for text, (_, *times) in zip(said.written, words, strict=True)]
    occasions = gesture_selection.find_occasions(session.vocabulary, written, session.reads)
    heard = replace(heard, rhythm=rhythm, occasions=occasions)
    if not session.checkpoint.hears_affect:
        return heard
    said = (words, vectors) if vectors is not None and session.understands and vectors.name == SHIPPED.name else ()
    feels = stages.run("hear affect", lambda: affect.hear(measured[2](), frames, *said))
    return replace(heard, affect=feels)


def _measurements(checkpoint: Any, sound: np.ndarray) -> list[Callable]:
    """Return functions that measure MFCCs, prosody without words (for a network that hears none, the share of voice), and
    units of speech for one that hears affect; none for an imported network."""
    from ..sound import mfcc, voice_activity

    config = checkpoint.config
    if config.words:
        return []
    tracks = prosody.measure if config.prosody_features else voice_activity.probability
    affects = [lambda: speech_units.measure(sound)] if checkpoint.hears_affect else []
    return [lambda: mfcc.temporal_features(sound), lambda: tracks(sound), *affects]


def _voices(request: Request, sound: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the performer's own voice and the one that it listens to, if any, equally long."""
    if request.listen:
        return np.zeros_like(sound), sound
    if request.hears is None:
        return sound, None
    from ..sound import audio

    other, shift = audio.load(request.hears), round(request.later * audio.SAMPLE_RATE)
    other = np.pad(other[max(-shift, 0) :], (max(shift, 0), 0))
    length = max(len(sound), len(other))
    return np.pad(sound, (0, length - len(sound))), np.pad(other, (0, length - len(other)))


def _separate(sound: np.ndarray, spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split a recording into what is said in ``spans`` ``(n, 2)`` of seconds and the rest, both equally long."""
    from ..sound.audio import SAMPLE_RATE

    own = np.zeros(len(sound), bool)
    for start, end in spans:
        own[int(start * SAMPLE_RATE) : int(np.ceil(min(end * SAMPLE_RATE, len(sound))))] = True
    return np.where(own, sound, 0).astype(np.float32), np.where(own, 0, sound).astype(np.float32)


def _other_voice(other: np.ndarray, activity: np.ndarray, words: Sequence) -> OtherVoice:
    """Analyse another voice; the performer listens where its own voice has little ``activity`` ``(frames,)``."""
    from ..sound import audio

    return OtherVoice(prosody.analyse(other).phrases, 1 - np.clip(activity, 0, 1), audio.digest(other), words)


def _known_styles(wishes: hints.HintEffects, speakers: list[dict], weights: str) -> tuple[hints.HintEffects, list[str]]:
    """Return wishes without styles that do not exist, and a warning for each of those."""
    known, warnings = [], []
    for at, style in wishes.styles:
        try:
            step = style or styles.default_speaker(speakers)
            styles.parse(step, [one["name"] for one in styles.performers(speakers, [step], weights)])
            known.append((at, style))
        except UnknownStyle as error:
            warnings.append(f"The transcript's hint {{as {style}}} is left out: {error}")
    return (replace(wishes, styles=tuple(known)) if warnings else wishes), warnings


def _fit(values: np.ndarray, frames: int) -> np.ndarray:
    return np.pad(values[:frames], (0, max(frames - len(values), 0)), mode="edge" if len(values) else "constant")
