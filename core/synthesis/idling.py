"""A person who stands and waits, put together from captured ones: long calm stretches, and fidgets between them.

``idle.npz``, which :mod:`s2ag.core.learning.corpus.idle_table` packs, has whole stretches of directions and hands; all begin
and end in nearly the same stance. No kind of them comes twice within :data:`APART` seconds. Weight, breath, face and gaze are
those of silence in a talk."""

import zlib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import npz
from ..errors import UsageError
from ..face import eyes
from ..motion import hand_channels, rest, skeleton
from ..motion.face import CHANNELS, GAZE_DEGREES, RATE, Face, channel
from ..motion.interpolation import ramp, sample_cubic
from ..motion.motion import Motion
from ..motion.pelvis import Pelvis
from ..version import VERSION
from . import stance

STEPS = np.repeat([1000.0, 400.0], [27, hand_channels.SIZE])
"""Steps that the table has for 1, of directions and of hands."""
APART = 20.0
"""Seconds between two stretches of one kind."""
LONGEST = 3600.0
"""Seconds of the longest idle."""
_FIDGETS = {"look_around": 1.0, "move": 1.0, "move_leg": 0.8, "nervous": 0.4, "roll_head": 0.6, "finger_nail": 0.6, "dust": 0.2}
_FIDGETS |= {"touch_face": 0.6, "touch_hair": 0.5, "scratch_head": 0.4, "shake_arms": 0.15, "stretch_arms": 0.1, "yawn": 0.1}
_FIDGETS |= {"cough": 0.1}
"""How readily each kind of fidget comes; other clips are calm."""
_CALM_SECONDS, _STILL_FACTOR = 4.0, 8.0
"""Mean seconds between fidgets at stillness 0, and how much longer it is at stillness 1, where none comes any more."""
_PIECE, _JOIN, _SEAM = (4.0, 10.0), 0.9, 2.0
"""Seconds of a calm piece, of the blend between pieces, and of the one that closes a loop."""
_OTHER_BODY = 0.25
"""How readily a piece of the other of the two captured bodies comes: each has its own way to stand."""
_GAZE_LEAD, _GAZE_SHARE = 0.25, 0.8
"""Seconds by which eyes go ahead of a turning head, and their share of it."""


class Stretch(NamedTuple):
    """A captured stretch: the body that it is of, its kind, and ``numbers`` ``(frames, 27 + SIZE)``."""

    body: str
    kind: str
    numbers: np.ndarray


def idle(
    seconds: float, style: str = "", seed: int = 0, stillness: float = 0.5, loop: bool = False, fps: float = skeleton.FPS
) -> Motion:  # fmt: skip
    """Return so many seconds of a person who waits, with hands, pelvis and face.

    ``stillness`` 0..1 makes fidgets seldom and movements small; ``style`` chooses habits, ``seed`` the rest. With ``loop`` the
    last frame is the first one again, and the movement goes on across it. Raises :class:`UsageError` for values out of range.
    """
    if not (1 <= seconds <= LONGEST and 0 <= stillness <= 1 and seed >= 0 and 1 <= fps <= 1000):
        wrong = f"An idle of {seconds:g} s, seed {seed}, stillness {stillness:g} at {fps:g} frames a second is not possible."
        raise UsageError(wrong, f"Give 1 to {LONGEST:g} seconds, a seed of 0 or more and a stillness of 0 to 1.")
    frames, seam = round(seconds * skeleton.FPS), round(min(_SEAM, seconds / 2) * skeleton.FPS) if loop else 0
    rng = np.random.default_rng((seed, zlib.crc32(style.encode()), 0x1D7E))
    numbers, shown = _assemble(frames + seam, seam, style, stillness, rng)
    numbers[:, :27] += 0.5 * rest.idle_offsets(len(numbers), seed=seed).reshape(-1, 27)
    directions = skeleton.normalize(numbers[:, :27].reshape(-1, 9, 3)).astype(np.float32)
    pelvis = stance.synthesize_pelvis(directions, np.zeros(len(directions)), (), style, seed)
    numbers, places, turns = (_close(part, seam) for part in (numbers, pelvis.place, pelvis.turn))
    weights = _close(_waiting_face(directions, seed), round(seam / skeleton.FPS * RATE))
    rows = np.arange(-2, frames + 3) % frames if loop else np.arange(frames)
    directions = skeleton.normalize(numbers[rows, :27].reshape(-1, 9, 3)).astype(np.float32)
    hands = hand_channels.from_channels(numbers[rows, 27:], directions)
    face = Face(np.concatenate([weights, weights[: int(loop)]]), np.zeros((0, 2), np.float32))
    meta = {"version": VERSION, "style": style, "seed": seed, "idle": {"seconds": seconds, "stillness": stillness}}
    meta |= {"loops": loop, "shows": shown}
    motion = Motion(directions, skeleton.FPS, (), meta, hands, Pelvis(places[rows], turns[rows]), face)
    return motion.at(2 * loop + np.arange(round(seconds * fps) + loop) * (skeleton.FPS / fps), fps)


