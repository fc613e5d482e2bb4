"""Noise, voice, words, prosody, given poses, wishes and style to directions, as :class:`flow.FlowGenerator` learns it."""

import hashlib
from collections.abc import Callable, Mapping
from functools import cached_property

import numpy as np

from ...motion.skeleton import EDGES, MEAN
from ...products import one_thread_each
from ..config import ModelConfig
from ..steps import affect_reach, hears, looks, noise_scale, noise_size, solve, times
from ..timing import IN_STEP, mfcc_slice
from .affect import AffectiveEncoder
from .denoiser import Conditions, Denoiser
from .encoders import AskedEncoder, ProsodyEncoder, TextEncoder, VoiceEncoder
from .layers import Linear, Weights

_SETTINGS = {"decoder": "flow", "audio": "mfcc", "mfcc_axis": "time", "words": 0, "affect": "graph", "norm": "layer"}
_POSE = 3 * len(EDGES)
_SHORT, _PIECES = 1024, 6
"""Frames of a piece that is remembered at most, and how many pieces are."""


def able(config: ModelConfig) -> bool:
    """Whether this network's layers are all here; those of the published and imported networks are not."""
    known = all(getattr(config, name) == value for name, value in _SETTINGS.items())
    return known and not config.seed_view and tuple(config.node_kernels) == (1, 1)


