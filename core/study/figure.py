"""Draws the paper's figure 3 of own recordings: speech, seed pose and what several networks make of them, below each other."""

import base64
import html
import json
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import CorpusUnreadable
from ..files import atomic_file
from ..learning.evaluate.generation import write_wave
from ..learning.evaluate.talk_figures import moves
from ..learning.train.dataset import TEST, Corpus
from ..model import checkpoint_metadata
from ..motion import rest, skeleton
from ..sound import audio
from ..synthesis.request import Request
from ..synthesis.session import Session

ROWS = {
    "S2AG": "published",
    "without MFCC encoder": "published-no-mfcc",
    "without affective encoder": "published-no-affect",
    "default": "default",
}
"""Title -> checkpoint of the rows: the paper's system, its ablations (section 5.3) and the shipped network."""
STEP = 0.5
"""Seconds from figure to figure."""
SECONDS = 8.0
_PIXELS, _ACROSS, _HEIGHT = 80, 100, 106
"""Pixels of a metre, from figure to figure, and of a row."""
_TOP = 0.72
"""Metres from the top of a row down to the lower end of the spine."""
_COLOURS = (("#555", (0, 1, 2)), ("#c33", (3, 4, 5)), ("#26a", (6, 7, 8)))
_CSS = """body{font:14px sans-serif;margin:2em}table{border-collapse:collapse}td,th{padding:2px 8px;vertical-align:middle;
border-top:1px solid #ddd;text-align:left;font-weight:normal}th{min-width:9em}
small{color:#777}svg{display:block;overflow:visible}"""


@dataclass(frozen=True)
class Excerpt:
    """A stretch of speech: its sound as a file, the transcript (None: no words), and where it is known the ``seed`` pose
    ``(9, 3)``, the style (empty: each network's default) and the motion ``performed`` ``(frames, 9, 3)``.
    """

    name: str
    sound: Path
    transcript: Path | None = None
    text: str | None = None
    seed: np.ndarray | None = None
    style: str = ""
    performed: np.ndarray | None = None


class Row(NamedTuple):
    """A row: its title, a line about it, and directions ``(frames, 9, 3)``, one frame for a pose."""

    title: str
    about: str
    directions: np.ndarray


def from_corpus(data: str | PathLike, folder: Path, count: int = 2, seconds: float = SECONDS) -> list[Excerpt]:
    """Cut excerpts from the middle of ``count`` test recordings of a packed corpus; their sound and words go to ``folder``.

    Raises :class:`CorpusUnreadable` for a corpus without sound or test recordings.
    """
    corpus = Corpus.load(data)
    if "wave" not in corpus.arrays:
        raise CorpusUnreadable(f"{data} holds no sound (wave.npy).", "Convert the data set with: s2ag data")
    long = np.diff(corpus.starts) >= seconds * skeleton.FPS
    talks = np.flatnonzero((corpus.split == TEST) & long)
    _, firsts = np.unique(corpus.recording[talks], return_index=True)
    if not len(firsts):
        raise CorpusUnreadable(f"{data} holds no test recordings of {seconds:g} seconds.", "Use a larger one.")
    chosen = talks[np.sort(firsts)][np.unique(np.linspace(0, len(firsts) - 1, min(count, len(firsts))).astype(int))]
    return [_cut(corpus, int(talk), number, folder, seconds) for number, talk in enumerate(chosen)]


def perform(excerpt: Excerpt, checkpoint: str | None, seed: int = 0, seconds: float = SECONDS) -> tuple[np.ndarray, tuple]:
    """Return the directions ``(frames, 9, 3)`` that a checkpoint performs from the excerpt's seed pose, and its words."""
    known = [one["name"] for one in checkpoint_metadata.describe(checkpoint)["speakers"]]
    style = excerpt.style if excerpt.style in known else ""
    words = {"transcript": excerpt.transcript, "text": excerpt.text}
    request = Request(excerpt.sound, style=style, seed=seed, pose=seed_pose(excerpt), **words)
    result = Session(checkpoint).synthesize(request)
    frames = round(seconds * skeleton.FPS)
    return result.motions[0].directions[:frames], tuple(word for word in result.words if word[1] < seconds)