def listening(frames: int, style: str = "", seed: int = 0) -> np.ndarray:
    """Return numbers ``(frames, 27 + SIZE)`` of a person who listens: directions less those of the stance, and hands."""
    numbers, _ = _assemble(frames, 0, style, 1.0, np.random.default_rng((seed, zlib.crc32(style.encode()), 0x115)), True)
    return np.concatenate([numbers[:, :27] - listener().ravel(), numbers[:, 27:]], axis=1)


def listener() -> np.ndarray:
    """Return the directions ``(9, 3)`` of captured listeners as they stand."""
    return _table("listener")[0].numbers[0, :27].reshape(9, 3)


def answer(kind: str, rng: np.random.Generator) -> np.ndarray:
    """Return numbers ``(frames, 27 + SIZE)`` of a captured answer of a ``kind``, accept or deny."""
    found = [one.numbers for one in _table("listener") if f"_{kind}_" in one.kind]
    return _varied(found[int(rng.integers(len(found)))], rng)


@cache
def _table(name: str = "idle") -> tuple[Stretch, ...]:
    with npz.open_arrays(Path(__file__).parents[1] / "assets" / f"{name}.npz") as data:
        names, ends, steps = (data[name] for name in ("names", "ends", "steps"))
    tracks = np.split(steps.T, ends[:-1])
    parts = [(name[0], name[2:].removeprefix("idle_").rpartition("_")[0]) for name in names.tolist()]
    kinds = [kind if kind in _FIDGETS else name for (_, kind), name in zip(parts, names.tolist(), strict=True)]
    numbers = [rest.remove_jitter_of_numbers(np.cumsum(track, 0, dtype=int) / STEPS) for track in tracks]
    return tuple(Stretch(body, kind, track) for (body, _), kind, track in zip(parts, kinds, numbers, strict=True))


