"""How far idles are told apart from people who wait: the judge of talk, with captured idles as people; and how listeners move.

The idles are pieces of the same captures. A judge is asked about the body that it was not trained on, so that it cannot know a
piece again; what it can hear of is how pieces are chosen, joined, slowed and made smaller."""

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import UsageError
from ...motion import skeleton
from ...synthesis import idling
from ...synthesis.session import Request, Session
from ..corpus import idle_table, rocketbox_clips
from . import talk_judge

MOST = 0.70
"""The figure that is wanted at most."""
STYLES, SEEDS, SECONDS = ("warm host", "calm lecturer", "shy student", "stern"), 4, 60.0
_PARTS = {"trunk": [0], "head": [1, 2], "arms": [4, 5, 7, 8]}
_BODIES = {"f": "a woman waits", "m": "a man waits"}


def captured(material: str | PathLike) -> dict[str, list[np.ndarray]]:
    """Return captured idles by body, each in two parts, so that people can be asked about alike.

    Raises :class:`UsageError` where there are none."""
    folder = Path(material) / rocketbox_clips.FOLDER
    paths = sorted(folder.glob("[fm]_idle_*.npz"))
    if not paths:
        raise UsageError(f"{material} holds no captured idles.", "Name the folder with rocketbox_clips/.")
    found: dict[str, list[np.ndarray]] = {}
    for number, path in enumerate(one for one in paths if one.stem not in idle_table.LEFT_OUT):
        kind = f"{_BODIES[path.stem[0]]}, part {number % 2 + 1}"
        found.setdefault(kind, []).append(rocketbox_clips.load(path).directions)
    return found


def judge(material: str | PathLike, progress: Callable[[str, float], None] = lambda *_: None) -> dict[str, talk_judge.Verdict]:
    """Return the verdict of bodies that were not trained on, and of all four parts, which compares people with people."""
    parts = captured(material)
    bodies = {body: [one for kind, motions in parts.items() if kind.startswith(body) for one in motions]
              for body in _BODIES.values()}  # fmt: skip
    asked = [(style, seed) for seed in range(SEEDS) for style in STYLES]
    ours = []
    for number, (style, seed) in enumerate(asked):
        ours.append(idling.idle(SECONDS, style, seed).directions)
        progress("idles", number / len(asked))
    progress("judges", 0.0)
    return {"bodies": talk_judge.told_apart(ours, bodies), "parts": talk_judge.told_apart(ours, parts)}


def turning(directions: np.ndarray) -> np.ndarray:
    """Return how fast trunk, head and arms of directions ``(frames, 9, 3)`` turn on average ``(3,)``, in radians a second."""
    speeds = np.linalg.norm(np.diff(directions.astype(float), axis=0), axis=-1).mean(0) * skeleton.FPS
    return np.array([speeds[edges].mean() for edges in _PARTS.values()])


def listeners(material: str | PathLike, recordings: Sequence[Path]) -> dict[str, np.ndarray]:
    """Return the :func:`turning` of each captured listener and of ours to each recording in :data:`STYLES` ``(n, 3)``."""
    clips = sorted((Path(material) / rocketbox_clips.FOLDER).glob("[fm]_gestic_listen_neutral_*.npz"))
    session, asked = Session(cache="off"), [(path, style) for path in recordings for style in STYLES]
    ours = [session.synthesize(Request(path, style=style, listen=True)).motions[0].directions for path, style in asked]
    people = [rocketbox_clips.load(path).directions for path in clips]
    return {kind: np.array([*map(turning, each)]).reshape(-1, 3) for kind, each in (("captured", people), ("ours", ours))}


def page(verdicts: dict[str, talk_judge.Verdict], listening: dict[str, np.ndarray]) -> str:
    """Return the figures as lines to read."""
    heads = ", ".join(_PARTS)
    ranges = {who: [f"{low:.2f} to {high:.2f}" for low, high in zip(rates.min(0), rates.max(0), strict=True)]
              for who, rates in listening.items() if len(rates)}  # fmt: skip
    body, part = verdicts["bodies"], verdicts["parts"]
    tells = ", ".join(f"{name} {value:+.2f}" for name, value in list(body.tells.items())[:5])
    return "\n".join(
        [
            f"Idles told from captured ones: {body.told:.2f} (at most {MOST:.2f}), by a second judge {body.told_again:.2f}",
            *(f"  asked about {kind}: {told:.2f}" for kind, told in body.kinds.items()),
            f"Parts of the captures instead of bodies: {part.told:.2f}, people asked alike {part.people_mean:.2f}",
            f"What tells most, in deviations of people: {tells}",
            *(f"Listeners, {who}: {heads} turn by {', '.join(each)} radians a second" for who, each in ranges.items()),
        ]
    )
