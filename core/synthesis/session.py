"""From a recording to motions, the path that the command line, the worker and scripts share.

:meth:`Session.synthesize_all` goes through its stages: hear (:mod:`features`), cast (:mod:`style_sequence`), draw
(:mod:`generation`), express and refine (:mod:`postprocess`)."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from ..errors import UsageError
from ..meaning import vocabulary as meanings
from ..words import language as languages
from ..words import transcript
from ..words.cache import Cache, default_folder
from . import features, generation, postprocess, style_sequence
from .features import SpeechFeatures
from .generation import GeneratedTakes
from .request import Request, Result
from .session_cache import SessionCache, recalled, recording_key, recording_settings
from .stages import Stages
from .style_sequence import StyleSequence


class Session:
    """A warm engine: loads checkpoint and word vectors when first needed and keeps them.

    With ``remember`` it also keeps the last recording as heard and the last performance as drawn, so that another style is not
    heard again and another intensity is not drawn again.

    ``language`` (as in ``de``), ``aligner_model`` and ``recogniser_model`` (folders) are for another language, whose words mean
    nothing to the network unless ``vectors`` are given, too: its own are English. Word times are kept in the folder ``cache``,
    by default the user's (:func:`cache.default_folder`), and not at all if it is "off". ``backend`` and ``device`` say what
    computes the network (:func:`loading.load`). ``vocabulary`` is a file of more gestures for words and phrases
    (:mod:`vocabulary`)."""

    def __init__(
        self, checkpoint: str | PathLike | None = None, vectors: str | PathLike | None = None, device: str = "cpu",
        remember: bool = False, aligner_model: str | PathLike | None = None, recogniser_model: str | PathLike | None = None,
        cache: str | PathLike | None = None, language: str | None = None, vocabulary: str | PathLike | None = None,
        backend: str | None = None
    ) -> None:  # fmt: skip
        self._checkpoint_path, self._vectors_path = checkpoint, vectors
        self._backend, self._device = backend, device
        folder = default_folder() if cache is None else None if str(cache) == "off" else cache
        self._word_options = transcript.TranscriptOptions(
            Cache(folder), languages.load_language(aligner_model, language), False, recogniser_model
        )
        self.reads = language if languages.is_foreign(self._word_options.model) else None
        self.understands = vectors is not None or self.reads is None
        self._checkpoint: Any = None
        self._vectors: Any = None
        self.vocabulary = meanings.load_vocabulary(vocabulary)
        self._memory = SessionCache() if remember else None

    @property
    def checkpoint(self) -> Any:
        """The :class:`loaded_checkpoint.LoadedCheckpoint` network."""
        if self._checkpoint is None:
            from ..model import loading

            self._checkpoint = loading.load(self._checkpoint_path, self._backend, self._device)
        return self._checkpoint

    @property
    def vectors(self) -> Any:
        """The loaded :class:`table.WordVectors`."""
        if self._vectors is None:
            from ..vectors.table import WordVectors

            self._vectors = WordVectors.load(self._vectors_path)
        return self._vectors

    def words(self, sound: np.ndarray, request: Request, progress: Callable | None = None) -> transcript.TimedTranscript:
        """Return what is said in a recording ``(n,)`` at 16 kHz (:func:`transcript.timed_transcript`)."""
        options = replace(self._word_options, recognise=request.recognise)
        return transcript.timed_transcript(sound, *request.words_from, progress, options)

    def remember(self) -> None:
        """Keep the last recording and the last performance from now on."""
        self._memory = self._memory or SessionCache()

    def styles(self) -> list[dict]:
        """Return names and descriptions of the checkpoint's speakers."""
        return list(self.checkpoint.speakers)

    def warm_up(self) -> None:
        """Load all that a first request would load."""
        if not self.checkpoint.config.words:
            self.vectors  # noqa: B018

    def synthesize(
        self, request: Request, progress: Callable[[str, float], None] = lambda stage, value: None,
        cancelled: Callable[[], bool] = lambda: False
    ) -> Result:  # fmt: skip
        """Make ``request.takes`` motions. Same request, seed and checkpoint: the same result.

        ``progress(stage, value)`` is called with stages and 0..1 within them, ``cancelled()`` often. Raises
        :class:`Cancelled`, and subclasses of :class:`S2agError` for everything that a user can correct."""
        return self.synthesize_all([request], progress, cancelled)[0]

    def synthesize_all(
        self, requests: Sequence[Request], progress: Callable[[str, float], None] = lambda stage, value: None,
        cancelled: Callable[[], bool] = lambda: False
    ) -> list[Result]:  # fmt: skip
        """Make several performances of one recording, which is heard once and drawn in one batch; results as of single ones.

        Raises what :meth:`synthesize` raises, and :class:`UsageError` where the recordings or transcripts differ."""
        if len(set(map(recording_settings, requests))) != 1:
            raise UsageError("The requests are not about one recording.", "Make those of other recordings one by one.")
        stages, memory = Stages(progress, cancelled), self._memory or SessionCache()
        recording = recording_key(requests[0])
        heard, cast = self._hear(requests, recalled(memory.heard, recording), stages)
        missed = [postprocess.wanted_gestures(one, heard)[1] for one in requests]
        drawn = self._draw(heard, cast, recording, memory, stages)
        results = []
        for performers, takes, unsaid in zip(cast, drawn.split([len(one.latents) for one in cast]), missed, strict=True):
            motions = stages.run("finish", partial(postprocess.express, self.checkpoint, heard, performers, takes))
            warnings = heard.warnings + unsaid + _other_weights(self.checkpoint, performers.request)
            warnings += _skipped_hints(heard, performers)
            results.append(Result(motions, heard.words, warnings, dict(stages.seconds), performers.own))
        return results

    def hear(self, request: Request, stages: Stages) -> tuple[SpeechFeatures, StyleSequence]:
        """Return a recording as its performers hear it, and the performers; the recording is remembered."""
        memory, recording = self._memory or SessionCache(), recording_key(request)
        heard, cast = self._hear([request], recalled(memory.heard, recording), stages)
        memory.heard = recording, heard
        return heard, cast[0]

    def _hear(
        self, requests: Sequence[Request], known: SpeechFeatures | None, stages: Stages
    ) -> tuple[SpeechFeatures, list[StyleSequence]]:
        """Hear the recording unless it is ``known``, and cast the performers of each request."""
        from ..sound import audio

        sound = None if known is not None else stages.run("read audio", lambda: audio.load(requests[0].audio))
        checkpoint = stages.run("load model", lambda: self.checkpoint)
        # Cast before anything long, because that complains of unknown styles.
        for request in requests:
            style_sequence.from_request(checkpoint, request)
        if sound is not None:
            known = features.hear(self, requests[0], sound, stages)
        assert known is not None
        heard, hinted = replace(known, seconds=stages.seconds), known.wishes.styles
        keyed = (replace(one, chance=known.chance) if one.chance is None else one for one in requests)
        return heard, [style_sequence.from_request(checkpoint, one, hinted, known.affect) for one in keyed]

    def _draw(
        self, heard: SpeechFeatures, cast: list[StyleSequence], recording: tuple, memory: SessionCache, stages: Stages
    ) -> GeneratedTakes:
        """Draw the takes of all performers in one batch, unless they are remembered."""
        key = recording, *generation.cache_key(self.checkpoint, heard, cast)
        drawn = recalled(memory.made, key)
        if drawn is None:
            callbacks = stages.within("generate"), stages.cancelled
            drawn = stages.run("generate", lambda: generation.generate(self.checkpoint, heard, cast, *callbacks))
        memory.heard, memory.made = (recording, heard), (key, drawn)
        return drawn


def _other_weights(checkpoint: Any, request: Request) -> list[str]:
    """Return a warning where more of a take is wanted than these weights can give."""
    if request.made_by in ("", checkpoint.hash):
        return []
    return ["The take was made by earlier weights and cannot be made again by these: what is new shares its style alone."]


def _skipped_hints(heard: SpeechFeatures, performers: StyleSequence) -> list[str]:
    """Return a warning where words begin styles, but the style of the request is a walk."""
    style, hinted = performers.request.sequence, dict.fromkeys(style or "usual" for _, style in heard.wishes.styles)
    if not hinted or not style:
        return []
    hints = ", ".join(f"{{as {name}}}" for name in hinted)
    return [f"The style {style} changes on the way by itself: {hints} of the transcript is left out."]
