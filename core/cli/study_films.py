"""Renders the motions among a study's clips as films of one character."""

import contextlib
import json
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from .. import characters
from ..errors import UsageError
from . import blender, motion_input
from .progress import Progress, note

_SOUNDS = (".wav", ".flac", ".mp3", ".ogg", ".m4a")


@contextlib.contextmanager
def render_clips(clips: Path, character: str, speech: Path | None) -> Iterator[Path]:
    """Yield a temporary copy of ``clips`` in which motions are rendered as films; without motions, ``clips`` itself.

    Each motion needs a recording of the same name beside it or in ``speech``; films are copied. Raises :class:`UsageError`
    before rendering, and the errors of reading and rendering.
    """
    from ..study.design import CLIPS

    places = sorted(path for path in clips.iterdir() if path.is_dir()) if clips.is_dir() else []
    motions = [path for place in places for path in sorted(place.iterdir()) if motion_input.is_motion(path)]
    motions = [path for path in motions if not any(path.with_suffix(suffix).is_file() for suffix in CLIPS)]
    if not motions:
        yield clips
        return
    who, sounds = characters.resolve(character), [_sound(path, speech) for path in motions]
    blender.command("render.job")
    with tempfile.TemporaryDirectory(prefix=blender.PREFIX) as folder:
        for place in places:
            (Path(folder) / "clips" / place.name).mkdir(parents=True)
            for path in sorted(place.iterdir()):
                if path.suffix.lower() in CLIPS:
                    shutil.copyfile(path, Path(folder) / "clips" / place.name / path.name)
        for path, sound in zip(motions, sounds, strict=True):
            _film(path, sound, who, Path(folder))
        yield Path(folder) / "clips"


def _film(path: Path, sound: Path, who: str, folder: Path) -> None:
    """Render the motion ``path`` as a film in ``folder``."""
    from ..motion.readers import motion_files

    film = folder / "clips" / path.parent.name / f"{path.stem}.mp4"
    motion_files.load(path).save(folder / "motion.npz")
    engine = None if Path(who).suffix.lower() == ".blend" else "workbench"
    audio = str(sound.absolute())
    job = {"motions": [str(folder / "motion.npz")], "audio": audio, "character": who, "engine": engine, "outputs": [str(film)]}
    (folder / "job.json").write_text(json.dumps(job), "utf-8")
    with Progress() as progress:
        result = blender.run("render.job", str(folder / "job.json"), progress=lambda stage, value: progress(film.name, value))
    for warning in result.get("warnings", ()):
        note(f"{path.parent.name}/{path.name}: {warning}")


def _sound(motion: Path, speech: Path | None) -> Path:
    """Return the recording with the name of a motion; raises :class:`UsageError`."""
    for place in filter(None, (motion.parent, speech)):
        for suffix in _SOUNDS:
            if (place / f"{motion.stem}{suffix}").is_file():
                return place / f"{motion.stem}{suffix}"
    raise UsageError(f"{motion} has no recording.", f"Put {motion.stem}.wav beside it, or name its folder with --speech.")
