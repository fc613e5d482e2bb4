"""A recording as performers hear it: all that does not depend on style, pose or seed."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .. import styles
from ..errors import UnknownStyle, UsageError
from ..face import making
from ..meaning.vocabulary import Vocabulary
from ..motion import skeleton
from ..sound import prosody
from ..threads import ahead
from ..words import hints, transcript, turns
from . import asking
from .request import Request
from .stages import Stages


@dataclass(frozen=True)
class Others:
    """Another voice: its ``phrases`` ``(p, 2)`` in seconds, and how much a performer listens to it, ``share`` ``(frames,)``.

    ``digest`` names it (:func:`audio.digest`).
    """

    phrases: np.ndarray
    share: np.ndarray
    digest: str


@dataclass(frozen=True)
class Heard:
    """A recording as performers hear it: digest, words, wishes, warnings, features, voice activity, frames, seconds spent.

    ``shows``: what of the words a performer could show by gestures of their own.
    ``features`` are :class:`VectorFeatures`, or :class:`TableFeatures` for an imported network. ``spoken`` is what a face
    needs, None where none is wanted. ``others`` are whom the performer listens to, if anybody. ``rhythm`` is
    what networks that hear prosody hear of it.
    """

    digest: str
    words: tuple
    wishes: hints.Wishes
    shows: Vocabulary | None
    warnings: list[str]
    features: object
    activity: np.ndarray
    frames: int
    seconds: dict[str, float]
    spoken: making.Spoken | None = None
    others: Others | None = None
    rhythm: prosody.Prosody | None = None


def hear(session, request: Request, sound: np.ndarray, stages: Stages) -> Heard:
    """Words, pauses and features of ``sound`` ``(n,)`` at 16 kHz, as the session's network wants them."""
    from ..sound import audio

    named, sound, other = audio.digest(sound), *_voices(request, sound)
    # While the words are found by another process, this one works out what does not hang on them.
    with ahead(*(() if request.turn else _measuring(session.checkpoint.config, sound))) as begun:
        if request.listen:
            said = transcript.Heard()  # the words are not the performer's
        else:
            said = stages.run("align words", lambda: session.words(sound, request, stages.within("align words")))
        measuring = [one.result for one in begun]
        if request.turn:
            said, spans = turns.own(said, _text(request), request.turn)
            sound, other = _apart(sound, spans)
            measuring = _measuring(session.checkpoint.config, sound)
        return _heard(session, request, stages, named, said, sound, other, measuring)


def _heard(session, request: Request, stages: Stages, named: str, said, sound, other, measuring: list[Callable]) -> Heard:
    """What is heard of the words ``said`` and the sounds; ``measuring`` gives what :func:`_measuring` does."""
    from ..sound import audio, voice

    words, wishes = said.words, hints.understand(said.marks, said.words)
    wishes, strange = _styled(wishes, session.checkpoint.speakers)
    warnings = said.warnings + _unknown(wishes) + strange
    unheard = not words or session.checkpoint.config.words
    vectors = None if unheard else stages.run("load word vectors", lambda: session.vectors)
    frames = max(int(len(sound) / audio.SAMPLE_RATE * skeleton.FPS), 2)
    told = hints.heard(words, wishes, session.understands, asking.asked(wishes, session.checkpoint.meanings))

    def features():
        if session.checkpoint.config.words:
            return _published(session.checkpoint, sound, told, warnings), None, voice.probability(sound)
        from ..model.vector_features import VectorFeatures
        from ..sound import prosody

        mfcc, tracks = (measured() for measured in measuring)
        if not isinstance(tracks, prosody.Tracks):
            return VectorFeatures(mfcc, told, vectors, None), None, tracks
        rhythm = prosody.analyse(sound, words, frames, wishes.stressed, tracks)
        return VectorFeatures(mfcc, told, vectors, rhythm.features), rhythm, tracks.voice

    features, rhythm, voiced = stages.run("extract MFCC", features)
    spoken = stages.run("hear sounds", lambda: making.hear(sound, words, said.phones, rhythm)) if request.face else None
    own = voice.frame_count(sound)
    activity = stages.run("find pauses", lambda: _fit(voice.in_frames(voiced, own), frames))
    shows = session.vocabulary if session.understands and words else None
    others = None if other is None else stages.run("listen", lambda: _listened(other, activity))
    heard = Heard(named, words, wishes, shows, warnings, features, activity, frames, stages.seconds, spoken, others)
    return replace(heard, rhythm=rhythm)


