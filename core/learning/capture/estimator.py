"""Runs the pose estimator (``pose_program.py``) in a Python of its own and collects what it sees in a film."""

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from os import PathLike
from pathlib import Path

import numpy as np

from ... import child_process
from ...errors import CorpusUnreadable, EngineMissing, S2agError
from ...files import sha256
from . import film
from .landmarks import BODY, FACE, HAND, Landmarks, points

VARIABLE = "S2AG_CAPTURE_PYTHON"
"""Environment variable that names the Python in which the estimator's package is installed."""
ADVICE = (
    "Install it beside the engine: python3.11 -m venv capture, then capture/bin/pip install mediapipe==0.10.14, and let "
    f"{VARIABLE} name capture/bin/python."
)
WHOLE = (0.0, 0.0, 1.0, 1.0)
_PROGRAM = Path(__file__).with_name("pose_program.py")
_SAVE_EVERY, _SAVING = 2.0, 0.05
"""Seconds between two savings of what has been seen, as a capture may be ended at any moment; the share of time they take."""
_LIMIT = 600.0, 60.0
"""Seconds that a film may take, and more for each of its seconds: only a program that hangs takes that long."""


def python() -> str:
    """Return the Python that has the estimator; raises :class:`EngineMissing`."""
    named = os.environ.get(VARIABLE, "").strip()
    if named:
        if not Path(named).is_file():
            raise EngineMissing(f"{VARIABLE} names {named}, which is no file.", ADVICE)
        return named
    if find_spec("mediapipe") is None:
        raise EngineMissing("The pose estimator is not installed.", ADVICE)
    return sys.executable


def look(
    path: str | PathLike,
    region: tuple[float, float, float, float] = WHOLE,
    kept: str | PathLike | None = None,
    progress: Callable[[float], object] = lambda share: None,
) -> Landmarks:
    """Return what the estimator sees in the part ``region`` (left, top, right, bottom in shares) of a film's pictures.

    What has been seen is saved in the file ``kept`` on the way, also when this is interrupted, and the next call goes on from
    it. Raises :class:`EngineMissing` and :class:`CorpusUnreadable`.
    """
    seen = _Seen(Path(path), region, kept)
    share = film.facts(path).seconds

    def hear(answer: dict) -> object:
        if "done" in answer:
            return True
        seen.add(answer)
        progress(min(seen.times[-1] / max(share, seen.times[-1], 1e-6), 1.0))
        return None

    try:
        run("pose", seen.pictures(), hear, share)
    finally:
        seen.save()
    found = seen.landmarks()
    if not len(found) or np.isnan(found.pose[:, 0, 0]).all():
        raise CorpusUnreadable(f"Nobody is seen in {path}.", "Choose a film that shows a person from the front.")
    return found


def run(mode: str, pictures: Iterator[tuple[bool, np.ndarray]], hear: Callable[[dict], object], seconds: float) -> None:
    """Send (new scene, pixels) to the program and its answers to ``hear`` until that returns something.

    Errors of ``pictures`` are raised here. Raises :class:`EngineMissing` where the program cannot run.
    """
    first = next(pictures, None)
    if first is None:
        return
    command, failure = [python(), "-I", os.fspath(_PROGRAM)], []
    height, width = first[1].shape[:2]

    def data() -> Iterator[bytes]:
        try:
            yield _packed(*first)
            for new, pixels in pictures:
                if pixels.shape == first[1].shape:
                    yield _packed(new, pixels)
        except S2agError as error:
            failure.append(error)

    request = {"mode": mode, "width": width, "height": height}
    try:
        child_process.run_request(command, request, data(), _LIMIT[0] + _LIMIT[1] * seconds, hear)
    except child_process.ChildFailed as error:
        raise EngineMissing(f"The pose estimator {error}; {command[0]} needs the package mediapipe.", ADVICE) from error
    if failure:
        raise failure[0]


def _packed(new: bool, pixels: np.ndarray) -> bytes:
    return bytes([new]) + np.ascontiguousarray(pixels).tobytes()


class _Seen:
    """What has been seen of a film: times and changes of all pictures sent, points of all that were answered."""

    def __init__(self, path: Path, region: tuple, kept: str | PathLike | None):
        self.path, self.region, self.kept = path, region, kept
        self.film = sha256(path) if path.is_file() else ""
        self.times: list[float] = []
        self.changes: list[float] = []
        self.answers: list[tuple[np.ndarray, ...]] = []
        self.size, self._due, self._old = np.zeros(2, int), time.monotonic() + _SAVE_EVERY, self._load()

    def _load(self) -> Landmarks | None:
        if self.kept is None or not Path(self.kept).is_file():
            return None
        with contextlib.suppress(CorpusUnreadable):  # begun anew, and written again
            old = Landmarks.load(self.kept)
            if str(old.film) == self.film and np.allclose(old.region, self.region):
                return old
        return None

    def pictures(self) -> Iterator[tuple[bool, np.ndarray]]:
        """Yield whether a scene begins, and the pixels, of every picture that has not been seen."""
        done, before = len(self._old) if self._old else 0, None
        for number, picture in enumerate(film.pictures(self.path)):
            small = film.thumbnail(picture.pixels)
            change = 0.0 if before is None else float(np.abs(small - before).mean())
            before = small
            if number < done:
                continue
            height, width = picture.pixels.shape[:2]
            left, top, right, bottom = np.round(np.array(self.region) * [width, height, width, height]).astype(int)
            self.size = np.array([right - left, bottom - top])
            self.times.append(picture.time)
            self.changes.append(change)
            yield number == done or change > film.CUT, film.brightened(picture.pixels[top:bottom, left:right])

    def add(self, answer: dict) -> None:
        """Take an answer; save if it is time. Raises ValueError and KeyError for nonsense."""
        pose = points(answer["pose"], (BODY, 4))
        hands = (points(answer[side], (HAND, 3)) for side in ("left", "right"))
        self.answers.append((pose, points(answer["world"], (BODY, 3)), *hands, points(answer["face"], (FACE, 3))))
        if time.monotonic() > self._due:
            self.save()

    def landmarks(self) -> Landmarks:
        """Return all that has been seen, now and before."""
        count = len(self.answers)
        shapes = ((BODY, 4), (BODY, 3), (HAND, 3), (HAND, 3), (FACE, 3))
        parts = [
            np.array([answer[k] for answer in self.answers], np.float32).reshape(-1, *shape) for k, shape in enumerate(shapes)
        ]
        new: list[np.ndarray] = [np.array(self.times[:count]), np.array(self.changes[:count]), *parts]
        if self._old is not None:
            old = self._old
            before = (old.times, old.changes, old.pose, old.world, old.left, old.right, old.face)
            new = [np.concatenate(pair) for pair in zip(before, new, strict=True)]
        size = self.size if self.size.any() or self._old is None else self._old.size
        times, changes, pose, world, left, right, face = new
        about = size, np.array(self.film), np.array(self.region, float)
        return Landmarks(times, changes, pose, world, left, right, face, *about)

    def save(self) -> None:
        """Write what has been seen to the file it is kept in."""
        begun = time.monotonic()
        if self.kept is not None and self.answers:
            self.landmarks().save(self.kept)
        now = time.monotonic()
        self._due = now + max(_SAVE_EVERY, (now - begun) / _SAVING)
