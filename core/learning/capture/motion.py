"""From a film to a motion: looks, cleans, and says what was left out."""

import json
import wave
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import AudioUnreadable, CorpusUnreadable
from ...files import atomic_file
from ...motion import handshape, skeleton
from ...motion.hands import FOREARMS, Hands
from ...motion.motion import Motion
from ...motion.rest import REST
from ...motion.skeleton import FPS
from ...sound import audio
from ...version import VERSION
from ...words.transcript import TranscriptOptions, timed_transcript
from . import body, estimator, hands, lifting, people, smoothing, viewpoint
from .landmarks import Landmarks, facing

BRIDGED = 0.5
"""Seconds of a gap that is bridged in a straight line; longer ones lead to rest and are left out."""
_EASE = 0.5
_LEAP = 0.35
"""How far a direction must leap from one picture to the next, at least, to be an outlier."""
_HAND_LEAP = 0.6
_HAND_WIDTH = 0.08
"""Seconds of the Gaussian over hands: their points are small and tremble more than arms."""
_KEPT = ".seen.npz"
"""Ending of the file beside the output in which a stopped capture keeps what it has seen."""


@dataclass(frozen=True)
class Captured:
    """A motion, with ``sound`` ``(n,)`` at 16 kHz or None, and what a user should be told in ``notes``."""

    motion: Motion
    sound: np.ndarray | None
    notes: list[str]

    def save(self, path: str | PathLike) -> None:
        """Write the motion, and beside it the sound (.wav) and the words (.json), as ``s2ag data plain`` reads them."""
        path = Path(path)
        if self.sound is not None:
            with atomic_file(path.with_suffix(".wav")) as temporary, wave.open(str(temporary), "wb") as file:
                file.setparams((1, 2, audio.SAMPLE_RATE, 0, "NONE", ""))
                file.writeframes(np.round(np.clip(self.sound, -1, 1) * 32767).astype("<i2").tobytes())
        if self.motion.words:
            with atomic_file(path.with_suffix(".json")) as temporary:
                temporary.write_text(json.dumps([list(word) for word in self.motion.words]), "utf-8")
        self.motion.save(path)


def capture(
    path: str | PathLike,
    output: str | PathLike,
    person: int | str | None = None,
    words: tuple[str | PathLike | None, str | None] = (None, None),
    options: TranscriptOptions | None = None,
    progress: Callable[[str, float], None] = lambda stage, share: None,
    camera: Sequence[float] | None = None,
) -> Captured:
    """Return the motion of a person in a film.

    What has been seen is kept beside ``output`` until :func:`finish`; the same call goes on from it. ``person`` counts those in
    the picture from the left, 1 being the first; None takes the one who speaks, else the largest. ``words`` are a transcript
    file or a text; ``camera`` is as :func:`clean` takes it. Raises :class:`EngineMissing`, :class:`CorpusUnreadable`,
    :class:`TranscriptUnreadable`.
    """
    path = Path(path)
    sound = _sound(path)
    region, notes = people.choose(path, person, sound, lambda share: progress("find people", share))
    found = estimator.look(path, region, kept_beside(output), lambda share: progress("look", share))
    motion, left_out = clean(found, camera)
    notes += left_out
    spoken: Sequence = ()
    if sound is not None:
        said = timed_transcript(sound, *words, lambda share: progress("align words", share), options)
        spoken, notes = said.words, notes + said.warnings
    else:
        notes.append("The film has no sound: the motion has no words.")
    about = {**motion.meta, "source": path.name, "style": path.stem, "captured": str(found.film), "version": VERSION}
    return Captured(replace(motion, words=tuple(spoken), meta=about), sound, notes)


def kept_beside(output: str | PathLike) -> Path:
    """Return where a capture keeps what it has seen until its output is written."""
    return Path(output).with_suffix(_KEPT)


def finish(output: str | PathLike) -> None:
    """Delete what a capture has kept beside its output."""
    kept_beside(output).unlink(missing_ok=True)


