"""A recording as performers hear it: all that does not depend on style, pose or seed."""

from dataclasses import dataclass, replace

import numpy as np

from .. import styles
from ..errors import UnknownStyle
from ..face import making
from ..meaning.vocabulary import Vocabulary
from ..motion import skeleton
from ..words import hints
from . import asking
from .request import Request
from .stages import Stages


@dataclass(frozen=True)
class Heard:
    """A recording as performers hear it: digest, words, wishes, warnings, features, voice activity, frames, seconds spent.

    ``shows``: what of the words a performer could show by gestures of their own.
    ``features`` are :class:`VectorFeatures`, or :class:`TableFeatures` for an imported network. ``spoken`` is what a face
    needs, None where none is wanted.
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


def hear(session, request: Request, sound: np.ndarray, stages: Stages) -> Heard:
    """Words, pauses and features of ``sound`` ``(n,)`` at 16 kHz, as the session's network wants them."""
    from ..sound import audio, voice

    said = stages.run("align words", lambda: session.words(sound, request, stages.within("align words")))
    words, wishes = said.words, hints.understand(said.marks, said.words)
    wishes, strange = _styled(wishes, session.checkpoint.speakers)
    warnings = said.warnings + _unknown(wishes) + strange
    unheard = not words or session.checkpoint.config.words
    vectors = None if unheard else stages.run("load word vectors", lambda: session.vectors)
    frames = max(int(len(sound) / audio.SAMPLE_RATE * skeleton.FPS), 2)
    told = hints.heard(words, wishes, session.understands, asking.asked(wishes, session.checkpoint.meanings))
    stressed = wishes.stressed

    def features():
        if session.checkpoint.config.words:
            return _published(session.checkpoint, sound, told, warnings), None
        from ..model.vector_features import VectorFeatures

        rhythm = _prosody(session.checkpoint.config, sound, words, frames, stressed)
        return VectorFeatures(sound, told, vectors, rhythm and rhythm.features), rhythm

    features, rhythm = stages.run("extract MFCC", features)
    spoken = stages.run("hear sounds", lambda: making.hear(sound, words, said.phones, rhythm)) if request.face else None
    activity = stages.run("find pauses", lambda: _fit(voice.active(sound), frames))
    shows = session.vocabulary if session.understands and words else None
    return Heard(audio.digest(sound), words, wishes, shows, warnings, features, activity, frames, stages.seconds, spoken)


def _published(checkpoint, sound: np.ndarray, words: tuple, warnings: list[str]):
    """What an imported network hears."""
    from ..model.table_words import TableFeatures

    vocabulary = checkpoint.meta.get("vocabulary")
    if words and not vocabulary:
        warnings.append("This checkpoint was imported without its vocabulary, so its gestures do not follow the words.")
    return TableFeatures(sound, words, vocabulary, checkpoint.config)


def _prosody(config, sound: np.ndarray, words: tuple, frames: int, stressed):
    if not config.prosody_features:
        return None
    from ..sound import prosody

    return prosody.analyse(sound, words, frames, stressed)


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
