"""Which word gets which gesture, and when its phases fall: the director's plan for one performer and one talk.

After McNeill and Kendon: a stroke lands on or just before the stressed syllable of its word, preparation starts before
it, the hands hold, and go back to rest only if the next stroke is far. Every choice is a function of performer, words
and prosody, never a coin toss, so that a network can learn it.
"""

import zlib
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...motion import skeleton
from ...sound.prosody import Accent
from .lexicon import Lexicon
from .library import Gesture
from .scene import Scene
from .speakers import Performer

LEAD = 0.04
"""Seconds by which a stroke's emphasis precedes the accent's energy peak."""

KEEP_UP = 1.3
"""Seconds, scaled by the performer's hold, that are added to 1.4 s: the hands stay up if the next stroke lands within."""

LONG_SILENCE = 1.3
"""Seconds of silence in which the hands go down whatever comes next."""

_SETTLE = 0.12

_FIRST = 1.0
"""Seconds before which no stroke lands: the recording begins with the hands at rest."""

_HEIGHTS = {"low": (-0.4, -0.32, -0.24), "mid": (-0.3, -0.2, -0.05), "high": (-0.18, -0.02, 0.2)}
"""Where the wrist of a beat is for weak, middling and strong accents: metres above the spine joint."""

_CLASP = -0.22
"""The same for the lowest beats of those whose hands rest before the belly: they rise from there."""

_STRONG = (0.52, 0.68)
"""Strengths from which an accent is middling and strong."""


@dataclass(frozen=True)
class Stroke:
    """A gesture with performance times of its clip's phases (s) and its amplitude.

    ``until``: per arm (left, right), when it starts back to rest or hands over; ``chained``: the hands are already up.
    """

    gesture: Gesture
    onset: float
    ready: float
    emphasis: float
    end: float
    until: tuple[float, float]
    rest: tuple[float, float]
    amplitude: float
    chained: bool


class Vocabulary:
    """The gestures of one performer, by meaning, most liked first, and what words mean to him."""

    def __init__(self, performer: Performer, library: list[Gesture], lexicon: Lexicon):
        self.performer, self.lexicon = performer, lexicon
        self._by_meaning: dict[str, list[Gesture]] = {}
        for gesture in sorted(library, key=self._dislike):
            self._by_meaning.setdefault(gesture.meaning, []).append(gesture)

    def _dislike(self, gesture: Gesture) -> tuple:
        performer = self.performer
        order = (*performer.families, "").index(gesture.family) if gesture.family in performer.families else 9
        other = {"left": "right", "right": "left", "both": ""}[performer.hand]
        wrong_hand = 2 if gesture.hand == other else 0 if gesture.hand == performer.hand else 1
        unfit = gesture.intense and performer.size < 1
        # a gesture and its mirror image are liked equally, so that the other hand does the same
        unfit = unfit or (performer.rest == "front" and gesture.height < _CLASP - 0.06)
        return (unfit, order >= 9, wrong_hand, order, _hash(performer.name, gesture.name.rstrip("~")), gesture.name)

    def meanings(self) -> set[str]:
        """What can be shown."""
        return set(self._by_meaning)

    def meaning(self, word: str) -> str | None:
        """What this performer shows for a word: the same meanings are always, or never, shown."""
        meaning = self.lexicon.meaning(word)
        shown = meaning in self._by_meaning and _hash(self.performer.name, meaning) % 100 < 100 * self.performer.semantic
        return meaning if shown else None

    def choose(self, meaning: str, strength: float) -> Gesture:
        """The gesture for a meaning: of the two best liked, the larger one for a strong accent."""
        options = sorted(self._by_meaning[meaning][:2], key=lambda gesture: gesture.size)
        return options[-1 if strength > _STRONG[1] else 0]

    def beat(self, strength: float, rising: bool) -> Gesture:
        """A beat by the accent's strength and by whether the voice is high or low there."""
        round_ = self._beats[int(strength > _STRONG[0]) + int(strength > _STRONG[1])]
        return round_[int(rising) % len(round_)]

    @cached_property
    def _beats(self) -> list[list[Gesture]]:
        """Two beats each for weak, middling and strong accents: of fitting height, one hand first, then both."""
        performer = self.performer
        pool = self._by_meaning["beat"] + self._by_meaning["list"] + self._by_meaning["offer"]
        rounds = []
        for level in range(3):
            wanted = max(_HEIGHTS[performer.height][level], (_CLASP + 0.06 * level) if performer.rest == "front" else -1.0)
            hand = "both" if level == 2 and not performer.one_handed else performer.hand if level < 1 else None

            def unfit(gesture: Gesture, wanted=wanted, hand=hand) -> float:
                intense, strange, wrong_hand, order, *_ = self._dislike(gesture)
                wrong = 0.2 * (hand is not None and gesture.hand != hand) + 0.08 * wrong_hand
                wrong += 0.006 * max(50 - gesture.bend, 0)  # outstretched arms are no beats
                return abs(gesture.height - wanted) + wrong + 0.5 * intense + 0.15 * strange + 0.03 * min(order, 3)

            taken: list[Gesture] = []
            for gesture in sorted(pool, key=unfit):
                same = (gesture.label.rstrip("0123456789"), gesture.family, gesture.hand == "both" or gesture.hand)
                if all(same != (g.label.rstrip("0123456789"), g.family, g.hand == "both" or g.hand) for g in taken):
                    taken.append(gesture)
                if len(taken) == 2:
                    break
            rounds.append(taken)
        return rounds


