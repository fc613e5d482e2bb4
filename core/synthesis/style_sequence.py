"""The stage *cast*: who performs, as points of the latent space with their rest poses, tastes and seed poses."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .. import styles
from ..errors import UsageError
from ..model.noise import beginning
from ..motion import rest, skeleton
from ..settings import CONTROLS
from . import accent_selection, constraints, curves
from .request import Request

_READY = 0.7
"""How readily speakers show meanings where that is not known."""
SIZE = np.array([[1.18, 0.75, 0.75, *[1.18] * 6]])
"""Factor from movements of each edge as a network draws them to those performed: chance that beats have is lost to large ones,
and heads are bowed and turned by a half more, and faster, than people's."""
_MIN_INTENSITY = 0.2
"""Intensity below which a kept frame is enlarged no further for the network."""
_BEGINS = 4.0
"""How much of the chance that a calm performer lacks comes back where takes begin, as a multiple: all would begin alike."""


@dataclass(frozen=True)
class StyleSequence:
    """The styles of a ``request``'s takes: one, the steps of a walk (several styles in one recording), or styles
    that begin on the way.

    ``style``: weights of speakers by name for each step; ``begins`` ``(steps - 1,)``: frames at which later styles begin, None
    for a walk; ``rests`` ``(steps, 9, 3)``: rest poses; ``latents`` ``(takes, steps, size)``; ``readiness``: how readily
    phrases are shown by gestures of their own, 0..1; ``chances`` ``(steps,)``: scale of the noise; ``tastes`` ``(steps, 8)``:
    how accents are answered (:data:`accent_selection.FACTS`), None if unknown; ``steer`` moves points
    ``(takes, frames, size)`` along the curves of controls and what is heard, None without any."""

    request: Request
    style: list[dict[str, float] | str]
    rests: np.ndarray
    latents: np.ndarray
    readiness: float
    chances: np.ndarray
    begins: np.ndarray | None = None
    steer: Callable[[np.ndarray], np.ndarray] | None = None
    tastes: np.ndarray | None = None

    @property
    def walks(self) -> bool:
        """Whether the style changes on the way."""
        return self.latents.shape[1] > 1

    @property
    def varies(self) -> bool:
        """Whether style or controls change on the way."""
        return self.walks or self.steer is not None

    @property
    def who(self) -> dict[str, float] | None:
        """Weights of the speakers who key a take's random numbers; those of the first step, so that a change is not seen."""
        return self.style[0] if isinstance(self.style[0], dict) else None

    @property
    def first(self) -> np.ndarray:
        """The first frame ``(9, 3)``: the one that is given, or else the rest pose."""
        return skeleton.normalize(self.request.first_pose(self.rests[0])).astype(np.float32)

    @property
    def own(self) -> np.ndarray:
        """``latents`` of the requested style, without those of styles that begin on the way."""
        return self.latents if self.begins is None else self.latents[:, :1]

    def _over(self, points: np.ndarray, frames: int) -> np.ndarray:
        """Interpolate values of each step ``(..., steps, size)`` at every frame."""
        if self.begins is None:
            return styles.interpolate_sequence(points, frames)
        return styles.switch_at_frames(points, frames, self.begins)

    def on_the_way(self, frames: int) -> np.ndarray:
        """Return ``latents`` at every frame ``(takes, frames, size)``, or ``(takes, size)`` for one frame."""
        if frames == 1:
            return self.latents[:, 0]
        points = self._over(self.latents, frames) if self.walks else np.repeat(self.latents, frames, axis=1)
        return points if self.steer is None else self.steer(points)

    def chance(self, frames: int) -> np.ndarray:
        """Return the scale of the noise in bands at every frame ``(frames, 2)``: calm performers have less than 1."""
        own = self._over(self.chances[:, None], frames)[:, 0] if self.walks else np.full(frames, self.chances[0])
        return np.stack([own * (1 + _BEGINS * beginning(0, frames) * np.maximum(1 - own, 0)), own], axis=1)

    def taste(self, frames: int) -> np.ndarray | None:
        """Return ``tastes`` at every frame ``(frames, 8)``, or ``(1, 8)`` where they stay; None where they are not known."""
        return self._over(self.tastes, frames) if self.walks and self.tastes is not None else self.tastes

    def rest(self, frames: int) -> np.ndarray:
        """Return the rest pose: ``(9, 3)``, or ``(frames, 9, 3)`` for a walk."""
        if not self.walks:
            return self.rests[0]
        return skeleton.normalize(self._over(self.rests.reshape(len(self.rests), -1), frames).reshape(-1, 9, 3))

    def given(self, frames: int) -> constraints.KeptFrames:
        """Return the frames that the network is given: those that the request keeps, with their size undone, and the rest pose
        at the start unless another is kept there."""
        kept = constraints.kept_frames(self.request, frames)
        pose = self.rest(frames)
        numbers, poses = kept.frames, pose[kept.frames] if self.walks else pose
        size = SIZE * np.broadcast_to(curves.sample(self.request, "intensity", frames), (frames,))[numbers, None]
        directions = rest.scale_amplitude(kept.directions, 1 / np.maximum(size, _MIN_INTENSITY), poses)
        if not len(numbers) or numbers[0]:
            start = self.rests[:1].astype(np.float32)
            numbers, directions = np.concatenate([[0], numbers]), np.concatenate([start, directions])
        return constraints.KeptFrames(numbers, directions)


