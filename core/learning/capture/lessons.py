"""Films that capture learns from: many characters, colours, lights, cameras that wander; other motions than are reported."""

import io
import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...files import atomic_file
from ...motion import quaternion, skeleton
from ...motion.hands import Hands
from ...motion.motion import Motion
from ...motion.skeleton import FPS
from ...smoothing import gaussian
from ...synthesis.request import Request
from ...synthesis.session import Session
from ..own_style import trial
from . import estimator, filmed, weights
from .landmarks import Landmarks

COUNT, SIZE = 282, (704, 448)
"""Films, and pixels of their pictures; each is looked at as it is, and made worse."""
PEOPLE = 80
"""People made by chance that are filmed beside the characters."""
_SECONDS = 4.0
_LIGHTS = "Default", "basic.sl", "outdoor.sl", "paint.sl", "rim.sl", "studio.sl"
_ASIDE, _ABOVE, _WANDER = 42.0, (-13.0, 18.0), (28.0, 9.0)
"""Degrees: how far cameras stand aside, how far above, and how far they wander within a film."""
_ARM, _FOREARM = 10.0, 14.0
"""Deviations in degrees by which arms are turned in two of three films, so that poses are more various than performances."""
_SWAY, _MORE = 0.7, 1.7
"""In the last quarter of the films these turns change: seconds of the Gaussian over them, and how much larger they are."""

Lesson = tuple[Landmarks, Motion, np.ndarray]


def learn(
    folder: Path, recordings: Sequence[Path], characters: Sequence[tuple[str, str]], run: filmed.Run, tell: Callable
) -> str:
    """Film, look, learn, and write the weights; return what was learned from as a sentence. Raises S2agError."""
    from . import lifting_training

    estimator.python()
    films = make(folder, recordings, characters, run, tell)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **lifting_training.learn(films, lambda share: tell("learn", share)))
    with atomic_file(weights.FILE) as temporary:
        temporary.write_bytes(buffer.getbuffer())
    weights.forget()
    return f"Learned from {len(films)} films, {sum(len(found) for found, _, _ in films)} pictures: {weights.FILE}."


def make(
    folder: Path, recordings: Sequence[Path], characters: Sequence[tuple[str, str]], run: filmed.Run, tell: Callable
) -> list[Lesson]:
    """Return what was seen in the films of a folder, the motions, and the angles of the cameras; films that are not there yet
    are made first. Raises S2agError."""
    folder.mkdir(parents=True, exist_ok=True)
    characters = [*_people(folder, run), *characters]
    missing = [number for number in range(COUNT) if not _facts(folder, number).is_file()]
    _perform(folder, [number for number in missing if not _file(folder, number).is_file()], recordings, tell)
    for row, (character, gender) in enumerate(characters):
        own = [number for number in missing if number % len(characters) == row]
        if own:
            _film(folder, own, character, gender, run, lambda share, who=character: tell(f"film {who}", share))
    lessons = []
    for number in range(COUNT):
        tell("look", number / COUNT)
        angles = np.array(json.loads(_facts(folder, number).read_text("utf-8"))["angles"])
        for film in (folder / f"{number:03d}.mp4", _worse(folder, number)):
            kept = film.with_suffix(".seen.npz")
            found = Landmarks.load(kept) if kept.is_file() else estimator.look(film, kept=kept)
            rows = np.clip(np.round(found.times * filmed.RATE).astype(int), 0, len(angles) - 1)
            lessons.append((found, Motion.load(_file(folder, number)), angles[rows]))
    return lessons


def _people(folder: Path, run: filmed.Run) -> list[tuple[str, str]]:
    """Make people by chance who are not there yet, and return all. Raises S2agError."""
    every = [folder / f"person{number:02d}.blend" for number in range(PEOPLE)]
    missing = [{"number": number, "output": str(path)} for number, path in enumerate(every) if not path.is_file()]
    if missing:
        job = folder / "people.job"
        job.write_text(json.dumps({"people": missing}), "utf-8")
        run("render.capture_people", str(job))
    return [(str(path), "female") for path in every]


