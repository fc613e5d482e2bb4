"""From a recording to motions: the one path that the command line, the worker and scripts share."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from os import PathLike

import numpy as np

from .. import styles
from ..errors import UsageError
from ..meaning import vocabulary as meanings
from ..motion.motion import Motion
from ..words import language as languages
from ..words import transcript
from ..words.cache import Cache, default_folder
from . import casting, finishing, hearing, performing
from .memory import Memory, signature
from .memory import recording as recording_of
from .request import Request, Result
from .stages import Stages


class Session:
    """A warm engine: loads the checkpoint and the word vectors when first needed and keeps them.

    With ``remember`` it also keeps the last recording as heard and the last performance as generated, so that another
    style is not heard again and another intensity is not generated again.

    ``language`` (as in ``de``), ``aligner_model`` and ``recogniser_model`` (folders) are for another language, whose words say
    nothing to the network unless ``vectors`` are given too: its own are English. Word times are kept in the folder ``cache``,
    by default the user's (:func:`cache.default_folder`), and not at all if it is "off". ``backend`` and ``device`` say what
    computes the network (:func:`opening.load`). ``vocabulary`` is a file of gestures for words and phrases beside those that
    are known (:mod:`vocabulary`).
    """

    def __init__(
        self,
        checkpoint: str | PathLike | None = None,
        vectors: str | PathLike | None = None,
        device: str = "cpu",
        remember: bool = False,
        aligner_model: str | PathLike | None = None,
        recogniser_model: str | PathLike | None = None,
        cache: str | PathLike | None = None,
        language: str | None = None,
        vocabulary: str | PathLike | None = None,
        backend: str | None = None,
    ):
        self._paths = checkpoint, vectors
        self._where = backend, device
        folder = default_folder() if cache is None else None if str(cache) == "off" else cache
        self._ways = transcript.Ways(Cache(folder), languages.load(aligner_model, language), False, recogniser_model)
        self.understands = vectors is not None or not languages.foreign(self._ways.model)
        self._checkpoint = self._vectors = None
        self.vocabulary = meanings.load(vocabulary)
        self._memory = Memory() if remember else None

    @property
    def checkpoint(self):
        """The :class:`loaded.Loaded` network."""
        if self._checkpoint is None:
            from ..model import opening

            self._checkpoint = opening.load(self._paths[0], *self._where)
        return self._checkpoint

    @property
    def vectors(self):
        """The loaded :class:`words.WordVectors`."""
        if self._vectors is None:
            from ..vectors.table import WordVectors

            self._vectors = WordVectors.load(self._paths[1])
        return self._vectors

    def words(self, sound: np.ndarray, request: Request, progress=None) -> transcript.Heard:
        """What is said in a recording ``(n,)`` at 16 kHz; see :func:`transcript.hear`."""
        ways = replace(self._ways, recognise=request.recognise)
        return transcript.hear(sound, request.transcript, request.text, progress, ways)

    def remember(self) -> None:
        """Keep the last recording and the last performance from now on."""
        self._memory = self._memory or Memory()

    def styles(self) -> list[dict]:
        """Names and descriptions of the checkpoint's speakers."""
        return list(self.checkpoint.speakers)

    def warm_up(self) -> None:
        """Load all that a first request would load."""
        if not self.checkpoint.config.words:
            self.vectors  # noqa: B018

    def synthesize(
        self,
        request: Request,
        progress: Callable[[str, float], None] = lambda stage, value: None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> Result:
        """Make ``request.takes`` motions. Same request, seed and checkpoint: the same result.

        ``progress(stage, value)`` hears of stages and of 0..1 within them; ``cancelled()`` is asked often and raises
        :class:`Cancelled`. Raises subclasses of :class:`S2agError` for everything a user can mend.
        """
        return self.synthesize_all([request], progress, cancelled)[0]

    def synthesize_all(
        self,
        requests: Sequence[Request],
        progress: Callable[[str, float], None] = lambda stage, value: None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> list[Result]:
        """Several performances of one recording, heard once and generated in one batch: faster, and as good as the same.

        Raises what :meth:`synthesize` raises, and :class:`UsageError` where the recordings or transcripts differ.
        """
        if len(set(map(recording_of, requests))) != 1:
            raise UsageError("The requests are not about one recording.", "Make those of other recordings one by one.")
        stages, memory = Stages(progress, cancelled), self._memory or Memory()
        recording = signature(requests[0])
        heard, cast = self._heard(requests, memory.heard(recording), stages)
        made = self._made(heard, cast, recording, memory, stages)
        return [self._result(*one, heard, stages) for one in zip(requests, cast, made, strict=True)]

    def hear(self, request: Request, stages: Stages) -> tuple[hearing.Heard, casting.Performers]:
        """A recording as its performers hear it, and they; remembered as performances are."""
        memory, recording = self._memory or Memory(), signature(request)
        heard, cast = self._heard([request], memory.heard(recording), stages)
        memory.keep_heard(recording, heard)
        return heard, cast[0]

    def _heard(self, requests: Sequence[Request], known: hearing.Heard | None, stages: Stages) -> tuple:
        """What is heard, unless it is ``known``, and who performs each of the requests."""
        from ..sound import audio

        sound = stages.run("read audio", lambda: audio.load(requests[0].audio)) if known is None else None
        checkpoint = stages.run("load model", lambda: self.checkpoint)
        # Before anything long: it complains of unknown styles.
        cast = [casting.cast(checkpoint, request) for request in requests]
        heard = hearing.hear(self, requests[0], sound, stages) if known is None else replace(known, seconds=stages.seconds)
        told = heard.wishes.styles
        return heard, [casting.cast(checkpoint, one, told) for one in requests] if told else cast

    def _made(
        self, heard, cast: list[casting.Performers], recording: tuple, memory: Memory, stages: Stages
    ) -> list[performing.Made]:
        """What each of the performers makes, all of it made in one batch or remembered."""
        performers = recording, *performing.known_by(self.checkpoint, heard, cast)
        made = memory.made(performers)
        if made is None:
            told = stages.within("generate"), stages.cancelled
            made = stages.run("generate", lambda: performing.perform(self.checkpoint, heard, cast, *told))
        memory.keep(recording, heard, performers, made)
        return made.split([len(one.latents) for one in cast])

    def _result(self, request: Request, performers: casting.Performers, made: performing.Made, heard, stages: Stages) -> Result:
        def finish() -> list[Motion]:
            refined = finishing.correct(self.checkpoint, heard, performers, made)
            return finishing.express(self.checkpoint, heard, performers, refined)

        motions = stages.run("finish", finish)
        warnings = heard.warnings + _other_weights(self.checkpoint, request) + _passed_by(heard, request)
        return Result(motions, heard.words, warnings, dict(stages.seconds), performers.own)


def _other_weights(checkpoint, request: Request) -> list[str]:
    """What to say where more of a take is wanted than these weights can give."""
    if request.made_by in ("", checkpoint.hash):
        return []
    return ["The take was made by earlier weights and cannot be made again by these: what is new shares its style alone."]


def _passed_by(heard: hearing.Heard, request: Request) -> list[str]:
    """What to say where words begin styles and the style asked for is a walk, which changes by itself."""
    named = dict.fromkeys(style or "usual" for _, style in heard.wishes.styles)
    if not named or len(styles.steps(request.style)) < 2:
        return []
    hints = ", ".join(f"{{as {name}}}" for name in named)
    return [f"The style {request.style} changes on the way by itself: {hints} of the transcript is left out."]
