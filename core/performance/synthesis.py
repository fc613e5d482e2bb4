"""From a recording to motions: the one path that the command line, the worker and scripts share."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from os import PathLike

import numpy as np

from .. import styles
from ..errors import Cancelled, UsageError
from ..motion import limits, rest, skeleton
from ..motion.motion import Motion
from ..words import hints, transcript
from ..words import language as languages
from ..words.cache import Cache, default_folder
from .memory import Memory, signature
from .request import Request, Result

VERSION = 1  # of the provenance written into every motion


class Session:
    """A warm engine: loads the checkpoint and the word vectors when first needed and keeps them.

    With ``remember`` it also keeps the last recording as heard and the last performance as generated, so that another
    style is not heard again and another intensity is not generated again.

    ``language`` (as in ``de``), ``aligner_model`` and ``recogniser_model`` (folders) are for another language, whose words say
    nothing to the network unless ``vectors`` are given too: its own are English. Word times are kept in the folder ``cache``,
    by default the user's (:func:`cache.default_folder`), and not at all if it is "off".
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
    ):
        self._paths = checkpoint, vectors
        self.device = device
        folder = default_folder() if cache is None else None if str(cache) == "off" else cache
        self._ways = transcript.Ways(Cache(folder), languages.load(aligner_model, language), False, recogniser_model)
        self.understands = vectors is not None or not languages.foreign(self._ways.model)
        self._checkpoint = self._vectors = None
        self._memory = Memory() if remember else None

    @property
    def checkpoint(self):
        """The loaded :class:`checkpoint.Checkpoint`."""
        if self._checkpoint is None:
            from ..model import checkpoint

            self._checkpoint = checkpoint.load(self._paths[0], self.device)
            self._checkpoint.generator.eval()
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
        runs = [_Run(self, request, progress, cancelled) for request in requests]
        if len({(str(one.audio), str(one.transcript), one.text, one.recognise) for one in requests}) != 1:
            raise UsageError("The requests are not about one recording.", "Make those of other recordings one by one.")
        memory = self._memory or Memory()
        recording = signature(requests[0])
        heard = memory.heard(recording)
        sound = runs[0].read() if heard is None else None
        for run in runs:
            run.prepare()  # before anything long: it complains of unknown styles
        heard = runs[0].hear(sound) if heard is None else replace(heard, seconds=runs[0].seconds)
        walking = any(run.latents.shape[1] > 1 for run in runs)
        latents = np.concatenate([run.on_the_way(heard.frames if walking else 1) for run in runs])
        seeds = np.concatenate([run.seeds for run in runs])
        performers = recording, latents.shape, latents.tobytes(), seeds.tobytes()
        made = memory.made(performers)
        made = runs[0].generate(heard, latents, seeds) if made is None else made
        memory.keep(recording, heard, performers, made)
        ends = np.cumsum([len(run.latents) for run in runs])[:-1]
        return [run.result(heard, part) for run, part in zip(runs, np.split(made, ends), strict=True)]


