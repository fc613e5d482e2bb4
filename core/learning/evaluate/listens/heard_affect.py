"""Whether arousal, valence and dominance are heard in acted speech, of all speakers and of the worst; no network is asked."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ....motion.skeleton import FPS
from ....settings import AFFECTS
from ....sound import affect
from ....sound.audio import SAMPLE_RATE
from .emotion import share_above, silent
from .recordings import EMOTIONS, HIGH, LOW, Acted, preceded

TOLD = {
    "high from low arousal": ("arousal", HIGH, LOW),
    "high arousal from neutral": ("arousal", HIGH, ("neutral",)),
    "neutral from low arousal": ("arousal", ("neutral",), LOW),
    "joy from anger": ("valence", ("joy",), ("anger",)),
    "joy from all else": ("valence", ("joy",), tuple(emotion for emotion in EMOTIONS if emotion != "joy")),
    "anger from fear and sadness": ("dominance", ("anger",), ("fear", "sadness")),
}
"""What is told: the affect by which, and the emotions that should have more and less of it."""
_CODES = re.compile(r"(?:^|-)(\d\d)[ab]\d\d[WLAFTN][a-z]?$"), re.compile(r"(?:^|-)(?:\d\d-){6}(\d\d)$")
"""Names of two well-known databases; their group is the speaker."""


@dataclass(frozen=True)
class Heard:
    """The ``speaker`` and ``emotion`` of a recording as its name tells them, and the mean ``affect`` ``(3,)`` heard in it."""

    speaker: str
    emotion: str
    affect: np.ndarray


def hear_all(
    recordings: Sequence[Acted], reading: np.ndarray | None = None, progress: Callable[[str, float], None] = silent
) -> list[Heard]:
    """Hear every recording; with a ``reading`` ``(n,)`` before it, what is heard after that."""
    result = []
    for number, acted in enumerate(recordings):
        progress("hear acted speech", number / len(recordings))
        talk, start = (acted.talk, 0.0) if reading is None else preceded(acted.talk, reading)
        frames = max(int(len(talk.audio) / SAMPLE_RATE * FPS), 2)
        heard = affect.hear(talk.audio, frames)[min(int(start * FPS), frames - 1) :]
        result.append(Heard(speaker_of(acted.talk.name), acted.emotion, heard.mean(0)))
    return result


def speaker_of(name: str) -> str:
    """Return the speaker that a recording's name tells: by the codes of two well-known databases, or what stands before the
    emotion; "" for none.
    """
    for pattern in _CODES:
        if match := pattern.search(name):
            return match[1]
    words = {word for known in EMOTIONS.values() for word in known}
    parts = re.split(r"[-_ /]+", name)
    before = [row for row, part in enumerate(parts) if part.lower() in words]
    return "-".join(parts[: before[0]]) if before else ""


def told(heard: Sequence[Heard]) -> dict[str, dict[str, float]]:
    """Return the share of pairs told right (0.5: not at all) by each of :data:`TOLD`: of ``all``, and of the ``worst`` speaker
    of those that have both; NaN where there are none.
    """
    result = {}
    for name, (by, more, less) in TOLD.items():
        shares = [_share(own, by, more, less) for own in (heard, *_by_speaker(heard))]
        result[name] = {"all": shares[0], "worst": min((one for one in shares[1:] if one == one), default=float("nan"))}
    return result


def _share(heard: Sequence[Heard], by: str, more: Sequence[str], less: Sequence[str]) -> float:
    column = AFFECTS.index(by)
    groups = ([one.affect[column] for one in heard if one.emotion in group] for group in (more, less))
    return share_above(*(np.array(group) for group in groups))


def _by_speaker(heard: Sequence[Heard]) -> list[list[Heard]]:
    return [[one for one in heard if one.speaker == name] for name in dict.fromkeys(one.speaker for one in heard)]


def page(heard: Sequence[Heard], after: Sequence[Heard] = ()) -> str:
    """Return tables in Markdown: what is told, ``after`` a reading, too, and the mean affect of each emotion."""
    speakers = len(dict.fromkeys(one.speaker for one in heard))
    columns = [told(heard), *([told(after)] if after else [])]
    head = ["told (0.5: not at all)", "all", "worst speaker", *(["after a reading", "worst then"] if after else [])]
    lines = [f"{len(heard)} recordings, {speakers} speakers.", "", _row(head), _row(["---"] * len(head))]
    for name in TOLD:
        values = [column[name][key] for column in columns for key in ("all", "worst")]
        if values[0] == values[0]:
            lines.append(_row([name, *(f"{value:.2f}" for value in values)]))
    lines += ["", _row(["emotion", "recordings", *AFFECTS]), _row(["---"] * 5)]
    for emotion in dict.fromkeys(one.emotion for one in heard):
        rows = np.array([one.affect for one in heard if one.emotion == emotion])
        lines.append(_row([emotion, str(len(rows)), *(f"{value:+.2f}" for value in rows.mean(0))]))
    return "\n".join(lines)


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
