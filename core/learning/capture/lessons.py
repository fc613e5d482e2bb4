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
from ...synthesis.request import Request
from ...synthesis.session import Session
from ..own_style import trial
from . import estimator, filmed, weights
from .landmarks import Landmarks

COUNT, SIZE = 140, (704, 448)
"""Films, and pixels of their pictures; every other one is made worse afterwards."""
_LIGHTS = "Default", "basic.sl", "outdoor.sl", "paint.sl", "rim.sl", "studio.sl"
_ASIDE, _ABOVE, _WANDER = 42.0, (-13.0, 18.0), (28.0, 9.0)
"""Degrees: how far cameras stand aside, how far above, and how far they wander within a film."""
_ARM, _FOREARM = 10.0, 14.0
"""Deviations in degrees by which arms are turned in two of three films, so that poses are more various than performances."""

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
    missing = [number for number in range(COUNT) if not _facts(folder, number).is_file()]
    _perform(folder, [number for number in missing if not _file(folder, number).is_file()], recordings, tell)
    for row, (character, gender) in enumerate(characters):
        own = [number for number in missing if number % len(characters) == row]
        if own:
            _film(folder, own, character, gender, run, lambda share, who=character: tell(f"film {who}", share))
    lessons = []
    for number in range(COUNT):
        tell("look", number / COUNT)
        film, kept = folder / f"{number:03d}.mp4", folder / f"{number:03d}.seen.npz"
        found = Landmarks.load(kept) if kept.is_file() else estimator.look(film, kept=kept)
        angles = np.array(json.loads(_facts(folder, number).read_text("utf-8"))["angles"])
        rows = np.clip(np.round(found.times * filmed.RATE).astype(int), 0, len(angles) - 1)
        lessons.append((found, Motion.load(_file(folder, number)), angles[rows]))
    return lessons


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
        if number % 2 == 0:
            filmed.worsen(film, film, float(random.uniform(2, 10)), int(random.integers(24, 37)))
        with atomic_file(_facts(folder, number)) as temporary:
            facts = {"character": Path(character).stem, "gender": gender, "angles": way.round(3).tolist()}
            temporary.write_text(json.dumps(facts), "utf-8")


def _perform(folder: Path, numbers: Sequence[int], recordings: Sequence[Path], tell: Callable) -> None:
    """Perform recordings in the styles that ``s2ag evaluate --own-styles`` does not ask about."""
    if not numbers:
        return
    session, frames = Session(remember=True), round(filmed.SECONDS * FPS)
    names = [style["name"] for style in session.styles() if style["name"] not in trial.USUAL]
    for number in numbers:
        tell("perform", number / COUNT)
        random, recording = np.random.default_rng(number), recordings[number % len(recordings)]
        request = Request(recording, style=names[number % len(names)], seed=1000 + number, hands=1.0)
        motion: Motion = session.synthesize(request).motions[0]
        begin = int(random.integers(max(len(motion.directions) - frames, 1)))
        motion = motion.frames(slice(begin, begin + frames + 1))
        (_turned(motion, random) if number % 3 else motion).save(_file(folder, number))


def _turned(motion: Motion, random: np.random.Generator) -> Motion:
    """Turn arms and hands of a motion by some degrees."""
    directions = motion.directions.astype(float)
    hands = motion.hands
    knuckles, palms = (part.astype(float) for part in (hands.knuckles, hands.palms)) if hands is not None else (None, None)
    for side, (upper, fore) in enumerate(skeleton.ARMS):
        arm = _rotation(random, _ARM)
        whole = _rotation(random, _FOREARM) @ arm
        directions[:, upper] = directions[:, upper] @ arm.T
        directions[:, fore] = directions[:, fore] @ whole.T
        for part in (knuckles, palms):
            if part is not None:
                part[:, side] = part[:, side] @ whole.T
    moved = hands if hands is None or knuckles is None or palms is None else Hands.of(knuckles, palms, hands.shape)
    return replace(motion, directions=directions.astype(np.float32), hands=moved)


def _rotation(random: np.random.Generator, spread: float) -> np.ndarray:
    """Return a rotation about any axis."""
    axis, angle = skeleton.normalize(random.normal(size=3)), np.radians(random.normal(0, spread))
    return quaternion.to_matrix(quaternion.about(axis, angle))


def _file(folder: Path, number: int) -> Path:
    return folder / f"{number:03d}.npz"


def _facts(folder: Path, number: int) -> Path:
    return folder / f"{number:03d}.json"