def _film(folder: Path, numbers: Sequence[int], character: str, gender: str, run: filmed.Run, tell: Callable) -> None:
    shots, angles = [], {}
    for number in numbers:
        random = np.random.default_rng(number)
        frames = len(Motion.load(_file(folder, number)).directions)
        wander = np.linspace(-0.5, 0.5, frames)[:, None] * random.uniform(-1, 1, 2) * _WANDER
        middle = random.uniform([-0.9 * _ASIDE, 0.85 * _ABOVE[0]], [0.9 * _ASIDE, 0.85 * _ABOVE[1]])
        angles[number] = np.clip(middle + wander, [-_ASIDE, _ABOVE[0]], [_ASIDE, _ABOVE[1]])
        lens, low = float(random.uniform(24, 75)), float(random.uniform(0.34, 0.5))
        light = [_LIGHTS[random.integers(len(_LIGHTS))], float(random.uniform(-0.9, 0.4))]
        shots.append({
            "motion": str(_file(folder, number)), "camera": [[*spot, lens, low] for spot in angles[number].tolist()],
            "light": light, "look": number, "output": str(folder / f"{number:03d}.mp4"),
        })  # fmt: skip
    job = folder / f"{Path(character).stem}-{gender}.job"
    content = {"character": character, "gender": gender, "fps": filmed.RATE, "resolution": SIZE, "shots": shots}
    job.write_text(json.dumps(content), "utf-8")
    run("render.capture_films", str(job), progress=lambda stage, share: tell(share))
    for number, way in angles.items():
        film, random = folder / f"{number:03d}.mp4", np.random.default_rng(number)
        filmed.worsen(film, _worse(folder, number), float(random.uniform(3, 11)), int(random.integers(27, 38)))
        with atomic_file(_facts(folder, number)) as temporary:
            facts = {"character": Path(character).stem, "gender": gender, "angles": way.round(3).tolist()}
            temporary.write_text(json.dumps(facts), "utf-8")


def _perform(folder: Path, numbers: Sequence[int], recordings: Sequence[Path], tell: Callable) -> None:
    """Perform recordings in the styles that ``s2ag evaluate --own-styles`` does not ask about."""
    if not numbers:
        return
    session, frames = Session(remember=True), round(_SECONDS * FPS)
    names = [style["name"] for style in session.styles() if style["name"] not in trial.USUAL]
    for number in numbers:
        tell("perform", number / COUNT)
        random, recording = np.random.default_rng(number), recordings[number % len(recordings)]
        request = Request(recording, style=names[number % len(names)], seed=1000 + number, hands=1.0)
        motion: Motion = session.synthesize(request).motions[0]
        begin = int(random.integers(max(len(motion.directions) - frames, 1)))
        motion = motion.frames(slice(begin, begin + frames + 1))
        (_turned(motion, random, number >= 3 * COUNT // 4) if number % 3 else motion).save(_file(folder, number))


def _turned(motion: Motion, random: np.random.Generator, swaying: bool = False) -> Motion:
    """Turn arms and hands of a motion by some degrees, which change where they are ``swaying``."""
    directions = motion.directions.astype(float)
    hands = motion.hands
    knuckles, palms = (part.astype(float) for part in (hands.knuckles, hands.palms)) if hands is not None else (None, None)
    for side, (upper, fore) in enumerate(skeleton.ARMS):
        arm = _rotations(random, _ARM, len(directions), swaying)
        whole = _rotations(random, _FOREARM, len(directions), swaying) @ arm
        directions[:, upper] = np.einsum("fij,fj->fi", arm, directions[:, upper])
        directions[:, fore] = np.einsum("fij,fj->fi", whole, directions[:, fore])
        for part in (knuckles, palms):
            if part is not None:
                part[:, side] = np.einsum("fij,fj->fi", whole, part[:, side])
    moved = hands if hands is None or knuckles is None or palms is None else Hands.of(knuckles, palms, hands.shape)
    return replace(motion, directions=directions.astype(np.float32), hands=moved)


def _rotations(random: np.random.Generator, spread: float, frames: int, swaying: bool) -> np.ndarray:
    """Return rotations ``(frames, 3, 3)`` about any axis: one, or such that change."""
    turn = skeleton.normalize(random.normal(size=3)) * random.normal(0, spread)
    turns = np.tile(turn, (frames, 1))
    if swaying:
        turns = gaussian(random.normal(size=(frames, 3)), _SWAY * FPS)
        turns *= _MORE * spread / np.sqrt(3) / max(float(turns.std()), 1e-6)
    angles = np.linalg.norm(turns, axis=1)
    return quaternion.to_matrix(quaternion.about(skeleton.normalize(turns), np.radians(angles)))


def _file(folder: Path, number: int) -> Path:
    return folder / f"{number:03d}.npz"


def _worse(folder: Path, number: int) -> Path:
    return folder / f"{number:03d}-half.mp4"


def _facts(folder: Path, number: int) -> Path:
    return folder / f"{number:03d}.json"
