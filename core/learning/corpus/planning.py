"""Plans the strokes of one performance of a talk: the gesture of each chosen accent and the times of its phases.

After McNeill and Kendon: a stroke lands on or just before the stressed syllable of its word, preparation starts before
it, the hands hold, and leave the gesture only if the next stroke is far. Gestures are drawn at random: the same performer
shows the same word with another gesture each time, and every take of a talk is another performance.

Only strokes far enough apart are performed (:mod:`directing`); between them, the body talks as captured.
"""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from ...motion import skeleton
from ...sound.prosody import Accent
from . import accent_choice, variation
from .lexicon import Lexicon
from .library import Gesture
from .repertoire import BEAT, MEMORY, Repertoire, StrokeWish
from .scene import Scene
from .speakers import Performer
from .variation import ArmPart

LEAD = 0.02
"""Seconds by which a stroke's emphasis precedes the accent's energy peak."""

_NEAR, _NEAR_HOLD = 1.4, 1.3
"""The hands stay up if the next stroke lands within these seconds, plus these times the performer's hold."""

LONG_SILENCE = 1.3
"""Seconds of silence in which no gesture is held."""

MIN_PARTICIPATION = 0.35
"""Participation in a clip (9 degrees of movement) from which an arm counts as gesturing."""

_SETTLE = 0.12
"""Seconds between a stroke's emphasis and the next preparation, at least."""

_HEIGHTS = {"low": (-0.38, -0.28, -0.18), "mid": (-0.22, -0.09, 0.05), "high": (-0.1, 0.06, 0.22)}
"""Height of the wrist for weak, medium and strong accents: metres above the spine joint."""

_LIFTS = {"low": 0.0, "mid": 6.0, "high": 14.0}
"""Degrees by which clips are rotated upwards: scaled down they would stay below the wanted height."""

_STRENGTH_LEVELS = (0.52, 0.68)
"""Strengths from which an accent is medium and strong."""
_TWO_HANDED = frozenset({"big", "all", "small", "unknown", "thing"})
"""Meanings that are always shown by both hands."""


@dataclass(frozen=True)
class Stroke:
    """A gesture with performance times of its clip's phases (s) and its amplitude.

    ``until`` and ``rest``: per arm (left, right), when its hold ends and when it is back in talk. ``parts``: of the left and
    the right arm, None for one that goes on talking. ``side``: place of the stroke in a list or a contrast, -1 left to 1
    right. ``said``: the meaning comes from the words.
    """

    gesture: Gesture
    onset: float
    ready: float
    emphasis: float
    end: float
    until: tuple[float, float]
    rest: tuple[float, float]
    amplitude: float
    meaning: str = BEAT
    parts: tuple[ArmPart | None, ArmPart | None] = (None, None)
    side: float = 0.0
    said: bool = True

    @property
    def hands(self) -> tuple[float, float]:
        """1 for each arm (left, right) that takes part, else 0."""
        left, right = self.parts
        return float(left is not None), float(right is not None)

    @property
    def hand(self) -> int:
        """0 left, 1 right, 2 both."""
        left, right = self.hands
        return 2 if left and right else 0 if left else 1

    @property
    def size(self) -> float:
        """Approximate path of a wrist in metres."""
        return self.amplitude * max(part.gesture.size * part.extent[1] for part in self.parts if part is not None)


def plan(repertoire: Repertoire, lexicon: Lexicon, scene: Scene, random: np.random.Generator) -> list[Stroke]:
    """Return the strokes of one performance in order of time."""
    performer = repertoire.performer
    meanings = accent_choice.draw_meanings(lexicon, repertoire, scene, random)
    strokes: list[Stroke] = []
    chained: list[bool] = []
    memory: deque[str] = deque(maxlen=MEMORY)
    last, side = None, 1.0
    for accent in accent_choice.draw_accents(performer, scene, meanings, random):
        near = last is not None and _holds(performer, scene, last, accent)
        meaning, said = accent_choice.draw_meaning(accent, meanings, repertoire, random)
        wish = _wish(performer, scene, accent, meaning, strokes[-1] if near else None, random)
        gesture = repertoire.draw(random, meaning, wish, memory)
        stroke = _schedule(performer, scene, gesture, accent, random)
        side = _next_side(meaning, side if near or meaning == "however" else -1.0)
        stroke = replace(stroke, meaning=meaning, said=said, side=side if meaning in ("count", "list", "however") else 0.0)
        stroke = replace(stroke, parts=_draw_parts(repertoire, stroke, wish, memory, random))
        strokes.append(stroke)
        chained.append(near)
        last = accent
    return _join_phases(strokes, chained)


