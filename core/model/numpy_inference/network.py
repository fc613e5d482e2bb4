"""The flow generator in numpy: inference of :class:`flow.FlowGenerator`."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

import numpy as np

from ...matrix_products import single_threaded_blas
from ...motion.skeleton import EDGES, MEAN
from ..config import ModelConfig
from ..flow_solver import affect_reach, feature_reach, noise_scale, noise_size, solve, time_grid, velocity_reach
from ..mfcc_timing import PHASE_PERIOD, mfcc_slice
from .affect import AffectiveEncoder
from .denoiser import Conditions, Denoiser, TimeModulation
from .encoders import ProsodyEncoder, RequestEncoder, TextEncoder, VoiceEncoder
from .layers import Linear, Weights

_SETTINGS = {"decoder": "flow", "audio": "mfcc", "mfcc_axis": "time", "words": 0, "affect": "graph", "norm": "layer"}
_POSE = 3 * len(EDGES)


def supports(config: ModelConfig) -> bool:
    """Whether all layers of this network are implemented here; published and imported networks need torch."""
    supported = all(getattr(config, name) == value for name, value in _SETTINGS.items())
    return supported and not config.seed_view and tuple(config.node_kernels) == (1, 1)


class NumpyNetwork:
    """The network of a configuration with weight arrays by name; equals torch up to rounding.

    Raises KeyError and ValueError if the arrays do not match the configuration."""

    shares = True
    """Whether several threads may call :meth:`draw` at once."""

    def __init__(self, config: ModelConfig, arrays: Mapping[str, np.ndarray]):
        weights = Weights(arrays)
        self.config, self.noise_size = config, noise_size(config)
        self.velocity_reach, self.hears = velocity_reach(config), feature_reach(config)
        self._affect = AffectiveEncoder(weights / "aff_encoder", config)
        self._voice = VoiceEncoder(weights / "audio_encoder", config)
        self._text = TextEncoder(weights / "text_encoder", config)
        self._prosody = ProsodyEncoder(weights / "prosody_encoder", config) if config.prosody_features else None
        self._asked = RequestEncoder(weights / "asked_encoder") if config.meanings else None
        self._denoisers = [Denoiser(weights / "denoiser", config, config.style_size)]
        if config.extras:
            own = config.style_size + _POSE
            self._denoisers.append(Denoiser(weights / "extras_denoiser", config.extras_config(), own))
        self._centre, self._scale = weights["centre"], weights["scale"]
        self.ways = (weights / "controls")["weight"].T if config.controls else np.zeros((0, config.style_size), np.float32)
        self.speakers = self._speakers(weights)
        self._times = time_grid(config)
        self._moments = [[denoiser.moments(time) for time in self._times[:-1]] for denoiser in self._denoisers]
        silence = self._silent_inputs(2 * PHASE_PERIOD)
        # A trial run, which raises for arrays of other sizes.
        self.draw(self.hear(*silence), self.speakers[0][0], silence[2], silence[2][:, :-1])

    def _speakers(self, weights: Weights) -> tuple[np.ndarray, np.ndarray]:
        """Return means and standard deviations ``(speakers, style_size)`` of the speakers' styles (paper eq. 3, 4)."""
        table = weights / "speaker_embedding"
        embedded = Linear.of(table / "1")((table / "0")["weight"])
        mean, log_variance = (Linear.of(weights / name)(embedded) for name in ("speaker_mu", "speaker_log_var"))
        if mean.shape != (self.config.speakers, self.config.style_size):
            raise ValueError(f"styles of shape {mean.shape}")
        return mean, np.exp(0.5 * log_variance)

    def steer(self, styles: np.ndarray, wishes: np.ndarray) -> np.ndarray:
        """Move styles ``(B, style_size)`` along the learned control directions by ``wishes`` ``(B, 5)`` in -1..1."""
        return styles + np.einsum("bi,ij->bj", wishes, self.ways)

    def encode(self, mfcc: np.ndarray, words: np.ndarray, seeds: np.ndarray, prosody: np.ndarray | None = None) -> np.ndarray:
        """Return features ``(T, channels)`` of everything but style and requested strokes.

        ``mfcc`` ``(Ta, mfcc_features)``, ``words`` ``(T, word_size)``, ``seeds`` ``(T, noise_size + 1)``, ``prosody``
        ``(T, prosody_features)``, all float32."""
        frames = len(seeds)
        features = [self._encode_given(seeds), self._voice(mfcc, frames), self._text(words)]
        if self._prosody:
            assert prosody is not None
            features.append(self._prosody(prosody))
        if self._asked:
            features.append(self._asked(np.zeros((frames, 7), np.float32)))
        return np.concatenate(features, axis=1)

    def hear(
        self, mfcc: np.ndarray, words: np.ndarray, seeds: np.ndarray, prosody: np.ndarray | None = None
    ) -> list[list[np.ndarray]]:
        """Return for each denoiser the features of the arguments of :meth:`encode`, for :meth:`draw` with any style."""
        features = self._emphasized(self.encode(mfcc, words, seeds, prosody))
        return [denoiser.heard(features) for denoiser in self._denoisers]

    def told(self, heard: list[list[np.ndarray]], asked: np.ndarray) -> list[list[np.ndarray]]:
        """Add one take's stroke requests ``(T, 7)`` (:mod:`stroke_requests`) to the features of :meth:`hear`."""
        if not self._asked:
            return heard
        requests = self._asked(asked)
        return [denoiser.told(part, requests) for denoiser, part in zip(self._denoisers, heard, strict=True)]

    def draw(
        self, heard: list[list[np.ndarray]], style: np.ndarray, seeds: np.ndarray, noise: np.ndarray,
        begins: Callable[[], None] = lambda: None
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Sample unit directions ``(T, 9, 3)`` and extras ``(T, extras)`` from ``noise`` ``(T, noise_size)``.

        ``style`` is ``(size,)`` or ``(T, size)``. ``seeds`` ``(T, noise_size + 1)``: mean-subtracted frames where given and
        zeros elsewhere, last channel 1 on given frames. ``begins()`` is called before each of the ``flow_steps`` for poses,
        then for extras."""
        mask = seeds[:, -1:]
        given = (seeds[:, :-1] - self._centre) / self._scale
        mean = self.speakers[0].mean(axis=0)  # styles are extrapolated away from it
        style = mean + np.float32(self.config.flow_style) * (np.asarray(style, np.float32) - mean)
        own = np.broadcast_to(style, (len(seeds), self.config.style_size))
        noise = noise * np.array(noise_scale(self.config), np.float32)
        parts = np.split(noise + mask * (given - noise), [_POSE], axis=1)
        samples = []
        with single_threaded_blas():
            for denoiser, moments, features, start in zip(self._denoisers, self._moments, heard, parts, strict=False):
                conditions = denoiser.conditions(features, own)
                samples.append(_integrate(denoiser, self._times, moments, conditions, start, mask, begins))
                own = np.concatenate([own, samples[-1]], axis=1)
        frames = np.concatenate(samples, axis=1) * self._scale + self._centre
        poses = frames[:, :_POSE].reshape(-1, len(EDGES), 3) + MEAN.astype(np.float32)
        lengths = np.sqrt(np.square(poses).sum(axis=-1, keepdims=True))
        return poses / np.maximum(lengths, np.float32(1e-12)), frames[:, _POSE:]

    @property
    def usual(self) -> np.ndarray:
        """Mean extras ``(extras,)``, for frames without known extras."""
        return self._centre[_POSE:]

    def _encode_given(self, seeds: np.ndarray) -> np.ndarray:
        """Return affective features; frames beyond the encoder's reach after the last given frame are skipped."""
        mask, result = seeds[:, -1:], np.zeros((len(seeds), self.config.affect_size), np.float32)
        filled = np.flatnonzero(mask)
        last = min(int(filled[-1]) + 1 + affect_reach(self.config), len(seeds)) if len(filled) else 1
        result[:last] = self._affect(seeds[:last, :_POSE].reshape(last, len(EDGES), 3)) * mask[:last]
        return result

    def _emphasized(self, features: np.ndarray) -> np.ndarray:
        """Extrapolate voice and prosody away from the features of silence."""
        if self.config.flow_voice == 1:
            return features
        return self._silence + self._emphasis * (features - self._silence)

    @cached_property
    def _silence(self) -> np.ndarray:
        frames = 4 * PHASE_PERIOD
        return self.encode(*self._silent_inputs(frames))[frames // 2]

    @cached_property
    def _emphasis(self) -> np.ndarray:
        """Extrapolation factor of each channel."""
        config, share = self.config, np.ones_like(self._silence)
        voice = config.seed_size + config.mfcc_size
        share[config.seed_size : voice] = config.flow_voice
        if config.prosody_features:
            share[voice + config.text_size :][: config.prosody_size] = config.flow_voice
        return share

    def _silent_inputs(self, frames: int) -> list[np.ndarray]:
        """Return inputs of silence, without words, given frames and prosody."""
        sizes = self.config.word_size, self.noise_size + 1, self.config.prosody_features
        mfcc = np.zeros((mfcc_slice(0, frames).stop, self.config.mfcc_features), np.float32)
        return [mfcc, *(np.zeros((frames, size), np.float32) for size in sizes)]


def _integrate(
    denoiser: Denoiser, times: list[float], moments: Sequence[TimeModulation], conditions: Conditions, start: np.ndarray,
    mask: np.ndarray, begins: Callable[[], None]
) -> np.ndarray:  # fmt: skip
    """Integrate the flow from ``start`` ``(T, n)``; frames where ``mask`` ``(T, 1)`` is 1 stay unchanged."""
    upcoming = iter(moments)

    def velocity(x: np.ndarray, _: float) -> np.ndarray:
        begins()
        return denoiser(x, mask, conditions, next(upcoming)) * (1 - mask)

    return solve(velocity, start, times)
