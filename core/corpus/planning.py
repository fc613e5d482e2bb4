"""Which word gets which gesture, and when its phases fall: the director's plan for one performer and one talk.

After McNeill and Kendon: a stroke lands on or just before the stressed syllable of its word, preparation starts before
it, the hands hold, and go back to rest only if the next stroke is far. Every choice is a function of performer, words
and prosody, never a coin toss, so that a network can learn it.
"""

import zlib
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .. import skeleton
from . import lexicon
from .library import Gesture
from .prosody import Accent
from .speakers import Performer
from .speech import Speech

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


@dataclass(frozen=True)
class Stroke:
    """A gesture with performance times of its clip's phases (s) and its amplitude.

    ``until``: per arm (left, right), when it starts back to rest or hands over; ``chained``: the hands are already up.
    """

    gesture: Gesture
    word: int
    onset: float
    ready: float
    emphasis: float
    end: float
    until: tuple[float, float]
    rest: tuple[float, float]
    amplitude: float
    chained: bool


class Vocabulary:
    """The gestures of one performer, by meaning, most liked first."""

    def __init__(self, performer: Performer, library: list[Gesture]):
        self.performer = performer
        self._by_meaning: dict[str, list[Gesture]] = {}
        for gesture in sorted(library, key=self._dislike):
            self._by_meaning.setdefault(gesture.meaning, []).append(gesture)

    def _dislike(self, gesture: Gesture) -> tuple:
        performer = self.performer
        order = (*performer.families, "").index(gesture.family) if gesture.family in performer.families else 9
        other = {"left": "right", "right": "left", "both": ""}[performer.hand]
        wrong_hand = 2 if gesture.hand == other else 0 if gesture.hand == performer.hand else 1
        unfit = gesture.intense and performer.size < 1
        return (unfit, order >= 9, wrong_hand, order, _hash(performer.name, gesture.name))

    def meanings(self) -> set[str]:
        """What can be shown."""
        return set(self._by_meaning)

    def choose(self, meaning: str, word: str) -> Gesture:
        """The performer's gesture for a word: one of at most three for its meaning, always the same for the same word."""
        options = self._by_meaning[meaning][:3]
        return options[_hash(self.performer.name, word) % len(options)]

    def beat(self, strength: float, position: int) -> Gesture:
        """A beat by the accent's strength and its position since the hands went up; repeats vary in a fixed round."""
        round_ = self._beats[int(strength > 0.48) + int(strength > 0.62)]
        return round_[position % len(round_)]

    @cached_property
    def _beats(self) -> list[list[Gesture]]:
        """Four beats each for weak, middling and strong accents: of fitting height, one hand first, then both."""
        performer = self.performer
        pool = self._by_meaning["beat"] + self._by_meaning["list"] + self._by_meaning["offer"]
        rounds = []
        for level in range(3):
            wanted = _HEIGHTS[performer.height][level]
            hand = "both" if level == 2 and performer.name != "stern" else performer.hand if level < 1 else None

            def unfit(gesture: Gesture, wanted=wanted, hand=hand) -> float:
                intense, strange, wrong_hand, order, _ = self._dislike(gesture)
                wrong = 0.2 * (hand is not None and gesture.hand != hand) + 0.08 * wrong_hand
                return abs(gesture.height - wanted) + wrong + 0.5 * intense + 0.15 * strange + 0.03 * min(order, 3)

            taken: list[Gesture] = []
            for gesture in sorted(pool, key=unfit):
                same = (gesture.label.rstrip("0123456789"), gesture.family, gesture.hand == "both" or gesture.hand)
                if all(same != (g.label.rstrip("0123456789"), g.family, g.hand == "both" or g.hand) for g in taken):
                    taken.append(gesture)
                if len(taken) == 4:
                    break
            rounds.append(taken)
        return rounds