def _holds(performer: Performer, scene: Scene, last: Accent, accent: Accent) -> bool:
    """Return whether the hands stay up from the last stroke to this one: it is near and no long silence is between."""
    return (
        accent.time - last.time < _NEAR + _NEAR_HOLD * performer.hold and scene.silence(last.time, accent.time) < LONG_SILENCE
    )


def _wish(
    performer: Performer, scene: Scene, accent: Accent, meaning: str, before: Stroke | None, random: np.random.Generator
) -> StrokeWish:
    level = int(accent.strength > _STRENGTH_LEVELS[0]) + int(accent.strength > _STRENGTH_LEVELS[1])
    height = _HEIGHTS[performer.height][level] + 0.03 * np.clip(scene.pitch(accent) / 3, -1, 1) + random.normal(0, 0.09)
    height += 0.06 * scene.valence + 0.05 * scene.dominance
    size = 0.52 * performer.size * (0.75 + 0.5 * accent.strength) * np.exp(random.normal(0, 0.25))
    if meaning in _TWO_HANDED or random.random() < performer.both + 0.12 * (level - 1) * (performer.both > 0.2):
        hand = "both"
    elif performer.hand == "both":
        hand = ("left", "right")[int(random.random() < 0.5)]
    else:
        other = {"left": "right", "right": "left"}[performer.hand]
        hand = performer.hand if random.random() < 0.95 else other
    wrists = None
    if before is not None:
        pose = before.gesture.clip.at(np.array([before.gesture.clip.relax]))[0]
        wrists = skeleton.to_positions(pose)[[6, 9]]
    return StrokeWish(hand, float(height), float(size), accent.strength > 0.6 and performer.size > 0.8, wrists)


def _draw_parts(
    repertoire: Repertoire, stroke: Stroke, wish: StrokeWish, memory: deque[str], random: np.random.Generator
) -> tuple[ArmPart | None, ArmPart | None]:
    """Draw each arm's part: the same clip for both arms, one arm alone, or different clips with different timing."""
    performer, gesture = repertoire.performer, stroke.gesture
    pair: list[Gesture | None] = [gesture if share > MIN_PARTICIPATION else None for share in gesture.clip.hands]
    delays = [0.0, 0.0]
    if not any(pair):
        pair = [gesture, gesture]  # a shrug of the shoulders alone
    if wish.hand != "both" and all(pair):
        pair[0 if wish.hand == "right" else 1] = None
    elif wish.hand == "both" and stroke.meaning not in _TWO_HANDED:
        alone = not all(pair)
        arm = pair.index(None) if alone else int(random.random() < 0.5)
        if alone and random.random() > performer.apart:
            # the other arm mirrors the gesture, with its own direction and size
            pair[arm] = gesture.mirrored()
            delays[arm] = float(np.clip(random.normal(0.02, 0.04), -0.06, 0.12))
        elif alone or random.random() < performer.apart:
            own = replace(wish, hand=("left", "right")[arm], wrists=None)
            other = repertoire.draw(random, BEAT, own, memory)
            if other.clip.hands[arm] > MIN_PARTICIPATION:
                pair[arm] = other
                delays[arm] = float(np.clip(random.normal(0.02, 0.07), -0.12, 0.2))
    return variation.draw_parts(random, (pair[0], pair[1]), performer.plane, (delays[0], delays[1]), _LIFTS[performer.height])


def _next_side(meaning: str, side: float) -> float:
    """Return the next place, -1 left to 1 right: lists step to the right, contrasts alternate sides."""
    if meaning in ("count", "list"):
        return side + 0.5 if side < 0.9 else -1.0
    return -np.sign(side) if meaning == "however" else side


def _next_silence(scene: Scene, time: float) -> float:
    """Return when (s) the next long silence after ``time`` begins, or infinity."""
    pauses = scene.pauses
    long = pauses[(pauses[:, 1] - pauses[:, 0] > LONG_SILENCE) & (pauses[:, 1] > time)]
    return float(max(long[0, 0], time)) if len(long) else float("inf")


