"""Hands and legs of who sits, idle, listening and talking, on a chair, with arm rests, at a table: ``s2ag evaluate --seated``.

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
RESTS = 0.14
"""Metres by which arm rests do: 0.24 m above the seat, where elbows are."""
PLACES = {0.0: "no table", RESTS: "arm rests", TABLE: "a table"}
"""What is said of each height that is given as a table's."""
STYLES = ("eager storyteller", "grand orator", "warm host", "brisk presenter", "left-handed joker", "calm lecturer")
"""Styles of the talks, in turn; the idle is restless."""
_IDLE: dict[str, Any] = {"style": "shy student", "seed": 7, "stillness": 0.1}
Run = Callable[..., dict]
"""Runs a module of s2ag_blender with the path of a job."""


@dataclass(frozen=True)
class Row:
    """What was measured on a character: ``at`` which of :data:`PLACES`, metres at every frame (``hands
    in thigh``), and how far legs moved."""

    character: str
    kind: str
    at: str
    depths: dict[str, np.ndarray]
    moved: float

    def reached(self) -> bool:
        """Return whether no hand lies deeper than it may, at arm rests no forearm, and hips, legs and feet stay to the bit."""
        rests = [name for name in self.depths if name.endswith("arm rest")]
        asked = ["hands in thigh", "hands in table", *(rests if self.at == PLACES[RESTS] else ())]
        return self.moved == 0 and all(self.depths[name].max() <= DEPTH for name in asked)


def motions(recordings: Sequence[Path], seconds: float) -> Iterator[tuple[str, Motion]]:
    """Yield motions of the kinds ``idle``, ``listen`` and ``talk``, so many seconds of each; recordings come again."""
    yield "idle", idling.idle(seconds, **_IDLE)
    session = Session(cache="off")
    for kind in ("listen", "talk"):
        left, number = seconds, 0
        while left > 0 and recordings:
            path, style = recordings[number % len(recordings)], STYLES[number % len(STYLES)]
            asked = Request(str(path), style=style, seed=number, hands=1.0, listen=kind == "listen")
            motion = session.synthesize(asked).motions[0]
            motion = motion.frames(slice(0, round(left * motion.fps) + 1))
            if len(motion.directions) < 2:
                raise UsageError(f"{path} is too short to talk to.", "Name longer recordings.")
            yield kind, motion
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
            content: dict[str, Any] = {"character": who, "fps": FPS, "motions": paths, "tables": [*PLACES], "rests": RESTS}
            content |= {} if keep is None else {"keep": str(keep / name)}
            job.write_text(json.dumps(content), "utf-8")
            told = run("render.seated_trial", str(job), progress=lambda _, share, name=name: progress(name, share))["rows"]
            for table, at in PLACES.items():
                for kind in dict.fromkeys(kinds):
                    own = [row for row in told if row["table"] == table and kinds[row["motion"]] == kind]
                    depths = {key: np.concatenate([row["figures"][key] for row in own]) for key in own[0]["figures"]}
                    rows.append(Row(name, kind, at, depths, max(row["moved"] for row in own)))
    return rows


def page(rows: Sequence[Row]) -> str:
    """Return the figures as a table in Markdown."""
    names = [f"{part} in {what}" for part in ("hands", "forearms") for what in ("thigh", "table", "arm rest")]
    lines = [f"| character | does | at | frames | {' | '.join(names)} | legs moved |", "|---" * 11 + "|"]
    for row in rows:
        told = [_told(row.depths[name]) for name in names]
        count = len(row.depths["hands in thigh"])
        lines.append(f"| {row.character} | {row.kind} | {row.at} | {count} | " + " | ".join(told) + f" | {row.moved:g} |")
    missed = [f"{row.character} ({row.kind})" for row in rows if not row.reached()]
    goal = f"Hands, and forearms in arm rests, at most {1000 * DEPTH:.0f} mm deep, hips and legs to the bit: "
    return "\n".join([*lines, "", goal + (f"missed by {', '.join(dict.fromkeys(missed))}." if missed else "reached by all.")])


def _told(depths: np.ndarray) -> str:
    share = float(np.mean(depths > DEPTH))
    return f"{1000 * depths.max():.1f} mm" + (f", {share:.2%} deeper than {1000 * DEPTH:.0f}" if share else "")