class _Run:
    """One request on its way through the stages; each stage is timed and may be cancelled."""

    def __init__(self, session: Session, request: Request, progress, cancelled):
        self.session, self.request = session, request
        self.progress, self.cancelled = progress, cancelled
        self.seconds: dict[str, float] = {}

    def stage(self, name: str, work: Callable):
        if self.cancelled():
            raise Cancelled("Cancelled.")
        self.progress(name, 0.0)
        began = time.perf_counter()
        value = work()
        self.seconds[name] = time.perf_counter() - began
        self.progress(name, 1.0)
        return value

    def read(self) -> np.ndarray:
        """The recording, and a session that has its network."""
        from ..sound import audio

        sound = self.stage("read audio", lambda: audio.load(self.request.audio))
        self.stage("load model", lambda: self.session.checkpoint)
        return sound

    def hear(self, sound: np.ndarray) -> "_Heard":
        """What does not depend on style: everything about the recording."""
        from ..model.vector_features import VectorFeatures
        from ..sound import audio, voice

        said = self.stage("align words", lambda: self._words(sound))
        words, wishes = said.words, hints.understand(said.marks, said.words)
        warnings, config = said.warnings + _unknown(wishes), self.session.checkpoint.config
        vectors = self.stage("load word vectors", lambda: self.session.vectors) if words and not config.words else None
        frames = max(int(len(sound) / audio.SAMPLE_RATE * skeleton.FPS), 2)
        told = hints.heard(words, wishes, self.session.understands)

        def hear():
            if config.words:
                return self._published(sound, told, warnings)
            return VectorFeatures(sound, told, vectors, self._prosody(sound, words, frames, wishes))

        features = self.stage("extract MFCC", hear)
        activity = self.stage("find pauses", lambda: _fit(voice.active(sound), frames))
        return _Heard(audio.digest(sound), words, wishes, warnings, features, activity, frames, self.seconds)

    def prepare(self) -> None:
        """Work out who performs: :attr:`latents` ``(takes, steps, size)``, :attr:`seeds` ``(takes, frames, 9, 3)``."""
        self._check_controls()
        speakers = self.session.checkpoint.speakers
        self.names = [speaker["name"] for speaker in speakers]
        steps = styles.steps(self.request.style or styles.default(speakers))
        self.weights = [styles.parse(step, self.names) for step in steps]
        self.rests = np.stack([_rest_pose(speakers, weights) for weights in self.weights])
        self.latents = self._given() if self.request.latent is not None else self._drawn()
        start = self.rests[0] if self.request.pose is None else np.asarray(self.request.pose)
        shape = self.request.takes, self.session.checkpoint.window[1], 9, 3
        self.seeds = np.broadcast_to(skeleton.normalize(start), shape).astype(np.float32)

    def on_the_way(self, frames: int) -> np.ndarray:
        """:attr:`latents` at every frame ``(takes, frames, size)``, or ``(takes, size)`` for one frame."""
        if frames == 1:
            return self.latents[:, 0]
        if len(self.weights) == 1:
            return np.repeat(self.latents, frames, axis=1)
        return styles.along(self.latents, frames)

    def generate(self, heard: "_Heard", latents: np.ndarray, seeds: np.ndarray) -> np.ndarray:
        """Directions ``(takes, frames, 9, 3)`` as the network makes them."""
        from . import windows

        network, window = self.session.checkpoint.generator, self.session.checkpoint.window[0]
        tell = (lambda value: self.progress("generate", value)), self.cancelled
        work = (network, heard.features.slice, latents, seeds, heard.frames, window, *tell)
        return self.stage("generate", lambda: windows.generate(*work))

    def result(self, heard: "_Heard", made: np.ndarray) -> Result:
        """Motions of what was generated for this request."""
        meta = self._meta(heard)
        which = zip(self.request.identities, made, strict=True)
        finished = (self._finish(directions, heard, meta, *one) for one, directions in which)
        motions = self.stage("finish", lambda: list(finished))
        return Result(motions, heard.words, heard.warnings, {**heard.seconds, **self.seconds}, self.latents)

    def _words(self, sound: np.ndarray) -> transcript.Heard:
        def tell(value: float) -> None:
            if self.cancelled():
                raise Cancelled("Cancelled.")
            self.progress("align words", value)

        return self.session.words(sound, self.request, tell)

    def _published(self, sound: np.ndarray, words: tuple, warnings: list[str]):
        """What an imported network hears."""
        from ..model.table_words import TableFeatures

        vocabulary = self.session.checkpoint.meta.get("vocabulary")
        if words and not vocabulary:
            warnings.append("This checkpoint was imported without its vocabulary, so its gestures do not follow the words.")
        return TableFeatures(sound, words, vocabulary, self.session.checkpoint.config)

    def _prosody(self, sound: np.ndarray, words: tuple, frames: int, wishes: hints.Wishes) -> np.ndarray | None:
        if not self.session.checkpoint.config.prosody_features:
            return None
        from ..sound import prosody

        return prosody.analyse(sound, words, frames, wishes.stressed).features

    def _check_controls(self) -> None:
        if self.request.controls.any() and not self.session.checkpoint.config.controls:
            named = next(name for name, value in zip(styles.CONTROLS, self.request.controls, strict=True) if value)
            raise UsageError(f"This checkpoint has no control of {named}.", "Leave it at 0, or choose one with controls.")

    def _given(self) -> np.ndarray:
        """The request's own point of the latent space for each step of its style."""
        given = np.atleast_2d(np.asarray(self.request.latent, np.float32))
        expected = len(self.weights), self.session.checkpoint.config.style_size
        if given.shape != expected or not np.isfinite(given).all():
            message = f"The point of the latent space has shape {given.shape}, not {expected}."
            raise UsageError(message, "Sample again with this checkpoint.")
        return given[None]

    def _drawn(self) -> np.ndarray:
        """:attr:`latents` of every step of the style."""
        return np.stack([self._latents(weights) for weights in self.weights], axis=1)

    def _latents(self, weights) -> np.ndarray:
        """Styles ``(takes, size)``, one a take, each steered by the controls; takes after the first vary them a little."""
        import torch

        checkpoint = self.session.checkpoint
        with torch.inference_mode():
            every = torch.arange(len(checkpoint.speakers), device=self.session.device)
            mean, log_variance = checkpoint.generator.speaker(every)
        mean, deviation = mean.cpu().numpy(), log_variance.mul(0.5).exp().cpu().numpy()
        drawn = styles.latent(weights, mean, deviation, self.request.seed, self.request.identities)
        if not checkpoint.config.controls:
            return drawn
        wishes = styles.vary(self.request.controls, self.request.seed, self.request.identities)
        with torch.inference_mode():
            style, controls = (torch.from_numpy(part).to(self.session.device) for part in (drawn, wishes))
            return checkpoint.generator.steer(style, controls).cpu().numpy()

    def _finish(self, directions: np.ndarray, heard: "_Heard", meta: dict, take: int, near: tuple) -> Motion:
        request, pose = self.request, self.rests[0]
        if len(self.rests) > 1:
            pose = skeleton.normalize(styles.along(self.rests.reshape(len(self.rests), -1), len(directions)).reshape(-1, 9, 3))
        meta = {**meta, "take": take, **({"near": [list(step) for step in near]} if near else {})}
        directions = rest.restore(rest.soften(directions), self.session.checkpoint.gain, pose)
        wished = hints.perform(directions, heard.wishes, pose)
        performed = rest.rest(wished, heard.activity, request.seed + take, pose, at_rest=request.pose is None)
        scaled = rest.scale(performed, request.intensity, pose)
        motion = Motion(limits.keep_human(scaled), skeleton.FPS, heard.words, meta)
        return motion.mirrored() if request.mirror else motion

    def _meta(self, heard: "_Heard") -> dict:
        import hashlib
        import json

        request, words = self.request, heard.words
        named = [{self.names[index]: weight for index, weight in (step or {}).items()} for step in self.weights]
        named = [step or styles.RANDOM for step in named]
        return {
            "version": VERSION,
            "audio": heard.digest,
            "transcript": hashlib.sha256(json.dumps(words).encode()).hexdigest() if words else None,
            "style": named[0] if len(named) == 1 else named,
            "seed": request.seed,
            "intensity": request.intensity,
            "affect": {name: float(value) for name, value in request.affect.items()},
            "rate": float(request.rate),
            "hand": float(request.hand),
            "mirror": request.mirror,
            "checkpoint": self.session.checkpoint.hash,
            **({} if request.latent is None else {"latent": self.latents[0].tolist()}),
        }