def plan(performer: Performer, vocabulary: Vocabulary, speech: Speech, accents: list[Accent]) -> list[Stroke]:
    """Strokes in order of time for one performance."""
    chosen = _select(performer, vocabulary, speech, accents)
    strokes: list[Stroke] = []
    position = 0
    for k in chosen:
        accent, word = accents[k], speech.words[k]
        arousal = float(speech.affect[word.sentence][1])
        near = bool(strokes) and _holds(performer, speech, strokes[-1], k, accent.time)
        position = position + 1 if near else 0
        meaning = _meaning(performer, vocabulary, word.text, accent)
        gesture = vocabulary.choose(meaning, word.text) if meaning else vocabulary.beat(accent.strength, position)
        amplitude = performer.size * (0.68 + 0.42 * arousal) * (0.8 + 0.35 * accent.strength)
        strokes.append(_schedule(performer, gesture, k, accent.time - LEAD, arousal, min(amplitude, 1.3), near))
    return _hand_over(performer, strokes, speech.duration)


def _holds(performer: Performer, speech: Speech, last: Stroke, word: int, time: float) -> bool:
    """Whether the hands stay up from the last stroke to this word: it is near, and no long silence lies between."""
    between = speech.words[last.word : word + 1]
    silence = max((b.start - a.end for a, b in zip(between, between[1:], strict=False)), default=0.0)
    return time - last.emphasis < 1.4 + KEEP_UP * performer.hold and silence < LONG_SILENCE


def _meaning(performer: Performer, vocabulary: Vocabulary, word: str, accent: Accent) -> str | None:
    """The meaning a word claims: if known, in the vocabulary, and accented enough for this performer."""
    meaning = lexicon.meaning(word)
    known = meaning in vocabulary.meanings()
    # the same word is always (or never) one that this performer shows
    willing = _hash(performer.name, "willing", word) % 100 < 100 * performer.semantic
    return meaning if known and willing and accent.strength > 0.1 else None


def _select(performer: Performer, vocabulary: Vocabulary, speech: Speech, accents: list[Accent]) -> list[int]:
    """Indices of words that get a stroke: strongest first, none nearer than the performer's gap to one already taken."""
    scores = []
    for k, (word, accent) in enumerate(zip(speech.words, accents, strict=True)):
        arousal = float(speech.affect[word.sentence][1])
        threshold = performer.threshold + 0.1 * (0.5 - arousal)
        score = accent.strength + (0.34 if _meaning(performer, vocabulary, word.text, accent) else 0)
        if score > threshold:
            scores.append((-score, k, performer.gap * (1.25 - 0.5 * arousal)))
    taken: list[int] = []
    for _, k, gap in sorted(scores):
        if accents[k].time > _FIRST and all(abs(accents[k].time - accents[j].time) >= gap for j in taken):
            taken.append(k)
    return sorted(taken)


def _schedule(
    performer: Performer, gesture: Gesture, word: int, at: float, arousal: float, amplitude: float, near: bool
) -> Stroke:
    """Phases around the emphasis ``at`` from the clip's own timing, the performer's tempo and the arousal."""
    clip = gesture.clip
    tempo = performer.tempo * (0.85 + 0.35 * arousal)
    lift = max((clip.ready - clip.onset) / tempo, 0.3)
    stroke = float(np.clip((clip.emphasis - clip.ready) / tempo, 0.2, 0.55))
    after = float(np.clip((clip.end - clip.emphasis) / tempo, 0.1, 0.4))
    hold = float(np.clip((clip.relax - clip.end) / tempo, 0.1, 0.7)) * performer.hold
    sink = float(np.clip((clip.rest - clip.relax) / tempo, 0.55, 1.3))
    # wide ways take longer, or the hands would fly
    lift = max(lift, 0.3 + 0.5 * gesture.size * amplitude - stroke)
    sink = max(sink, 0.5 + 0.6 * gesture.size * amplitude)
    ready, end = at - stroke, at + after
    return Stroke(
        gesture, word, max(ready - lift, 0.0), ready, at, end, (end + hold,) * 2, (end + hold + sink,) * 2, amplitude, near
    )


def _hand_over(performer: Performer, strokes: list[Stroke], duration: float) -> list[Stroke]:
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