def from_request(checkpoint: Any, request: Request, hinted: Sequence = (), heard: np.ndarray | None = None) -> StyleSequence:
    """Return the performers of a request, with the styles that the words ask for, ``hinted`` ``(seconds, style)``; a walk takes
    none of these. They follow the affect that is ``heard`` ``(frames, 3)``.

    Raises :class:`UsageError` for unknown styles, and for controls that the weights do not have."""
    _check_controls(checkpoint, request)
    walk, turns = request.walk(checkpoint.speakers, hinted)
    speakers = styles.performers(checkpoint.speakers, walk, checkpoint.hash)
    names = [speaker["name"] for speaker in speakers]
    weights = [styles.parse(step, names) for step in walk]
    rests = np.stack([_rest_pose(speakers, step) for step in weights])
    if request.latent is not None:
        latents = _given(checkpoint, request, 1 if turns else len(weights))
        later = [draw_latents(checkpoint, request, step, speakers)[:, None] for step in weights[1:]] if turns else []
        latents = np.concatenate([latents, *later], axis=1)
    else:
        latents = np.stack([draw_latents(checkpoint, request, step, speakers) for step in weights], axis=1)
    named = [{names[index]: weight for index, weight in (step or {}).items()} or styles.RANDOM for step in weights]
    chances = np.array([_fact(speakers, step, "chance", 1.0) for step in weights])
    ready = _fact(speakers, weights[0], "semantic", _READY)
    begins = np.array([at * skeleton.FPS for at in turns]) if turns else None
    steer, tastes = _steering(checkpoint, request, heard), _tastes(speakers, weights)
    return StyleSequence(request, named, rests, latents, ready, chances, begins, steer, tastes)


def draw_latents(checkpoint: Any, request: Request, weights: dict[int, float] | None, speakers: Sequence = ()) -> np.ndarray:
    """Draw a style for each take ``(takes, size)``, steered by the controls; these vary a little after the first take."""
    mean, deviation = checkpoint.network.speakers  # further ones bring their points
    own = [one["point"] for one in speakers[len(mean) :] if weights]
    if any(len(point) != mean.shape[1] for point in own):
        raise UsageError("A style of one's own is damaged.", "Learn it again.")
    if own:
        deviation = np.concatenate([deviation, np.tile(deviation.mean(0), (len(own), 1))])
        mean = np.concatenate([mean, np.array(own, np.float32)])
    on = replace(request, chance=None) if weights is None else request  # a random performer is the same for all recordings
    drawn = styles.sample_styles(weights, mean, deviation, on.keyed_seed, request.identities)
    if not checkpoint.config.controls or curves.has_control_curves(request):
        return drawn
    return checkpoint.network.steer(drawn, styles.vary_controls(request.controls, request.keyed_seed, request.identities))


def _steering(checkpoint: Any, request: Request, heard: np.ndarray | None) -> Callable[[np.ndarray], np.ndarray] | None:
    """Return what moves styles along the curves of a request's controls and the affect ``heard``, None without any."""
    curved = curves.has_control_curves(request)
    if not curved and not curves.following(request, heard, 1):
        return None

    def steer(points: np.ndarray) -> np.ndarray:
        frames = points.shape[1]
        wishes = styles.vary_controls(curves.controls(request, frames), request.keyed_seed, request.identities)
        asked = 0 if curved else wishes.copy()  # points without curves are where their sliders moved them
        for name, track in curves.following(request, heard, frames).items():
            column = (..., CONTROLS.index(name))
            wishes[column] = np.clip(wishes[column] + track[:, None], -curves.REACH, curves.REACH)
        wishes = wishes - asked
        pairs = zip(points, np.moveaxis(wishes, 1, 0), strict=True)
        return np.stack([checkpoint.network.steer(*pair) for pair in pairs]).astype(np.float32)

    return steer


def _given(checkpoint: Any, request: Request, steps: int) -> np.ndarray:
    """Return the request's own point of the latent space for each step of its style."""
    given = np.atleast_2d(np.asarray(request.latent, np.float32))
    if given.shape != (steps, checkpoint.config.style_size) or not np.isfinite(given).all():
        message = f"The point of the latent space has shape {given.shape}, not {(steps, checkpoint.config.style_size)}."
        raise UsageError(message, "Sample again with this checkpoint.")
    return given[None]


def _check_controls(checkpoint: Any, request: Request) -> None:
    """Raise :class:`UsageError` where controls are asked of weights that have none."""
    if not checkpoint.config.controls and request.steered & set(CONTROLS):
        named = next(name for name in CONTROLS if name in request.steered)
        raise UsageError(f"This checkpoint has no control of {named}.", "Leave it at 0, or choose one with controls.")


def _fact(speakers: list[dict], weights: dict[int, float] | None, name: str, usual: float) -> float:
    """Return a fact of the style's speakers, averaged by weight; ``usual`` for those without it."""
    if weights is None:
        return usual
    return float(sum(weight * speakers[index].get(name, usual) for index, weight in weights.items()))


def _tastes(speakers: list[dict], steps: Sequence[dict[int, float] | None]) -> np.ndarray | None:
    """Return the taste of each step ``(steps, 8)``, None where a speaker has none; a random style has the mean of all."""
    tastes = [accent_selection.speaker_taste(speaker.get("answers")) for speaker in speakers]
    if not tastes or any(one is None for one in tastes):
        return None
    every = np.array(tastes)
    return np.stack([every.mean(0) if step is None else sum(weight * every[k] for k, weight in step.items()) for step in steps])


def _rest_pose(speakers: list[dict], weights: dict[int, float] | None) -> np.ndarray:
    """Return the rest pose of a style, unit directions ``(9, 3)``: the mean of its speakers'."""
    if weights is None:
        return rest.REST
    poses = [weight * np.array(speakers[index].get("rest", rest.REST)) for index, weight in weights.items()]
    return skeleton.normalize(np.sum(poses, axis=0)).astype(np.float32)
