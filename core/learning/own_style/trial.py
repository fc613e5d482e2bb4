"""How well styles are learned: ``s2ag evaluate --own-styles``.

Each style performs two recordings and is learned from these motions alone, as they are and as films show them; what was learned
performs both with other seeds. Figures of manner and a judge of speakers say whether that is nearer to its own source than to
any other style; a judge of talk, whether it is told from people as little as the source."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...motion import skeleton
from ...motion.motion import Motion
from ...synthesis.session import Session
from ..capture import trial as films
from ..evaluate import speaker_identification, talk_judge, talk_people
from . import camera, fit, manner, source

USUAL = "stern", "grand orator", "left-handed joker", "shy student", "coach", "thoughtful explainer"
CHOSEN = "eager storyteller", "nervous", "news anchor", "sales rep", "deadpan"
"""Styles that are reported, and those of which films tell what films add to all."""
_PIECE = 10.0, 34.0
"""Seconds of the recordings that these are filmed in."""
_SOURCES, _JUDGED, _LEARNED = 100, (600, 700, 800), (200, 300, 400, 500)
"""First seeds: of the sources, of what the judge of speakers learns from, of what was learned."""
_WINDOW = 17.5
"""Seconds of the windows that the judge of speakers is asked about."""
Tell = Callable[[str, float], None]
Filmed = Callable[[dict[str, list[np.ndarray]]], dict[str, list[Motion]]]
"""Films motions ``(frames, 9, 3)`` by style, and returns what was captured of each."""


class Row(NamedTuple):
    """What was learned from a style: where it began, how far it is from its source and from every other style, the share of its
    windows that the judge ascribes to each style, and which is the most likely of all windows together."""

    name: str
    began: str
    apart: dict[str, float]
    shares: dict[str, float]
    likely: str

    @property
    def near(self) -> bool:
        """Whether its own source is the nearest in manner, and the most likely."""
        return min(self.apart, key=lambda name: self.apart[name]) == self.name == self.likely


class Trial:
    """Performances of ``styles``, all if None, and a judge that knows them from their ``takes`` with other seeds."""

    def __init__(
        self,
        session: Session,
        sounds: Sequence[Path],
        tell: Tell,
        styles: Sequence[str] | None = None,
        takes: Sequence[int] = _JUDGED,
    ):
        self.sounds, self._tell = sounds, tell
        speakers = zip(session.styles(), fit.speakers(session.checkpoint), strict=True)
        known = {one["name"]: speaker for one, speaker in speakers if styles is None or one["name"] in styles}
        self._every = [one["name"] for one in session.styles()]
        self.names, self._known = list(known), list(known.values())
        self._stages = [fit.Stage(session, sound) for sound in sounds]
        self._session = session
        self.sources = self._performances(_SOURCES, 0, 1 + len(takes))
        self.manners = {name: manner.measure(pieces) for name, pieces in self.sources.items()}
        rows = [self._performances(seed, 1 + number, 1 + len(takes)) for number, seed in enumerate(takes)]
        pieces = [(name, window) for row in rows for name, motions in row.items() for window in windows(motions)]
        named = [name for name, _ in pieces]
        self.judge = speaker_identification.Judge(_features([window for _, window in pieces]), np.array(named))

    def _performances(self, seed: int, part: int, parts: int) -> dict[str, list[np.ndarray]]:
        """Return the motions of every style, one of each recording."""
        shown = []
        for number, stage in enumerate(self._stages):
            self._tell("perform", (part + number / len(self._stages)) / parts)
            shown.append(stage.show(self._known, seed))
        return {name: [stage[row][0] for stage in shown] for row, name in enumerate(self.names)}

    def from_motions(self, names: Sequence[str]) -> list[source.Source]:
        """Return styles as they perform."""
        return [source.of_motions(name, self.sources[name], self.sounds) for name in names]

    def from_films(self, captured: dict[str, list[Motion]]) -> list[source.Source]:
        """Return styles as films showed them."""
        pieces = {name: [piece for motion in motions for piece in source.seen(motion)] for name, motions in captured.items()}
        return [source.of_film(source.of_motions(name, parts, self.sounds)) for name, parts in pieces.items()]

    def learned(self, sources: Sequence[source.Source]) -> tuple[list[Row], dict[str, list[np.ndarray]]]:
        """Learn a style from each source; return how near each is, and what each performed."""
        rows, made, stage = [], {}, fit.staged(self._session, self.sounds)
        for number, one in enumerate(sources):
            name, tell = one.name, lambda share, number=number: self._tell("learn", (number + share) / len(sources))
            found = fit.fit(stage, one, tell)
            made[name] = [stage.show([found.style], seed)[0][0] for stage in self._stages for seed in _LEARNED]
            rows.append(self.row(name, made[name], self._every[int(np.argmax(found.shares))]))
        return rows, made

    def row(self, name: str, motions: Sequence[np.ndarray], began: str = "") -> Row:
        """Compare motions with all styles."""
        figures, features = manner.measure(motions), _features(windows(motions))
        told = self.judge.told(features)
        likely = self.judge.classes[self.judge.distances(features).sum(0).argmin()]
        shares = {other: float((told == other).mean()) for other in self.names}
        apart = {other: manner.apart(figures, theirs) for other, theirs in self.manners.items()}
        return Row(name, began, apart, shares, str(likely))

    def shipped(self, names: Sequence[str]) -> tuple[list[Row], dict[str, list[np.ndarray]]]:
        """Ask about the styles themselves with the seeds of what was learned: as near as anything can be."""
        known = {name: self._known[self.names.index(name)] for name in names}
        made = {
            name: [stage.show([style], seed)[0][0] for stage in self._stages for seed in _LEARNED]
            for name, style in known.items()
        }
        return [self.row(name, motions) for name, motions in made.items()], made


def choose(session: Session, sounds: Sequence[Path], tell: Tell, filmed: Filmed) -> str:
    """Return how figures are read from films, of films of :data:`CHOSEN`, as :data:`camera.CHANGES` is written."""
    names, pieces = [one["name"] for one in session.styles()], slice(*(round(part * skeleton.FPS) for part in _PIECE))
    shown = [fit.Stage(session, sound).show(fit.speakers(session.checkpoint), _SOURCES) for sound in sounds]
    motions = {name: [stage[names.index(name)][0][pieces] for stage in shown] for name in CHOSEN}
    seen = filmed(motions)
    pairs = [
        (manner.measure(source.seen(made)), manner.measure([true]))
        for name in CHOSEN
        for made, true in zip(seen[name], motions[name], strict=True)
    ]
    lines = [f'"{name}": ({", ".join(f"{part:.2f}" for part in parts)}),' for name, parts in camera.changes(pairs).items()]
    return "\n".join([f"Of {len(pairs)} films:", *lines])


def run(
    session: Session, sounds: Sequence[Path], styles: Sequence[str], tell: Tell, filmed: Filmed, material: Path | None
) -> str:
    """Return the tables as Markdown; with ``material`` (``rocketbox_clips/``) also how far all are told from people."""
    trial = Trial(session, sounds, tell)
    captured = filmed({name: trial.sources[name] for name in styles})
    sources = trial.from_films(captured)
    companies = {
        "shipped": trial.shipped(styles),
        "motions": trial.learned(trial.from_motions(styles)),
        "films": trial.learned(sources),
    }
    pages = [f"Learned from {kind}:\n\n{table(rows)}" for kind, (rows, _) in companies.items() if kind != "shipped"]
    right = np.mean([row.shares[row.name] for row in companies["shipped"][0]])
    pages.append(f"Of windows of these styles themselves, the judge of speakers ascribes {right:.0%} to the right one.")
    pairs = [pair for name in styles for pair in zip(trial.sources[name], captured[name], strict=True)]
    told = [films.count_strokes(true, made.directions) for true, made in pairs]
    wanted, hits, got, extra = np.sum(told, axis=0)
    pages.append(f"Of {wanted} strokes films showed {hits / wanted:.0%}; of {got} captured ones {extra / got:.0%} are made up.")
    if material is not None:
        tell("judge", 0)
        people = talk_people.load(material)
        lines = ["| performers | told from people | by a second judge |", "|---|---|---|"]
        for kind, (_, made) in companies.items():
            motions = [motion for name in made for motion in made[name]]
            verdict = talk_judge.told_apart(motions, people.kinds, people.asked, alike=False)
            lines.append(f"| {kind} | {verdict.told:.2f} | {verdict.told_again:.2f} |")
        pages.append("\n".join(lines))
    return "\n\n".join(pages)


def table(rows: Sequence[Row]) -> str:
    """Return what was learned and how near it is, as Markdown."""
    lines = [
        "| source | began at | to its source | to the nearest other | windows told as it | as the next | most likely |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        nearest = min((name for name in row.apart if name != row.name), key=lambda name: row.apart[name])
        following = max((name for name in row.shares if name != row.name), key=lambda name: row.shares[name])
        lines.append(
            f"| {row.name} | {row.began} | {row.apart[row.name]:.2f} | {row.apart[nearest]:.2f} ({nearest}) "
            f"| {row.shares[row.name]:.0%} | {row.shares[following]:.0%} ({following}) | {row.likely} |"
        )
    return "\n".join(lines)


def windows(motions: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Cut motions into windows of about :data:`_WINDOW` seconds, all of a motion equally long."""
    counts = [max(round(len(motion) / skeleton.FPS / _WINDOW), 1) for motion in motions]
    return [part for motion, count in zip(motions, counts, strict=True) for part in np.array_split(motion, count)]


def _features(pieces: Sequence[np.ndarray]) -> np.ndarray:
    return np.stack([speaker_identification.features(manner.smoothed(piece)) for piece in pieces])