def seed_pose(excerpt: Excerpt) -> np.ndarray:
    """Return the pose ``(9, 3)`` from which all rows begin: the excerpt's, or rest."""
    return rest.REST if excerpt.seed is None else excerpt.seed


def about(checkpoint: str | None) -> str:
    """Return how long a checkpoint was trained, in a few words; empty where its facts do not say."""
    training = checkpoint_metadata.read_metadata(checkpoint_metadata.locate(checkpoint)).get("training", {})
    if not isinstance(training, dict) or "steps" not in training:
        return ""
    minutes = f", {training['minutes']:g} minutes" if isinstance(training.get("minutes"), int | float) else ""
    return f"{training['steps']} steps{minutes}"


def write(
    excerpts: Sequence[Excerpt],
    checkpoints: dict[str, str],
    path: Path,
    seed: int = 0,
    seconds: float = SECONDS,
    progress: Callable[[float], None] = lambda value: None,
) -> None:
    """Write the page to ``path``: a section for each excerpt, a row for each of ``checkpoints`` (title -> name or file)."""
    parts, count = [], len(excerpts) * max(len(checkpoints), 1)
    for number, excerpt in enumerate(excerpts):
        rows, words = [Row("seed pose", "", seed_pose(excerpt)[None])], ()
        if excerpt.performed is not None:
            rows.append(Row("performed", "the corpus's own motion", excerpt.performed))
        for place, (title, checkpoint) in enumerate(checkpoints.items()):
            directions, words = perform(excerpt, checkpoint, seed, seconds)
            rows.append(Row(title, about(checkpoint), directions))
            progress((number * len(checkpoints) + place + 1) / count)
        parts.append(section(excerpt, words, rows, seconds))
    page = f'<!doctype html><html lang="en"><meta charset="utf-8"><title>Figure 3</title><style>{_CSS}</style>{_INTRO}'
    with atomic_file(path) as temporary:
        temporary.write_text(page + "".join(parts) + "</html>\n", encoding="utf-8")


_INTRO = f"""<h1>Speech, seed pose, and what each network makes of them</h1><p>A figure every {STEP:g} seconds from the left to
the right, seen from the front; red is the left arm, blue the right one, and thin lines are the wrists' ways since the figure
before. All rows hear the same sound and words, begin in the same pose and perform in the same style, as users get them.</p>"""


def section(excerpt: Excerpt, words: Sequence[tuple], rows: Sequence[Row], seconds: float) -> str:
    """Return the HTML of an excerpt: its sound to play, words over time, and a row of figures for each of ``rows``."""
    style = f", as {excerpt.style}" if excerpt.style else ""
    lines = [f"<h2>{html.escape(excerpt.name + style)}</h2>{_player(excerpt.sound, seconds)}<table>"]
    lines.append(f"<tr><th>speech</th><td>{_words(words, seconds)}</td></tr>")
    for row in rows:
        title = f"{html.escape(row.title)}<br><small>{html.escape(_facts(row))}</small>"
        lines.append(f"<tr><th>{title}</th><td>{_figures(row.directions, seconds)}</td></tr>")
    return "".join(lines) + "</table>"


def _facts(row: Row) -> str:
    """Return what is known of a row, how fast its wrists move, and how many movements (bells of speed) both hands make."""
    if len(row.directions) < 2:
        return row.about
    speed = np.linalg.norm(np.diff(skeleton.wrists(row.directions), axis=0), axis=-1).mean() * skeleton.FPS
    count = len(moves(row.directions)[0]) / len(row.directions) * skeleton.FPS
    return "; ".join(filter(None, [row.about, f"wrists {100 * speed:.0f} cm/s, {count:.1f} movements a second"]))


def _width(seconds: float) -> int:
    return round((seconds / STEP + 1) * _ACROSS)


