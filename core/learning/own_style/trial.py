"""How well styles are learned: ``python -m s2ag.core.learning.own_style.trial VOICE.wav OTHER.wav --styles "stern,coach"``.

Each style performs both recordings and is learned from these motions alone, on the first; what was learned performs both with
other seeds. The table, in Markdown, says how far that is from its own source and from the nearest other style's."""

import argparse
from pathlib import Path

import numpy as np

from ...synthesis.session import Session
from . import fit, manner, source

_USUAL = "stern,grand orator,left-handed joker,shy student,coach,thoughtful explainer"
_SEEDS = 100, (200, 300, 400, 500)
"""First seed of the sources, and seeds of what was learned."""


def table(session: Session, sounds: list[Path], styles: list[str]) -> str:
    """Learn ``styles`` from their performances of ``sounds``; return the rows as Markdown."""
    stages = [fit.Stage(session, sound) for sound in sounds]
    names, known = [one["name"] for one in session.styles()], fit.speakers(session.checkpoint)
    shown = [stage.show(known, _SEEDS[0]) for stage in stages]
    motions = {name: [stage[row][0] for stage in shown] for row, name in enumerate(names)}
    manners = {name: manner.measure(pieces) for name, pieces in motions.items()}
    rows = ["| source | began at | to its source | to the nearest other |", "|---|---|---|---|"]
    for name in styles:
        found = fit.fit(stages[0], source.of_motions(name, motions[name], sounds[0]))
        again = [stage.show([found.style], seed)[0][0] for stage in stages for seed in _SEEDS[1]]
        apart = {other: manner.apart(manner.measure(again), figures) for other, figures in manners.items()}
        own, nearest = apart.pop(name), min(apart, key=lambda other: apart[other])
        began = names[int(np.argmax(found.shares))]
        rows.append(f"| {name} | {began} | {own:.2f} | {apart[nearest]:.2f} ({nearest}) |")
    return "\n".join(rows)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sounds", metavar="SOUND", type=Path, nargs="+")
    parser.add_argument("--styles", default=_USUAL)
    options = parser.parse_args()
    print(table(Session(), options.sounds, [one.strip() for one in options.styles.split(",")]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