@dataclass(frozen=True)
class _Heard:
    """A recording as performers hear it: digest, words, wishes, warnings, features, voice activity, frames, seconds spent.

    ``features`` are :class:`VectorFeatures`, or :class:`TableFeatures` for an imported network.
    """

    digest: str
    words: tuple
    wishes: hints.Wishes
    warnings: list[str]
    features: object
    activity: np.ndarray
    frames: int
    seconds: dict[str, float]


def _unknown(wishes: hints.Wishes) -> list[str]:
    if not wishes.unknown:
        return []
    names = ", ".join(f"{{{name}}}" for name in wishes.unknown[:3])
    return [f"The transcript's hint {names} is not one that gestures know; it is left out (docs/transcripts.md lists them)."]


def _rest_pose(speakers: list[dict], weights: dict[int, float] | None) -> np.ndarray:
    """Where the style's speakers keep their hands when nothing is said, unit directions ``(9, 3)``."""
    if weights is None:
        return rest.REST
    poses = sum(weight * np.array(speakers[index].get("rest", rest.REST)) for index, weight in weights.items())
    return skeleton.normalize(poses).astype(np.float32)


def _fit(values: np.ndarray, frames: int) -> np.ndarray:
    return np.pad(values[:frames], (0, max(frames - len(values), 0)), mode="edge" if len(values) else "constant")
