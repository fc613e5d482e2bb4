"""How far idles are told apart from people who wait: the judge of talk, with captured idles as people.

The idles are pieces of the same captures. A judge is asked about the body that it was not trained on, so that it cannot know a
piece again; what it can hear of is how pieces are chosen, joined, slowed and made smaller."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import UsageError
from ...synthesis import idling
from ..corpus import idle_table, rocketbox_clips
from . import talk_judge

MOST = 0.70
"""The figure that is wanted at most."""
STYLES, SEEDS, SECONDS = ("warm host", "calm lecturer", "shy student", "stern"), 4, 60.0
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


def page(verdicts: dict[str, talk_judge.Verdict]) -> str:
    """Return the figures as lines to read."""
    body, part = verdicts["bodies"], verdicts["parts"]
    tells = ", ".join(f"{name} {value:+.2f}" for name, value in list(body.tells.items())[:5])
    return "\n".join(
        [
            f"Idles told from captured ones: {body.told:.2f} (at most {MOST:.2f}), by a second judge {body.told_again:.2f}",
            *(f"  asked about {kind}: {told:.2f}" for kind, told in body.kinds.items()),
            f"Parts of the captures instead of bodies: {part.told:.2f}, people asked alike {part.people_mean:.2f}",
            f"What tells most, in deviations of people: {tells}",
        ]
    )
