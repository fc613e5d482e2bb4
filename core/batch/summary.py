"""Reports of a batch, from its records: a summary, lists of failures and warnings, and the index of a data set."""

import hashlib
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from ..files import atomic_file
from ..motion import skeleton
from ..settings import names_with
from .clip import Clip, Unit
from .folder import STAGES
from .stages import Batch, Step

CARD = """# Speech and gesture

Made by `s2ag batch`. One line of `index.jsonl` describes one performance:

- `motion/NAME.npz`: `directions` (frames, 9, 3) float32 unit vectors, `positions` (frames, 10, 3) float32 metres with the
  spine joint at the origin, `fps`. Right-handed, y down, z forward, the left arm at -x. Joints: {joints}.
  Edges (parent, child): {edges}.
- `audio/NAME.wav`: the recording, 16 kHz mono, 16 bit; it starts with the first frame.
- `words/NAME.json`: `words` as [word, start, end] in seconds; empty where no transcript was given.

`split` depends on the recording's content alone, so that performances of one recording are never in two splits.
"""


def summarize(batch: Batch, chosen: Sequence[Unit]) -> tuple[dict, list[dict], list[dict]]:
    """Return the counts of each stage's steps by state, the failures, and the warnings of finished steps.

    Failures have ``stage``, ``name``, ``line``, ``kind``, ``message``, ``remedy``; warnings all but ``kind`` and ``remedy``.
    """
    stages: dict[str, dict[str, int]] = {}
    failures: list[dict] = []
    warnings: list[dict] = []
    for stage in STAGES:
        steps = batch.steps(stage, chosen)
        if steps:
            states = Counter(step.state for step in steps)
            stages[stage] = {"steps": len(steps), **{state: states[state] for state in ("done", "failed", "ready", "waiting")}}
            failures += [_failure(step) for step in steps if step.state == "failed"]
            warnings += [warning for step in steps if step.facts for warning in _warnings(step, step.facts)]
    done = all(counts["done"] == counts["steps"] for counts in stages.values())
    warned = len({(warning["stage"], warning["name"]) for warning in warnings})
    count = sum(len(unit.clips) for unit in chosen)
    return {"clips": count, "complete": done, "stages": stages, "warnings": warned}, failures, warnings


def write(batch: Batch, last_run: dict | None = None) -> None:
    """Write ``summary.json`` of the whole batch, and ``failures.jsonl`` and ``warnings.jsonl`` if there are any."""
    summary, failures, warnings = summarize(batch, batch.units)
    root = batch.folder.root
    with atomic_file(root / "summary.json") as temporary:
        temporary.write_text(json.dumps({**summary, "last_run": last_run or {}}, indent=1) + "\n", "utf-8")
    for path, rows in ((root / "failures.jsonl", failures), (root / "warnings.jsonl", warnings)):
        if rows:
            _write_rows(path, rows)
        else:
            path.unlink(missing_ok=True)
    _write_index(batch)


def _write_rows(path: Path, rows: list[dict]) -> None:
    with atomic_file(path) as temporary:
        temporary.write_text("".join(json.dumps(row, ensure_ascii=False) + "\n" for row in rows), "utf-8")


def _failure(step: Step) -> dict:
    failure = step.record.failure() or {}
    failure.pop("key", None)
    return {"stage": step.stage, "name": step.name, "line": step.line, **failure}


def _warnings(step: Step, facts: dict) -> list[dict]:
    about = {"stage": step.stage, "name": step.name, "line": step.line}
    return [{**about, "message": message} for message in facts.get("warnings", ())]


def _write_index(batch: Batch) -> None:
    """Write the index and the card of the data set, for the clips that are done."""
    clips = [clip for clip in batch.clips if "dataset" in clip.outputs]
    units = [unit for unit in batch.units if any("dataset" in clip.outputs for clip in unit.clips)]
    done = {step.name: step.facts for step in batch.steps("synth", units) if step.facts is not None}
    rows = [row for clip in clips if clip.name in done for row in _rows(clip, done[clip.name])]
    if not rows:
        return
    place = batch.folder.root / "dataset"
    _write_rows(place / "index.jsonl", rows)
    edges = ", ".join(f"{name} {pair}" for name, pair in zip(skeleton.EDGE_NAMES, skeleton.EDGES, strict=True))
    with atomic_file(place / "README.md") as temporary:
        temporary.write_text(CARD.format(joints=", ".join(skeleton.JOINTS), edges=edges), "utf-8")


def _rows(clip: Clip, facts: dict) -> Iterator[dict[str, object]]:
    """Yield an index entry for every take; a tenth of the recordings is for validation, a tenth for tests."""
    share = int(hashlib.sha256(facts["recording"].encode()).hexdigest()[:8], 16) % 10
    for take, name in enumerate(clip.take_names):
        yield {
            "name": name,
            "motion": f"motion/{name}.npz",
            "audio": f"audio/{clip.name}.wav",
            "words": f"words/{clip.name}.json",
            "split": {0: "validation", 1: "test"}.get(share, "train"),
            "seconds": round(facts["duration"], 4),
            **{name: getattr(clip, name) for name in names_with(indexed=True)},
            "take": take,
        }
