"""Films of known motions for ``s2ag evaluate --capture``: characters, cameras, lights; Blender makes them, and they stay."""

import itertools
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from ...files import atomic_file
from ...motion.motion import Motion
from ...motion.skeleton import FPS
from ...synthesis.request import Request
from ...synthesis.session import Session
from . import film

CHARACTERS = (("human", "female"), ("human", "male"), ("mannequin", "female"))
CAMERAS = {
    "front": (6.0, 2.0, 60.0, 0.42),
    "desk": (-10.0, -7.0, 28.0, 0.46),
    "aside": (30.0, 11.0, 40.0, 0.42),
}
"""Degrees to the performer's left and upwards from where the performer looks, focal length in millimetres on a sensor of 36,
and the lowest height seen, in body heights: a long lens on a stand, a telephone on a desk, one held by somebody at the side."""
LIGHTS = {"studio": ("paint.sl", 0.0), "dim": ("rim.sl", -0.7)}
"""Blender's studio light, and the exposure in stops."""
RATE, SIZE = 15, (800, 448)
SECONDS = 12.0
_NOISE, _QUALITY = 8.0, 34
"""Deviation of the noise in steps of brightness (of 255) and constant rate factor of the H.264 of worse films."""

Run = Callable[..., dict]
"""Runs a module of s2ag_blender with the path of a job."""


@dataclass(frozen=True)
class Shot:
    """A film of a known motion: who is seen, by what camera and in what light, and where the files lie."""

    character: str
    gender: str
    camera: str
    light: str
    folder: Path

    @property
    def name(self) -> str:
        return "-".join((self.who, self.camera, self.light))

    @property
    def who(self) -> str:
        """What the character is called in names of files and in tables."""
        return self.gender if self.character == "human" else Path(self.character).stem

    @property
    def motion(self) -> Path:
        return self.folder / f"{self.name}.npz"

    @property
    def film(self) -> Path:
        return self.folder / f"{self.name}.mp4"

    @property
    def worse(self) -> Path:
        """The film with noise, at half size and strongly compressed."""
        return self.folder / f"{self.name}-half.mp4"


def plan(folder: Path, characters: Sequence[tuple[str, str]] = CHARACTERS) -> list[Shot]:
    """Return all shots of characters, each with its gender."""
    return [Shot(*who, *seen, folder) for who in characters for seen in itertools.product(CAMERAS, LIGHTS)]


def make(shots: Sequence[Shot], recordings: Sequence[Path], run: Run, tell: Callable) -> None:
    """Make the films of shots that are not there yet; ``tell(stage, share)`` hears of it. Raises S2agError."""
    missing = [shot for shot in shots if not shot.film.is_file()]
    _perform(shots, recordings, tell)
    for character, gender in dict.fromkeys((shot.character, shot.gender) for shot in missing):
        own = [shot for shot in missing if (shot.character, shot.gender) == (character, gender)]
        parts = [
            {"motion": str(shot.motion), "camera": CAMERAS[shot.camera], "light": LIGHTS[shot.light], "output": str(shot.film)}
            for shot in own
        ]
        job = own[0].folder / f"{own[0].who}.job"
        content = {"character": character, "gender": gender, "fps": RATE, "resolution": SIZE, "shots": parts}
        job.write_text(json.dumps(content), "utf-8")
        run("render.capture_films", str(job), progress=lambda stage, share, who=own[0].name: tell(f"film {who}", share))
    for number, shot in enumerate(shots):
        tell("half size", number / len(shots))
        if not shot.worse.is_file():
            worsen(shot.film, shot.worse)


def worsen(source: Path, target: Path, noise: float = _NOISE, quality: int = _QUALITY) -> None:
    """Write a film again with noise, at half size, strongly compressed."""
    import av

    random = np.random.default_rng(1)
    with atomic_file(target) as temporary, av.open(str(temporary), "w", format="mp4") as container:
        stream = None
        for picture in film.pictures(source):
            half = picture.pixels[::2, ::2].astype(float) + random.normal(0, noise, (*picture.pixels[::2, ::2].shape[:2], 1))
            pixels = np.clip(half, 0, 255).astype(np.uint8)
            if stream is None:
                stream = container.add_stream("libx264", rate=Fraction(RATE), options={"crf": str(quality)})
                stream.height, stream.width, stream.pix_fmt = pixels.shape[0], pixels.shape[1], "yuv420p"
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="rgb24")))
        if stream is not None:
            container.mux(stream.encode(None))


def _perform(shots: Sequence[Shot], recordings: Sequence[Path], tell: Callable) -> None:
    """Perform the recordings in other styles for every shot that has no motion."""
    missing = [(number, shot) for number, shot in enumerate(shots) if not shot.motion.is_file()]
    if not missing:
        return
    session = Session(remember=True)
    names, frames = [style["name"] for style in session.styles()], round(SECONDS * FPS)
    for number, shot in missing:
        tell("perform", number / len(shots))
        style = names[5 * number % len(names)]
        request = Request(recordings[number % len(recordings)], style=style, seed=number, hands=1.0)
        motion: Motion = session.synthesize(request).motions[0]
        begin = (number * 37) % max(len(motion.directions) - frames, 1)
        motion.frames(slice(begin, begin + frames + 1)).save(shot.motion)
