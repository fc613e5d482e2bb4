"""Figures of speaking faces: lip closures, jaw against voice, blinks, and gaze, with values of people.

Values of people to compare with:

- Lips meet for every p, b and m, by which lip synchronisation is judged (Lewis and Parke 1987, "Automated lip-synch and speech
  synthesis for character animation"). Here a closure is hit if lips are closed within a frame of the sound.
- The mouth's opening and the voice's envelope are correlated, both at 2 to 7 Hz (Chandrasekaran et al. 2009, "The natural
  statistics of audiovisual speech").
- Blinks: 26 a minute in conversation, 17 at rest, 4.5 reading (Bentivoglio et al. 1997, "Analysis of blink rate patterns in
  normal subjects").
- Gaze (eyes and head together): speakers look at the listener 41 % of the time (Argyle and Ingham 1972, "Gaze, mutual gaze, and
  proximity"); single speakers 28 to 70 % (Kendon 1967, "Some functions of gaze-direction in social interaction"). They look
  away as they begin to speak and at the listener as they end. The listener is where the head usually points.
- Gaze moves before the head, which turns less for small shifts (Freedman 2008, "Coordination of the eyes and head during visual
  orienting").
"""

from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from ...face import animation, eyes
from ...motion.face import CLOSED_JAW, GAZE_DEGREES, RATE, VISEMES, Face, channel
from ...sound import audio
from ...synthesis.session import Request, Session
from ...words import transcript
from ...words.align import Phone
from ...words.transcript_search import find_transcript

RATES = (24, 60)
"""Frame rates at which closures are checked."""
HUMAN_VALUES = {
    "closures seen": "all",
    "jaw with loudness": "together, at 2 to 7 Hz (Chandrasekaran et al. 2009)",
    "blinks a minute": "26 in conversation (Bentivoglio et al. 1997)",
    "gaze at the listener": "41 % (Argyle and Ingham 1972), 28 to 70 % (Kendon 1967)",
    "as phrases begin, end": "away, at the listener (Kendon 1967)",
    "gaze before the head": "yes (Freedman 2008)",
}
"""Values of people by row of :func:`table`."""
_AT_LISTENER = 10.0
"""Degrees from the listener's eyes that count as looking at the listener."""
_MAX_LAG = 0.5
"""Seconds by which head and gaze are shifted against each other, at most."""
_PHRASE_EDGE = 0.3
"""Seconds after a phrase's begin and before its end in which gaze is measured."""
_VISIBLE = 0.15
"""Weight above which a viseme is visible."""


def measure(recording: str | PathLike) -> dict[str, float]:
    """Measure the face synthesized for a recording with the text file beside it; with text, also lips from sound alone.

    Raises :class:`S2agError` for unreadable input.
    """
    recording = Path(recording)
    text = find_transcript(recording)
    motion = Session().synthesize(Request(recording, transcript=text, face=1.0)).motions[0]
    face = motion.face
    assert face is not None  # the request asks for one
    sound = audio.load(recording)
    aligned = transcript.timed_transcript(sound, text) if text else None
    spoken = animation.analyse(sound, aligned.words, aligned.phones) if aligned else animation.analyse(sound)
    figures = {"seconds": round(face.duration, 2), **behaviour(face, spoken, motion.directions)}
    if aligned is None:
        return figures
    spans = closure_times(spoken.sounds)
    figures |= {f"closures_{fps}": closures_hit(face, spans, fps) for fps in RATES}
    alone = animation.make_face(animation.analyse(sound), motion.directions)
    figures |= {f"closures_by_ear_{fps}": closures_hit(alone, spans, fps) for fps in RATES}
    return figures | {"false_closures_by_ear": false_closures(alone, spans)}


def closure_times(sounds: tuple[Phone, ...]) -> list[tuple[float, float]]:
    """Return the times of sounds with closed lips, ``(start, end)`` in seconds."""
    return [(start, end) for phone, start, end in sounds if phone in ("P", "B", "M")]


def closures_hit(face: Face, spans: list[tuple[float, float]], fps: float) -> float:
    """Return the share of ``spans`` with closed lips within a frame, at ``fps`` frames a second; NaN of none."""
    times = np.flatnonzero(lips_closed(face.frames(fps))) / fps
    hits = [((times >= start - 1 / fps) & (times <= end + 1 / fps)).any() for start, end in spans]
    return float(np.mean(hits)) if hits else float("nan")


def false_closures(face: Face, spans: list[tuple[float, float]], near: float = 0.05) -> float:
    """Return the share of a face's closures that are not within ``near`` seconds of any of ``spans``; NaN of none."""
    wrong = [not any(start <= end_ + near and end >= begin - near for begin, end_ in spans) for start, end in face.closures]
    return float(np.mean(wrong)) if wrong else float("nan")