def _measuring(config, sound: np.ndarray) -> list[Callable]:
    """What works out MFCCs, and prosody without words or, for a network that hears none, how much is voice; none of it for an
    imported network.
    """
    from ..sound import mfcc, prosody, voice

    if config.words:
        return []
    tracks = prosody.measure if config.prosody_features else voice.probability
    return [lambda: mfcc.temporal_features(sound), lambda: tracks(sound)]


def _voices(request: Request, sound: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """The performer's own voice and the one that it listens to, if any, equally long."""
    if request.listen:
        return np.zeros_like(sound), sound
    if request.hears is None:
        return sound, None
    from ..sound import audio

    other, shift = audio.load(request.hears), round(request.later * audio.SAMPLE_RATE)
    other = np.pad(other[max(-shift, 0) :], (max(shift, 0), 0))
    length = max(len(sound), len(other))
    return tuple(np.pad(one, (0, length - len(one))) for one in (sound, other))


def _text(request: Request) -> str:
    """The text with names."""
    if request.text is not None:
        return request.text
    if request.transcript is None:
        raise UsageError(
            "Turns need a transcript with names.", 'Write names in capitals before what is said, as in "ANNA: Hello."'
        )
    return transcript.read(request.transcript)


def _apart(sound: np.ndarray, spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A recording without what others say, and without what is said in ``spans`` ``(n, 2)`` of seconds."""
    from ..sound.audio import SAMPLE_RATE

    own = np.zeros(len(sound), bool)
    for start, end in spans:
        own[int(start * SAMPLE_RATE) : int(np.ceil(min(end * SAMPLE_RATE, len(sound))))] = True
    return np.where(own, sound, 0).astype(np.float32), np.where(own, 0, sound).astype(np.float32)


def _listened(other: np.ndarray, activity: np.ndarray) -> Others:
    """What is to be known of another voice where the performer's own has this ``activity`` ``(frames,)``."""
    from ..sound import audio, prosody

    return Others(prosody.analyse(other).phrases, 1 - np.clip(activity, 0, 1), audio.digest(other))


def _published(checkpoint, sound: np.ndarray, words: tuple, warnings: list[str]):
    """What an imported network hears."""
    from ..model.table_words import TableFeatures

    vocabulary = checkpoint.meta.get("vocabulary")
    if words and not vocabulary:
        warnings.append("This checkpoint was imported without its vocabulary, so its gestures do not follow the words.")
    return TableFeatures(sound, words, vocabulary, checkpoint.config)


def _unknown(wishes: hints.Wishes) -> list[str]:
    if not wishes.unknown:
        return []
    names = ", ".join(f"{{{name}}}" for name in wishes.unknown[:3])
    return [f"The transcript's hint {names} is not one that gestures know; it is left out (docs/transcripts.md lists them)."]


def _styled(wishes: hints.Wishes, speakers: list[dict]) -> tuple[hints.Wishes, list[str]]:
    """Wishes without styles that nobody knows, and what to say of those."""
    names, known, strange = [speaker["name"] for speaker in speakers], [], []
    for at, style in wishes.styles:
        try:
            styles.parse(style or styles.default(speakers), names)
            known.append((at, style))
        except UnknownStyle as error:
            strange.append(f"The transcript's hint {{as {style}}} is left out: {error}")
    return (replace(wishes, styles=tuple(known)) if strange else wishes), strange


def _fit(values: np.ndarray, frames: int) -> np.ndarray:
    return np.pad(values[:frames], (0, max(frames - len(values), 0)), mode="edge" if len(values) else "constant")