def _schedule(
    performer: Performer, scene: Scene, gesture: Gesture, accent: Accent, random: np.random.Generator
) -> Stroke:
    """Place the phases around the accent by the clip's own timing, the performer's tempo and the arousal."""
    clip, arousal = gesture.clip, scene.arousal(accent)
    at = accent.time - LEAD + float(np.clip(random.normal(0, 0.02), -0.05, 0.05))
    amplitude = performer.size * (0.4 + 0.95 * arousal) * (0.72 + 0.48 * accent.strength)
    amplitude *= 1 + 0.2 * scene.valence
    amplitude = float(np.clip(amplitude, 0.2, 1.25))
    tempo = performer.tempo * (0.7 + 0.65 * arousal) * np.exp(random.normal(0, 0.14))
    tempo *= (1 + 0.18 * scene.valence) * (1 - 0.4 * scene.dominance)
    lift = max((clip.ready - clip.onset) / tempo, 0.3)
    stroke = float(np.clip((clip.emphasis - clip.ready) / tempo, 0.2, 0.6))
    after = float(np.clip((clip.end - clip.emphasis) / tempo, 0.1, 0.45))
    hold = float(np.clip((clip.relax - clip.end) / tempo, 0.1, 0.4)) * performer.hold**0.5 * np.exp(random.normal(0, 0.3))
    sink = float(np.clip((clip.rest - clip.relax) / tempo, 0.55, 1.3))
    # long paths take longer, to limit the hands' speed
    lift = max(lift, 0.3 + 0.5 * gesture.size * amplitude - stroke)
    sink = max(sink, 0.5 + 0.6 * gesture.size * amplitude)
    # the hold ends soon after speech ends
    hold = min(hold, max(_next_silence(scene, at) - at - after, 0.1))
    ready, end = at - stroke, at + after
    return Stroke(gesture, max(ready - lift, 0.0), ready, at, end, (end + hold,) * 2, (end + hold + sink,) * 2, amplitude)


def _join_phases(strokes: list[Stroke], chained: list[bool]) -> list[Stroke]:
    """Fit neighbouring strokes together: a preparation starts after the last emphasis, and an arm that soon gestures again
    holds until the next stroke instead of sinking. ``chained``: the hands are still up from the stroke before."""
    for k in range(1, len(strokes)):
        last, this = strokes[k - 1], strokes[k]
        free = last.emphasis + min(_SETTLE, 0.25 * (this.emphasis - last.emphasis))
        if chained[k]:
            # the preparation starts where the last stroke ended
            duration = 0.3 + 0.55 * _distance(last, this)
            this = replace(this, onset=min(this.onset, this.ready - duration))
        if this.onset < free:
            # too near: divide the time between preparation and stroke
            room = this.emphasis - free
            this = replace(this, onset=free, ready=max(min(this.ready, this.emphasis - 0.15), free + 0.5 * room))
        strokes[k] = this
        until, rest = list(last.until), list(last.rest)
        for arm in range(2):
            if this.hands[arm] and chained[k]:
                until[arm], rest[arm] = this.ready, this.ready + 0.6
            elif last.hands[arm] and chained[k]:
                # it sinks during the other arm's preparation
                until[arm], rest[arm] = this.onset, this.onset + rest[arm] - until[arm]
        end = min(last.end, max(free, this.onset))
        strokes[k - 1] = replace(last, end=end, until=tuple(max(u, end) for u in until), rest=tuple(rest))
    return strokes


def _distance(last: Stroke, this: Stroke) -> float:
    """Return the larger distance (m) of the wrists between one stroke's end and the next one's ready pose."""
    distances = []
    for arm, (before, after) in enumerate(zip(last.parts, this.parts, strict=True)):
        if after is not None:
            poses = [last.gesture.clip if before is None else before.gesture.clip, after.gesture.clip]
            poses = poses[0].at(np.array([poses[0].relax]))[0], poses[1].at(np.array([poses[1].ready]))[0]
            wrists = [skeleton.to_positions(pose)[(6, 9)[arm]] for pose in poses]
            distances.append(np.linalg.norm(wrists[1] - wrists[0]))
    return float(max(distances, default=0.0))