def behaviour(face: Face, spoken: animation.FaceSpeech, directions: np.ndarray) -> dict[str, float]:
    """Return the figures that need no text: jaw, blinks, gaze of the eyes and of a head with ``directions`` ``(frames, 9, 3)``
    at 15 fps, and the shortest visible viseme in milliseconds."""
    speech = _during(spoken.phrases, len(face.weights))
    head = eyes.head_angles(directions, len(face.weights))
    gaze = GAZE_DEGREES * face.weights[:, [channel("LOOK_LEFT"), channel("LOOK_UP")]] + head
    at = np.hypot(*gaze.T) <= _AT_LISTENER
    begins = np.stack([spoken.phrases[:, 0], spoken.phrases[:, 0] + _PHRASE_EDGE], 1)
    ends = np.stack([spoken.phrases[:, 1] - _PHRASE_EDGE, spoken.phrases[:, 1]], 1)
    shut = face.weights[:, channel("BLINK_LEFT")] > 0.5
    jaw, loud = face.weights[speech, channel("JAW")], spoken.loudness[speech]
    return {
        "jaw_with_loudness": float(np.corrcoef(jaw, loud)[0, 1]) if speech.sum() > 2 and jaw.any() else float("nan"),
        "blinks_a_minute": float((np.diff(shut.astype(int)) > 0).sum() / face.duration * 60),
        "gaze_at_listener": _share(at, speech),
        "gaze_as_phrases_begin": _share(at, _during(begins, len(at))),
        "gaze_as_phrases_end": _share(at, _during(ends, len(at))),
        "gaze_before_head_ms": 1000 * _lead(gaze[:, 0], head[:, 0]),
        "shifts_a_second": _shifts(face),
        "shortest_viseme_ms": 1000 * shortest_viseme(face),
    }


def shortest_viseme(face: Face) -> float:
    """Return the smallest width at half height of the visible peaks of visemes in seconds; infinite of none."""
    widths = [width for column in face.weights[:, : len(VISEMES)].T for width in half_widths(column)]
    return min(widths, default=float("inf"))


def half_widths(column: np.ndarray) -> Iterator[float]:
    """Yield the width at half height in seconds of each visible peak of a weight ``(n,)``."""
    padded = np.pad(column, 1)
    peaks = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] > padded[2:]) & (column > _VISIBLE)) + 1
    for peak in peaks:
        under = np.flatnonzero(padded < padded[peak] / 2)
        after = np.searchsorted(under, peak)
        yield float((under[after] - under[after - 1]) / RATE)


def table(recordings: dict[str, dict[str, float]]) -> str:
    """Format figures by recording as lines of text, with the values of people."""
    rows = []
    for name, figures in recordings.items():
        rows.append(f"{name} ({figures['seconds']:.1f} s)")
        cells = {
            "closures seen": _closures(figures, "closures"),
            "by ear alone": _closures(
                figures, "closures_by_ear", f", {figures.get('false_closures_by_ear', 0):.0%} too many"
            ),
            "jaw with loudness": f"r = {figures['jaw_with_loudness']:.2f}",
            "blinks a minute": f"{figures['blinks_a_minute']:.0f}",
            "gaze at the listener": f"{figures['gaze_at_listener']:.0%} while talking",
            "as phrases begin, end": f"{figures['gaze_as_phrases_begin']:.0%}, {figures['gaze_as_phrases_end']:.0%}",
            "gaze before the head": f"{figures['gaze_before_head_ms']:.0f} ms",
            "shifts of the eyes": f"{figures['shifts_a_second']:.1f} a second",
            "shortest viseme": f"{figures['shortest_viseme_ms']:.0f} ms",
        }
        rows += [f"  {row:<23}{value:<44}{HUMAN_VALUES.get(row, '')}".rstrip() for row, value in cells.items() if value]
    return "\n".join([f"{'':25}{'THIS FACE':<44}PEOPLE", *rows])


def _closures(figures: dict[str, float], name: str, suffix: str = "") -> str:
    if f"{name}_{RATES[0]}" not in figures:
        return ""
    return ", ".join(f"{figures[f'{name}_{fps}']:.0%} at {fps} fps" for fps in RATES) + suffix


def _shifts(face: Face) -> float:
    """Return the saccades a second: eye movements of at least half a degree in 30 ms."""
    gaze = GAZE_DEGREES * face.weights[:, [channel("LOOK_LEFT"), channel("LOOK_UP")]]
    fast = np.linalg.norm(gaze[3:] - gaze[:-3], axis=1) > 0.5
    return float((np.diff(fast.astype(int)) > 0).sum() / face.duration)


def _lead(gaze: np.ndarray, head: np.ndarray) -> float:
    """Return the seconds by which gaze ``(n,)`` moves before the head: the lag of highest correlation; NaN of a still head."""
    moves, turns = np.diff(gaze), np.diff(head)
    limit = min(int(_MAX_LAG * RATE), len(turns) // 4)
    if not limit or np.ptp(turns) < 1e-6:
        return float("nan")
    middle = turns[limit : len(turns) - limit]
    scores = [np.corrcoef(middle, moves[limit - lag : len(moves) - limit - lag])[0, 1] for lag in range(-limit, limit + 1)]
    return (int(np.argmax(scores)) - limit) / RATE


def _during(spans: np.ndarray, count: int) -> np.ndarray:
    """Return the frames ``(count,)`` within any of ``spans`` (s)."""
    time, inside = np.arange(count) / RATE, np.zeros(count, bool)
    for start, end in spans:
        inside |= (time >= start) & (time <= end)
    return inside


def _share(holds: np.ndarray, rows: np.ndarray) -> float:
    return float(holds[rows].mean()) if rows.any() else float("nan")


def lips_closed(weights: np.ndarray) -> np.ndarray:
    """Return which rows of weights ``(..., channels)`` have closed lips."""
    return (weights[..., channel("PP")] >= 0.95) & (weights[..., channel("JAW")] <= CLOSED_JAW + 1e-6)
