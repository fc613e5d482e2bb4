"""Hands and legs of who sits, idle and talking, on a chair and at a table, for ``s2ag evaluate --seated``.

``s2ag_blender/render/seated_trial.py`` measures, on the vertices of each character's meshes as Blender keys it."""

import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import UsageError
from ...motion.motion import Motion
from ...synthesis import idling
from ...synthesis.session import Request, Session

DEPTH = 0.01
"""Metres that hands may lie in a thigh or a table."""
SECONDS, FPS = 300.0, 10
"""Seconds of each kind of motion, and frames of a second that are looked at."""
TABLE = 0.2
"""Metres by which the table stands above the hip joints: 0.72 m on a chair of 0.45 m."""
STYLES = ("eager storyteller", "grand orator", "warm host", "brisk presenter", "left-handed joker", "calm lecturer")
"""Styles of the talks, in turn; the idle is restless."""
_IDLE: dict[str, Any] = {"style": "shy student", "seed": 7, "stillness": 0.1}
Run = Callable[..., dict]
"""Runs a module of s2ag_blender with the path of a job."""


@dataclass(frozen=True)
class Row:
    """What was measured on a character: metres at every frame (``hands in thigh``), and how far legs moved."""

    character: str
    kind: str
    table: bool
    depths: dict[str, np.ndarray]
    moved: float

    def reached(self) -> bool:
        """Return whether no hand lies deeper than it may, and hips, legs and feet stay to the bit."""
        return self.moved == 0 and all(deep.max() <= DEPTH for name, deep in self.depths.items() if name.startswith("hands"))


def motions(recordings: Sequence[Path], seconds: float) -> Iterator[tuple[str, Motion]]:
    """Yield motions by kind, ``idle`` and ``talk``, of so many seconds each; recordings come again until that is reached."""
    yield "idle", idling.idle(seconds, **_IDLE)
    session, left, number = Session(cache="off"), seconds, 0
    while left > 0 and recordings:
        path, style = recordings[number % len(recordings)], STYLES[number % len(STYLES)]
        motion = session.synthesize(Request(str(path), style=style, seed=number, hands=1.0)).motions[0]
        motion = motion.frames(slice(0, round(left * motion.fps) + 1))
        if len(motion.directions) < 2:
            raise UsageError(f"{path} is too short to talk to.", "Name longer recordings.")
        yield "talk", motion
        left, number = left - len(motion.directions) / motion.fps, number + 1


def trial(
    characters: Sequence[str], recordings: Sequence[Path], run: Run, seconds: float = SECONDS,
    progress: Callable[[str, float], None] = lambda *_: None, keep: Path | None = None
) -> list[Row]:  # fmt: skip
    """Measure every character; with ``keep``, its keyed scenes are written to that folder. Raises S2agError."""
    rows = []
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        kinds, paths = [], []
        for number, (kind, motion) in enumerate(motions(recordings, seconds)):
            paths.append(str(Path(folder) / f"{number}.npz"))
            kinds.append(kind)
            motion.save(paths[-1])
            progress("motions", 0.0)
        for who in characters:
            name, job = Path(who).stem.replace(":", "-"), Path(folder) / "job.json"
            content: dict[str, Any] = {"character": who, "fps": FPS, "motions": paths, "tables": [0.0, TABLE]}
            content |= {} if keep is None else {"keep": str(keep / name)}
            job.write_text(json.dumps(content), "utf-8")
            told = run("render.seated_trial", str(job), progress=lambda _, share, name=name: progress(name, share))["rows"]
            for table in (0.0, TABLE):
                for kind in dict.fromkeys(kinds):
                    own = [row for row in told if row["table"] == table and kinds[row["motion"]] == kind]
                    depths = {key: np.concatenate([row["figures"][key] for row in own]) for key in own[0]["figures"]}
                    rows.append(Row(name, kind, bool(table), depths, max(row["moved"] for row in own)))
    return rows


def page(rows: Sequence[Row]) -> str:
    """Return the figures as a table in Markdown."""
    names = [f"{part} in {what}" for part in ("hands", "forearms") for what in ("thigh", "table")]
    lines = [f"| character | does | at | frames | {' | '.join(names)} | legs moved |", "|---" * 9 + "|"]
    for row in rows:
        told = [_told(row.depths[name]) for name in names]
        count, at = len(row.depths["hands in thigh"]), "a table" if row.table else "no table"
        lines.append(f"| {row.character} | {row.kind} | {at} | {count} | " + " | ".join(told) + f" | {row.moved:g} |")
    missed = [f"{row.character} ({row.kind})" for row in rows if not row.reached()]
    goal = f"Hands at most {1000 * DEPTH:.0f} mm deep, hips and legs to the bit: "
    return "\n".join([*lines, "", goal + (f"missed by {', '.join(dict.fromkeys(missed))}." if missed else "reached by all.")])


def _told(depths: np.ndarray) -> str:
    share = float(np.mean(depths > DEPTH))
    return f"{1000 * depths.max():.1f} mm" + (f", {share:.2%} deeper than {1000 * DEPTH:.0f}" if share else "")
