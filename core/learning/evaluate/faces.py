"""Figures of speaking faces, beside what is known of people: closed lips, jaw and voice, blinks, and gaze.

What people do, by which figures are to be read:

- Lips meet for every p, b and m; a film dubbed or drawn is judged by it (Lewis and Parke 1987, "Automated lip-synch and speech
  synthesis for character animation"). Here a closure is hit if lips are closed within a frame of the sound.
- The mouth's opening and the voice's envelope go together, both at 2 to 7 Hz (Chandrasekaran et al. 2009, "The natural
  statistics of audiovisual speech").
- Blinks: 26 a minute in conversation, 17 at rest, 4.5 reading (Bentivoglio et al. 1997, "Analysis of blink rate patterns in
  normal subjects").

- Gaze, of eyes and head together: people who talk look at the listener 41 % of the time (Argyle and Ingham 1972, "Gaze, mutual
  gaze, and proximity"), each of Kendon's (1967, "Some functions of gaze-direction in social interaction") between 28 and 70 %;
  they look away as they begin to speak and at the listener as they end. The listener is where the head usually points.
- Gaze goes before the head, whose turn it needs less the nearer things are (Freedman 2008, "Coordination of the eyes and head
  during visual orienting").
"""

from os import PathLike
from pathlib import Path

import numpy as np

from ...face import eyes, making
from ...motion.face import GAZE, RATE, VISEMES, Face, channel, closed
from ...performance.synthesis import Request, Session
from ...sound import audio
from ...words import transcript
from ...words.align import Phone
from ...words.beside import beside

RATES = (24, 60)
"""Frames a second at which closures are looked for."""
PEOPLE = {
    "closures seen": "all",
    "jaw with loudness": "together, at 2 to 7 Hz (Chandrasekaran et al. 2009)",
    "blinks a minute": "26 in conversation (Bentivoglio et al. 1997)",
    "gaze at the listener": "41 % (Argyle and Ingham 1972), 28 to 70 % (Kendon 1967)",
    "as phrases begin, end": "away, at the listener (Kendon 1967)",
    "gaze before the head": "yes (Freedman 2008)",
}
"""What people do, by the rows of :func:`table`."""
_AT = 10.0
"""Degrees from the listener's eyes that count as looking at the listener."""
_LAG = 0.5
"""Seconds by which head and gaze are shifted against each other, at most."""
_BORDER = 0.3
"""Seconds after a phrase's begin and before its end that are looked at."""
_SEEN = 0.15


def measure(recording: str | PathLike) -> dict[str, float]:
    """Figures of the face made for a recording, with the text that lies beside it; of the sound alone as well where it has one.

    Raises :class:`S2agError` for what cannot be read.
    """
    recording = Path(recording)
    text = beside(recording)
    motion = Session().synthesize(Request(recording, transcript=text, face=1.0)).motions[0]
    sound = audio.load(recording)
    heard = transcript.hear(sound, text) if text else None
    spoken = making.hear(sound, heard.words, heard.phones) if heard else making.hear(sound)
    found = {"seconds": round(motion.face.duration, 2), **behaviour(motion.face, spoken, motion.directions)}
    if heard is None:
        return found
    spans = lips(spoken.sounds)
    found |= {f"closures_{fps}": hit(motion.face, spans, fps) for fps in RATES}
    alone = making.make(making.hear(sound), motion.directions)
    found |= {f"closures_by_ear_{fps}": hit(alone, spans, fps) for fps in RATES}
    return found | {"false_closures_by_ear": false(alone, spans)}


def lips(sounds: tuple[Phone, ...]) -> list[tuple[float, float]]:
    """When sounds of closed lips are said, ``(start, end)`` in seconds."""
    return [(start, end) for phone, start, end in sounds if phone in ("P", "B", "M")]


def hit(face: Face, spans: list[tuple[float, float]], fps: float) -> float:
    """Share of ``spans`` within a frame of which lips are seen closed, at ``fps`` frames a second; NaN of none."""
    moments = np.flatnonzero(closed(face.frames(fps))) / fps
    seen = [((moments >= start - 1 / fps) & (moments <= end + 1 / fps)).any() for start, end in spans]
    return float(np.mean(seen)) if seen else float("nan")


def false(face: Face, spans: list[tuple[float, float]], near: float = 0.05) -> float:
    """Share of a face's closures that none of ``spans`` comes within ``near`` seconds of; NaN where it has none."""
    wrong = [not any(start <= end_ + near and end >= begin - near for begin, end_ in spans) for start, end in face.closures]
    return float(np.mean(wrong)) if wrong else float("nan")