class LightNetwork:
    """The network of a configuration with learned arrays by name; its answers are those of torch but for rounding.

    Raises KeyError and ValueError where the arrays are not those of the configuration.
    """

    shares = True
    """Whether several threads may draw at once."""

    def __init__(self, config: ModelConfig, arrays: Mapping[str, np.ndarray]):
        weights = Weights(arrays)
        self._remembered: dict[tuple, np.ndarray] = {}
        self.config, self.noise_size, self.looks, self.hears = config, noise_size(config), looks(config), hears(config)
        self._affect = AffectiveEncoder(weights / "aff_encoder", config)
        self._voice = VoiceEncoder(weights / "audio_encoder", config)
        self._text = TextEncoder(weights / "text_encoder", config)
        self._prosody = ProsodyEncoder(weights / "prosody_encoder", config) if config.prosody_features else None
        self._asked = AskedEncoder(weights / "asked_encoder") if config.meanings else None
        self._denoisers = [Denoiser(weights / "denoiser", config, config.style_size)]
        if config.extras:
            own = config.style_size + _POSE
            self._denoisers.append(Denoiser(weights / "extras_denoiser", config.of_extras(), own))
        self._centre, self._scale = weights["centre"], weights["scale"]
        self.ways = (weights / "controls")["weight"].T if config.controls else np.zeros((0, config.style_size), np.float32)
        self.speakers = self._speakers(weights)
        self._times = times(config)
        self._moments = [[one.moments(time) for time in self._times[:-1]] for one in self._denoisers]
        silence = self._nothing(2 * IN_STEP)
        # complains of arrays of other sizes
        self.draw(self.hear(*silence), self.speakers[0][0], silence[2], silence[2][:, :-1])

    def _speakers(self, weights: Weights) -> tuple[np.ndarray, np.ndarray]:
        """Means and deviations ``(speakers, style_size)`` of the speakers' styles (paper eq. 3, 4)."""
        table = weights / "speaker_embedding"
        embedded = Linear.of(table / "1")((table / "0")["weight"])
        mean, log_variance = (Linear.of(weights / name)(embedded) for name in ("speaker_mu", "speaker_log_var"))
        if mean.shape != (self.config.speakers, self.config.style_size):
            raise ValueError(f"styles of shape {mean.shape}")
        return mean, np.exp(0.5 * log_variance)

    def steer(self, styles: np.ndarray, wishes: np.ndarray) -> np.ndarray:
        """Styles ``(B, style_size)`` moved along the learned directions by ``wishes`` ``(B, 5)`` in -1..1."""
        return styles + np.einsum("bi,ij->bj", wishes, self.ways)

    def encode(self, mfcc, words, seeds, prosody=None) -> np.ndarray:
        """Features ``(T, channels)`` of everything but the style, without strokes that are asked for.

        ``mfcc`` ``(Ta, mfcc_features)``, ``words`` ``(T, word_size)``, ``seeds`` ``(T, noise_size + 1)``, ``prosody``
        ``(T, prosody_features)``, all float32.
        """
        frames = len(seeds)
        features = [self._given(seeds), self._listened(mfcc, words, prosody, frames)]
        if self._asked:
            features.append(self._asked(np.zeros((frames, 7), np.float32)))
        return np.concatenate(features, axis=1)

    def _listened(self, mfcc, words, prosody, frames: int) -> np.ndarray:
        """Features of voice, words and prosody; edits ask for the same short pieces again and again."""
        key = None
        if frames <= _SHORT:
            parts = (np.ascontiguousarray(part) for part in (mfcc, words, prosody) if part is not None)
            key = (frames, *(hashlib.blake2b(part).digest() for part in parts))
            if key in self._remembered:
                return self._remembered[key]
        found = [self._voice(mfcc, frames), self._text(words)] + ([self._prosody(prosody)] if self._prosody else [])
        features = np.concatenate(found, axis=1)
        if key is not None:
            self._remembered = {**dict(list(self._remembered.items())[1 - _PIECES :]), key: features}
        return features

    def hear(self, mfcc, words, seeds, prosody=None) -> list[list[np.ndarray]]:
        """What :meth:`draw` needs of the arguments of :meth:`encode`, whatever the style: for each denoiser."""
        features = self._emphasized(self.encode(mfcc, words, seeds, prosody))
        return [one.heard(features) for one in self._denoisers]

    def told(self, heard: list[list[np.ndarray]], asked: np.ndarray) -> list[list[np.ndarray]]:
        """What :meth:`hear` gave, with the strokes that one take is asked for, ``(T, 7)`` (:mod:`requested`)."""
        if not self._asked:
            return heard
        features = self._asked(asked)
        return [one.told(known, features) for one, known in zip(self._denoisers, heard, strict=True)]

    def draw(
        self,
        heard: list[list[np.ndarray]],
        style: np.ndarray,
        seeds: np.ndarray,
        noise: np.ndarray,
        begins: Callable[[], None] = lambda: None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Unit directions ``(T, 9, 3)`` and extras ``(T, extras)`` drawn from ``noise`` ``(T, noise_size)``.

        ``style`` is ``(size,)`` or ``(T, size)``.

        ``begins()`` is called before each of the ``flow_steps`` of poses, then of extras. ``seeds`` ``(T, noise_size + 1)``:
        poses less their mean on given frames and zeros elsewhere, last channel 1 on given frames.
        """
        mask = seeds[:, -1:]
        given = (seeds[:, :-1] - self._centre) / self._scale
        own = np.broadcast_to(self._exaggerated(np.asarray(style, np.float32)), (len(seeds), self.config.style_size))
        noise = noise * np.array(noise_scale(self.config), np.float32)
        parts = np.split(noise + mask * (given - noise), [_POSE], axis=1)
        made = []
        with one_thread_each():
            for denoiser, moments, known, start in zip(self._denoisers, self._moments, heard, parts, strict=False):
                conditions = denoiser.conditions(known, own)
                made.append(_drawn(denoiser, self._times, moments, conditions, start, mask, begins))
                own = np.concatenate([own, made[-1]], axis=1)
        numbers = np.concatenate(made, axis=1) * self._scale + self._centre
        poses = numbers[:, :_POSE].reshape(-1, len(EDGES), 3) + MEAN.astype(np.float32)
        lengths = np.sqrt(np.square(poses).sum(axis=-1, keepdims=True))
        return poses / np.maximum(lengths, np.float32(1e-12)), numbers[:, _POSE:]

    @property
    def usual(self) -> np.ndarray:
        """Extras ``(extras,)`` of a frame of which nothing is known."""
        return self._centre[_POSE:]

    def _given(self, seeds: np.ndarray) -> np.ndarray:
        """Affective features; nothing beyond the encoder's reach of the last given frame is felt, nor computed."""
        mask, result = seeds[:, -1:], np.zeros((len(seeds), self.config.affect_size), np.float32)
        filled = np.flatnonzero(mask)
        last = min(int(filled[-1]) + 1 + affect_reach(self.config), len(seeds)) if len(filled) else 1
        result[:last] = self._affect(seeds[:last, :_POSE].reshape(last, len(EDGES), 3)) * mask[:last]
        return result

    def _exaggerated(self, style: np.ndarray) -> np.ndarray:
        """Styles farther from the middle of all speakers."""
        middle = self.speakers[0].mean(axis=0)
        return middle + np.float32(self.config.flow_style) * (style - middle)

    def _emphasized(self, features: np.ndarray) -> np.ndarray:
        """Features with voice and prosody farther from those of silence."""
        if self.config.flow_voice == 1:
            return features
        return self._silence + self._emphasis * (features - self._silence)

    @cached_property
    def _silence(self) -> np.ndarray:
        frames = 4 * IN_STEP
        return self.encode(*self._nothing(frames))[frames // 2]

    @cached_property
    def _emphasis(self) -> np.ndarray:
        """How much farther each channel goes."""
        config, share = self.config, np.ones_like(self._silence)
        voice = config.seed_size + config.mfcc_size
        share[config.seed_size : voice] = config.flow_voice
        if config.prosody_features:
            share[voice + config.text_size :][: config.prosody_size] = config.flow_voice
        return share

    def _nothing(self, frames: int) -> list[np.ndarray]:
        """Silence, no words, no given frames, no prosody."""
        sizes = self.config.word_size, self.noise_size + 1, self.config.prosody_features
        mfcc = np.zeros((mfcc_slice(0, frames).stop, self.config.mfcc_features), np.float32)
        return [mfcc, *(np.zeros((frames, size), np.float32) for size in sizes)]


def _drawn(
    denoiser: Denoiser, times: list[float], moments: list, conditions: Conditions, start: np.ndarray, mask: np.ndarray, begins
) -> np.ndarray:
    """Where ``start`` ``(T, n)`` is carried; frames where ``mask`` ``(T, 1)`` is 1 stay as they are."""
    ahead = iter(moments)

    def velocity(x: np.ndarray, _: float) -> np.ndarray:
        begins()
        return denoiser(x, mask, conditions, next(ahead)) * (1 - mask)

    return solve(velocity, start, times)