def clean(found: Landmarks, camera: Sequence[float] | None = None) -> tuple[Motion, list[str]]:
    """Return the motion at 15 frames a second of what was seen, and sentences on what was left out of it.

    ``camera``, where it is known, are degrees that the camera stands to the performer's left and above.

    ``meta["unseen"]`` lists seconds (start, end) without a body or arms: there the motion rests. ``meta["camera"]`` and
    ``meta["gaze"]`` are as :class:`body.Pose` has them, but that a camera that is known is as good as level.
    """
    found = facing(found)
    pose = body.read(found, None if camera is None else viewpoint.view(np.tile(camera, (len(found), 1))))
    at = np.arange(max(int(found.times[-1] * FPS) + 1, 2)) / FPS
    lifted = lifting.lift(found, pose, at)
    directions, arms_seen = _directions(found, pose, at, lifted)
    motion = Motion(directions, hands=_hands(found, pose, at, directions, lifted))
    unseen = [(start / FPS, end / FPS) for start, end in _runs(~arms_seen) if end - start > BRIDGED * FPS]
    cuts = [float(found.times[row]) for row in np.flatnonzero(np.diff(pose.scenes) > 0) + 1]
    about: dict = {"unseen": [[round(a, 3), round(b, 3)] for a, b in unseen], "cuts": [round(cut, 3) for cut in cuts]}
    stood = pose.camera if camera is None else (camera[0], 0.0)
    about |= {"camera": np.round(stood, 2).tolist(), "gaze": None if pose.gaze is None else round(pose.gaze, 2)}
    notes, lost = [], sum(b - a for a, b in unseen)
    if lost > 0.98 * len(at) / FPS:
        raise CorpusUnreadable("The film never shows a person with both arms.", "Film from the thighs up, from the front.")
    if unseen:
        notes.append(
            f"{lost:.1f} of {at[-1]:.1f} seconds show no body with both arms (close-ups, others, hands out of the picture): "
            "the motion rests there, and what learns from it leaves them out."
        )
    if cuts:
        notes.append(f"The film has {len(cuts)} cuts: each scene was read for itself.")
    return replace(motion, meta=about), notes


def _directions(found: Landmarks, pose: body.Pose, at: np.ndarray, lifted: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Return directions ``(m, 9, 3)`` at the moments ``at``, and where both arms are seen ``(m,)``."""
    result, both = np.zeros((len(at), 9, 3)), np.ones(len(at), bool)
    weights = {edge: pose.seen.astype(float) for edge in (0, 1, 2, 3, 6)}
    for side, edges in enumerate(skeleton.ARMS):
        weights |= {edge: pose.arms[:, side] for edge in edges}
    for edge, weight in weights.items():
        track = np.where(weight[:, None] > 0, pose.directions[:, edge], np.nan)
        weight = np.where(smoothing.outliers(track, _LEAP), 0.0, weight)
        width = smoothing.WIDTH * (1 if edge in skeleton.ARM_EDGES else 2)
        values, seen = smoothing.resample(found.times, track, weight, pose.scenes, at, width)
        if lifted is not None and edge in skeleton.ARM_EDGES:
            values = lifted[:, int(edge > 5), (edge - 4) % 3]
        result[:, edge] = smoothing.fill(values, seen, REST[edge], round(BRIDGED * FPS), round(_EASE * FPS))
        both &= seen
    return skeleton.normalize(result).astype(np.float32), both


def _hands(
    found: Landmarks, pose: body.Pose, at: np.ndarray, directions: np.ndarray, lifted: np.ndarray | None
) -> Hands | None:
    """Return the hands where they are seen, relaxed ones elsewhere; None if neither is ever seen."""
    width, height = found.size
    parts, ever = [], False
    for side, points in enumerate((found.left, found.right)):
        placed = np.einsum("fij,fkj->fki", pose.view, points * body.TO_CANONICAL * [width, height, width])
        along, palm = hands.frame(placed, side == 0)
        track = np.concatenate([along, palm, hands.shape(placed, side == 0) / 90], 1)
        weight = np.where(np.isfinite(track).all(1) & pose.seen, 1.0, 0.0)
        weight[smoothing.outliers(np.where(weight[:, None] > 0, track[:, :6], np.nan), _HAND_LEAP)] = 0
        values, seen = smoothing.resample(found.times, track, weight, pose.scenes, at, _HAND_WIDTH)
        ever |= bool(seen.any())
        if lifted is not None:
            values[:, :6] = lifted[:, side, 2:].reshape(-1, 6)
        parts.append(_with_relaxed(values, seen, directions[:, FOREARMS[side]], side))
    if not ever:
        return None
    both = np.stack(parts, 1)
    return Hands.of(both[..., :3], both[..., 3:6], both[..., 6:] * 90)


def _with_relaxed(values: np.ndarray, seen: np.ndarray, forearm: np.ndarray, side: int) -> np.ndarray:
    """Return tracks ``(m, 18)`` of a hand, which follows the forearm relaxed where it is not seen for long."""
    inward = np.array([1.0 if side == 0 else -1.0, 0.0, 0.0])
    palm = skeleton.normalize(inward - forearm * np.sum(inward * forearm, -1, keepdims=True))
    shape = np.broadcast_to(handshape.RELAXED / 90, (len(forearm), len(handshape.COLUMNS)))
    relaxed = np.concatenate([forearm, palm, shape], 1)
    apart = smoothing.fill(values - relaxed, seen, np.zeros(values.shape[1]), round(BRIDGED * FPS), round(_EASE * FPS))
    return relaxed + apart


def _runs(mask: np.ndarray) -> list[tuple[int, int]]:
    """Return (first, one after the last) of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _sound(path: Path) -> np.ndarray | None:
    try:
        return audio.load(path)
    except AudioUnreadable:
        return None  # told by a note: a film without sound is a motion, too