def plan(vocabulary: Vocabulary, scene: Scene) -> list[Stroke]:
    """Strokes in order of time for one performance."""
    performer = vocabulary.performer
    strokes: list[Stroke] = []
    last = None
    for accent in _select(vocabulary, scene):
        arousal = scene.arousal(accent)
        near = last is not None and _holds(performer, scene, last, accent)
        meaning = _meaning(vocabulary, scene, accent)
        if meaning:
            gesture = vocabulary.choose(meaning, accent.strength)
        else:
            gesture = vocabulary.beat(accent.strength, scene.pitch(accent) > 0)
        amplitude = performer.size * (0.6 + 0.55 * arousal) * (0.82 + 0.3 * accent.strength)
        amplitude *= 1 + 0.22 * scene.openness
        strokes.append(_schedule(performer, gesture, accent, arousal, float(np.clip(amplitude, 0.25, 1.12)), near))
        last = accent
    return _hand_over(strokes)


def _holds(performer: Performer, scene: Scene, last: Accent, accent: Accent) -> bool:
    """Whether the hands stay up from the last stroke to this one: it is near, and no long silence lies between."""
    return accent.time - last.time < 1.4 + KEEP_UP * performer.hold and scene.silence(last.time, accent.time) < LONG_SILENCE


def _meaning(vocabulary: Vocabulary, scene: Scene, accent: Accent) -> str | None:
    """The meaning that an accented word claims, if this performer shows it."""
    word = scene.word(accent)
    return vocabulary.meaning(word.text) if word is not None and accent.strength > 0.1 else None


def _select(vocabulary: Vocabulary, scene: Scene) -> list[Accent]:
    """Accents that get a stroke: main ones first, then by strength, none nearer than the performer's gap to another."""
    performer = vocabulary.performer
    scores = []
    for accent in scene.accents:
        lively = scene.arousal(accent) - 0.5
        threshold = performer.threshold - 0.03 - 0.16 * lively - 0.17 * scene.rate
        score = accent.strength + (0.2 if _meaning(vocabulary, scene, accent) else 0)
        if score > threshold:
            gap = performer.gap * (1 - 0.5 * lively) * (1 - 0.4 * scene.rate)
            scores.append((-score - 0.3 * accent.main, accent, gap))
    taken: list[Accent] = []
    for _, accent, gap in sorted(scores, key=lambda item: item[0]):
        if accent.time > _FIRST and all(abs(accent.time - other.time) >= gap for other in taken):
            taken.append(accent)
    return sorted(taken, key=lambda accent: accent.time)


def _schedule(performer: Performer, gesture: Gesture, accent: Accent, arousal: float, amplitude: float, near: bool) -> Stroke:
    """Phases around the accent from the clip's own timing, the performer's tempo and the arousal."""
    clip, at = gesture.clip, accent.time - LEAD
    tempo = performer.tempo * (0.8 + 0.45 * arousal)
    lift = max((clip.ready - clip.onset) / tempo, 0.3)
    stroke = float(np.clip((clip.emphasis - clip.ready) / tempo, 0.2, 0.55))
    after = float(np.clip((clip.end - clip.emphasis) / tempo, 0.1, 0.4))
    hold = float(np.clip((clip.relax - clip.end) / tempo, 0.1, 0.7)) * performer.hold
    sink = float(np.clip((clip.rest - clip.relax) / tempo, 0.55, 1.3))
    # wide ways take longer, or the hands would fly
    lift = max(lift, 0.3 + 0.5 * gesture.size * amplitude - stroke)
    sink = max(sink, 0.5 + 0.6 * gesture.size * amplitude)
    ready, end = at - stroke, at + after
    return Stroke(gesture, max(ready - lift, 0.0), ready, at, end, (end + hold,) * 2, (end + hold + sink,) * 2, amplitude, near)


def _hand_over(strokes: list[Stroke]) -> list[Stroke]:
    """Fit neighbours together: a preparation starts after the last stroke has landed, and an arm that is soon needed
    again holds until the next preparation instead of sinking."""
    for k in range(1, len(strokes)):
        last, this = strokes[k - 1], strokes[k]
        free = last.emphasis + min(_SETTLE, 0.25 * (this.emphasis - last.emphasis))
        if this.chained:
            # the hands come from where the last stroke left them
            way = 0.3 + 0.55 * _distance(last, this)
            this = replace(this, onset=min(this.onset, this.ready - way))
        if this.onset < free:
            # too near: share what time there is between preparation and stroke
            room = this.emphasis - free
            this = replace(this, onset=free, ready=max(min(this.ready, this.emphasis - 0.15), free + 0.5 * room))
        strokes[k] = this
        until, rest = list(last.until), list(last.rest)
        for arm in range(2):
            needed = this.gesture.clip.hands[arm] > 0.35
            if needed and this.chained:
                until[arm], rest[arm] = this.ready, this.ready + 0.6
        end = min(last.end, max(free, this.onset))
        strokes[k - 1] = replace(last, end=end, until=tuple(max(u, end) for u in until), rest=tuple(rest))
    return strokes


def _distance(last: Stroke, this: Stroke) -> float:
    """How far (m) the wrists go from one stroke's end to where the next may begin."""
    before, after = last.gesture.clip, this.gesture.clip
    poses = before.at(np.array([before.relax])), after.at(np.array([after.ready]))
    wrists = [skeleton.to_positions(pose[0])[[6, 9]] for pose in poses]
    used = np.array(this.gesture.clip.hands) > 0.35
    return float(np.linalg.norm(wrists[1] - wrists[0], axis=-1)[used].max(initial=0.0))


def _hash(*parts: str) -> int:
    """A stable number from names (Python's own hash changes from run to run)."""
    return zlib.crc32("\n".join(parts).encode())