def _words(words: Sequence[tuple], seconds: float) -> str:
    """Return words at their times, on two lines in turn."""
    texts = [
        f'<text x="{_ACROSS / 2 + start / STEP * _ACROSS:.0f}" y="{16 + 18 * (number % 2)}">{html.escape(str(word))}</text>'
        for number, (word, start, *_) in enumerate(words)
    ]
    return f'<svg width="{_width(seconds)}" height="42" font-size="14">{"".join(texts)}</svg>'


def _figures(directions: np.ndarray, seconds: float) -> str:
    points = skeleton.canonical_to_y_up(skeleton.to_positions(skeleton.normalize(directions)))[..., :2]
    shift = np.array([_ACROSS / 2, _TOP * _PIXELS])
    frames = np.arange(0, len(points), round(STEP * skeleton.FPS))
    lines = []
    for column, frame in enumerate(frames):
        place = shift + (column * _ACROSS, 0)
        drawn = points * (_PIXELS, -_PIXELS) + place
        before = frames[column - 1] if column else frame
        for colour, edges in _COLOURS:
            ways = drawn[before : frame + 1, skeleton.EDGES[edges[-1]][1]]
            if edges != _COLOURS[0][1] and len(ways) > 1:
                lines.append(f'<polyline points="{_path(ways)}" stroke="{colour}" stroke-opacity=".35"/>')
            for edge in edges:
                bone = _path(drawn[frame, list(skeleton.EDGES[edge])])
                lines.append(f'<polyline points="{bone}" stroke="{colour}" stroke-width="2"/>')
    return f'<svg width="{_width(seconds)}" height="{_HEIGHT}" fill="none" stroke-linecap="round">{"".join(lines)}</svg>'


def _path(points: np.ndarray) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _player(sound: Path, seconds: float) -> str:
    """Return an HTML player that holds the first ``seconds`` of a recording, at 16 kHz."""
    with tempfile.TemporaryDirectory() as folder:
        write_wave(audio.load(sound)[: round(seconds * audio.SAMPLE_RATE)], Path(folder) / "heard.wav")
        held = base64.b64encode((Path(folder) / "heard.wav").read_bytes()).decode()
    return f'<audio controls src="data:audio/wav;base64,{held}"></audio>'


def _cut(corpus: Corpus, talk: int, number: int, folder: Path, seconds: float) -> Excerpt:
    """Return an excerpt from the middle of a performance, from the beginning of a word on."""
    recording, frames = corpus.recording[talk], round(seconds * skeleton.FPS)
    entry = corpus.meta["recordings"][recording]
    latest = int(corpus.starts[talk + 1] - corpus.starts[talk]) - frames
    begins = [at for _, at, _ in entry["words"] if 0 <= at * skeleton.FPS <= latest]
    at = min(begins, key=lambda one: abs(one - latest / 2 / skeleton.FPS)) if begins else 0.0
    first = round(at * skeleton.FPS)
    begin = corpus.arrays["wave_starts"][recording] + round(first / skeleton.FPS * audio.SAMPLE_RATE)
    sound, transcript = folder / f"{number}.wav", folder / f"{number}.json"
    samples = corpus.arrays["wave"][begin : begin + round(seconds * audio.SAMPLE_RATE)]
    write_wave(samples.astype(np.float32) / 32768, sound)
    shift = first / skeleton.FPS
    words = [
        {"word": word, "start": start - shift, "end": end - shift}
        for word, start, end in entry["words"]
        if start >= shift and end <= shift + seconds
    ]
    transcript.write_text(json.dumps({"segments": [{"start": 0, "end": seconds, "words": words}]}), encoding="utf-8")
    motion = skeleton.normalize(corpus.directions[corpus.starts[talk] + first :][:frames].astype(np.float32))
    name = f"Test recording {Path(str(entry.get('speech', number))).stem}, {shift:.1f} s"
    style = str(corpus.speakers[corpus.speaker[talk]]["name"])
    return Excerpt(name, sound, transcript if words else None, None, motion[0], style, motion)