def behaviour(face: Face, spoken: making.Spoken, directions: np.ndarray) -> dict[str, float]:
    """Figures that need no text: jaw, blinks, gaze of eyes and a head with ``directions`` ``(frames, 9, 3)`` at 15 fps, and the
    shortest viseme that is seen, in milliseconds."""
    speech = _during(spoken.phrases, len(face.weights))
    head = eyes.turned(directions, len(face.weights))
    gaze = GAZE * face.weights[:, [channel("LOOK_LEFT"), channel("LOOK_UP")]] + head
    at = np.hypot(*gaze.T) <= _AT
    begins = np.stack([spoken.phrases[:, 0], spoken.phrases[:, 0] + _BORDER], 1)
    ends = np.stack([spoken.phrases[:, 1] - _BORDER, spoken.phrases[:, 1]], 1)
    shut = face.weights[:, channel("BLINK_LEFT")] > 0.5
    jaw, loud = face.weights[speech, channel("JAW")], spoken.loudness[speech]
    return {
        "jaw_with_loudness": float(np.corrcoef(jaw, loud)[0, 1]) if speech.sum() > 2 and jaw.any() else float("nan"),
        "blinks_a_minute": float((np.diff(shut.astype(int)) > 0).sum() / face.duration * 60),
        "gaze_at_listener": _share(at, speech),
        "gaze_as_phrases_begin": _share(at, _during(begins, len(at))),
        "gaze_as_phrases_end": _share(at, _during(ends, len(at))),
        "gaze_before_head_ms": 1000 * _before(gaze[:, 0], head[:, 0]),
        "shifts_a_second": _shifts(face),
        "shortest_viseme_ms": 1000 * shortest(face),
    }


def shortest(face: Face) -> float:
    """Seconds that the shortest rise of a viseme lasts above half its height, of those that can be seen; infinite of none."""
    widths = [width for column in face.weights[:, : len(VISEMES)].T for width in half_widths(column)]
    return min(widths, default=float("inf"))


def half_widths(column: np.ndarray):
    """Seconds that each rise of a weight ``(n,)`` lasts above half its height, where it can be seen."""
    padded = np.pad(column, 1)
    tops = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] > padded[2:]) & (column > _SEEN)) + 1
    for top in tops:
        under = np.flatnonzero(padded < padded[top] / 2)
        after = np.searchsorted(under, top)
        yield (under[after] - under[after - 1]) / RATE


def table(found: dict[str, dict[str, float]]) -> str:
    """Figures by recording as lines of text, and what people do."""
    rows = []
    for name, one in found.items():
        rows.append(f"{name} ({one['seconds']:.1f} s)")
        told = {
            "closures seen": _closures(one, "closures"),
            "by ear alone": _closures(one, "closures_by_ear", f", {one.get('false_closures_by_ear', 0):.0%} too many"),
            "jaw with loudness": f"r = {one['jaw_with_loudness']:.2f}",
            "blinks a minute": f"{one['blinks_a_minute']:.0f}",
            "gaze at the listener": f"{one['gaze_at_listener']:.0%} while talking",
            "as phrases begin, end": f"{one['gaze_as_phrases_begin']:.0%}, {one['gaze_as_phrases_end']:.0%}",
            "gaze before the head": f"{one['gaze_before_head_ms']:.0f} ms",
            "shifts of the eyes": f"{one['shifts_a_second']:.1f} a second",
            "shortest viseme": f"{one['shortest_viseme_ms']:.0f} ms",
        }
        rows += [f"  {row:<23}{value:<44}{PEOPLE.get(row, '')}".rstrip() for row, value in told.items() if value]
    return "\n".join([f"{'':25}{'THIS FACE':<44}PEOPLE", *rows])


def _closures(one: dict[str, float], name: str, more: str = "") -> str:
    if f"{name}_{RATES[0]}" not in one:
        return ""
    return ", ".join(f"{one[f'{name}_{fps}']:.0%} at {fps} fps" for fps in RATES) + more


def _shifts(face: Face) -> float:
    """Fast movements of the eyes, of at least half a degree in 30 ms, a second."""
    gaze = GAZE * face.weights[:, [channel("LOOK_LEFT"), channel("LOOK_UP")]]
    fast = np.linalg.norm(gaze[3:] - gaze[:-3], axis=1) > 0.5
    return float((np.diff(fast.astype(int)) > 0).sum() / face.duration)


def _before(gaze: np.ndarray, head: np.ndarray) -> float:
    """Seconds by which movements of gaze ``(n,)`` go before the head's: the shift at which the two are most alike; NaN of a
    head that is still."""
    moves, turns = np.diff(gaze), np.diff(head)
    most = min(int(_LAG * RATE), len(turns) // 4)
    if not most or np.ptp(turns) < 1e-6:
        return float("nan")
    middle = turns[most : len(turns) - most]
    alike = [np.corrcoef(middle, moves[most - lag : len(moves) - most - lag])[0, 1] for lag in range(-most, most + 1)]
    return (int(np.argmax(alike)) - most) / RATE


def _during(spans: np.ndarray, count: int) -> np.ndarray:
    time, inside = np.arange(count) / RATE, np.zeros(count, bool)
    for start, end in spans:
        inside |= (time >= start) & (time <= end)
    return inside


def _share(holds: np.ndarray, rows: np.ndarray) -> float:
    return float(holds[rows].mean()) if rows.any() else float("nan")