def _assemble(
    frames: int, seam: int, style: str, stillness: float, rng: np.random.Generator, listens: bool = False
) -> tuple[np.ndarray, list[list]]:
    """Return numbers ``(frames, 27 + SIZE)`` of pieces led into each other, and fidgets as [kind, second].

    The last ``seam`` frames, 0 if nothing is repeated, will be led into the first ones: no fidget is there."""
    taste, size = np.random.default_rng((zlib.crc32(style.encode()), 0x1D7E)), 1.0 if listens else 1.15 - 0.65 * stillness
    table = [one for one in _table("listener") if "_listen_" in one.kind] if listens else _table()
    habits = {kind: taste.lognormal(0, 0.5) for kind in sorted({one.kind for one in table})}
    body, join = rng.choice(sorted({one.body for one in table})), round(_JOIN * skeleton.FPS)
    period = (frames - seam) / skeleton.FPS if seam else np.inf  # around a loop, moments are near on either side
    home = np.mean([one.numbers[0] for one in table if one.body == body], axis=0)
    weights = np.array([habits[one.kind] * _FIDGETS.get(one.kind, 1.0) * _OTHER_BODY ** (one.body != body) for one in table])
    fidget, lengths = np.array([[one.kind in _FIDGETS, len(one.numbers)] for one in table]).T
    used: dict[str, list[float]] = {}
    gap = _CALM_SECONDS * _STILL_FACTOR**stillness if stillness < 1 else np.inf
    track, shown, next_fidget = np.empty((0, len(STEPS))), [], gap * rng.uniform(0.3, 1.0)
    while len(track) < frames:
        now = max(len(track) - join, 0) / skeleton.FPS
        near = [[min((now - at) % period, (at - now) % period) for at in used.get(one.kind, ())] for one in table]
        away = np.array([min(each, default=1e3) for each in near])
        fits = fidget * (away > APART) * (len(track) >= seam) * (len(track) + 1.2 * lengths < frames - seam)
        fidgets = now >= next_fidget and fits.any()
        free = weights * (fits if fidgets else (1 - fidget) * (away >= min(APART, max(away[fidget == 0]))))
        one = table[int(rng.choice(len(table), p=free / free.sum()))]
        numbers = one.numbers
        if fidgets:
            shown.append([one.kind, round(now, 2)])
            next_fidget = now + len(numbers) / skeleton.FPS + rng.uniform(0.4, 1.6) * gap
        else:
            wanted = min(rng.uniform(*_PIECE), max(next_fidget - now, 0) + 2.0)
            length = min(round(wanted * skeleton.FPS), len(numbers))
            first = int(rng.integers(len(numbers) - length + 1))
            numbers = home + size * (numbers[first : first + length] - home)
        numbers = _varied(numbers, rng)
        used.setdefault(one.kind, []).extend([now, now + len(numbers) / skeleton.FPS])
        over = min(join, len(track))
        share = ramp(np.arange(over), -1, over)[:, None]
        track[len(track) - over :] += share * (numbers[:over] - track[len(track) - over :])
        track = np.concatenate([track, numbers[over:]])
    return track[:frames], shown


def _varied(numbers: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a stretch slower, and half of the times mirrored."""
    if rng.random() < 0.5:
        directions = skeleton.mirror(numbers[:, :27].reshape(-1, 9, 3)).reshape(-1, 27)
        numbers = np.concatenate([directions, hand_channels.mirror_channels(numbers[:, 27:])], axis=1)
    return sample_cubic(numbers, np.arange(0, len(numbers) - 1, rng.uniform(0.85, 1.0)))


def _waiting_face(directions: np.ndarray, seed: int) -> np.ndarray:
    """Return weights of a silent face that looks ahead and blinks, its eyes ahead of the turning head."""
    count, random = round(len(directions) / skeleton.FPS * RATE), np.random.default_rng((seed, 23))
    ahead = np.broadcast_to(skeleton.MEAN_UNIT, directions.shape)  # who waits looks where the head points, at no listener
    look, shifts = eyes.gaze(np.zeros((0, 2)), ahead, count, random)
    lead = eyes.head_angles(directions, count, _GAZE_LEAD) - eyes.head_angles(directions, count)
    look = look / GAZE_DEGREES + np.tanh(_GAZE_SHARE * lead / GAZE_DEGREES)
    shut = eyes.lid_closure(eyes.blink_times(np.zeros((0, 2)), shifts, count, random), count)
    weights = np.zeros((count, len(CHANNELS)))
    for name, column in (("BLINK_LEFT", shut), ("BLINK_RIGHT", shut), ("LOOK_LEFT", look[:, 0]), ("LOOK_UP", look[:, 1])):
        weights[:, channel(name)] = column
    return np.clip(weights, -1, 1)


def _close(track: np.ndarray, seam: int) -> np.ndarray:
    """Return a track without its last ``seam`` rows (0: as it is), which lead over into its beginning instead."""
    frames = len(track) - seam
    share = ramp(np.arange(seam), -1, seam)[:, None]
    return np.concatenate([track[frames:] + share * (track[:seam] - track[frames:]), track[seam:frames]])
