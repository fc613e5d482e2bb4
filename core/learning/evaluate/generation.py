"""Generates performances of talks by a checkpoint as for a user: with the same requests and the same session."""

import json
import wave
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path

import numpy as np

from ... import styles
from ...motion import rest
from ...motion.motion import Motion
from ...sound.audio import SAMPLE_RATE
from ...synthesis import generation
from ...synthesis.session import Request, Session
from ...synthesis.stages import Stages
from .talks import Talk


@dataclass(frozen=True)
class PerformanceOptions:
    """Options of a performance: style, seed, takes and controls by name (:data:`styles.CONTROLS`)."""

    style: str
    seed: int = 0
    takes: int = 1
    controls: dict[str, float] = field(default_factory=dict)


class Generator:
    """A session, and a folder for recordings and transcripts in the place of a user's files."""

    def __init__(self, checkpoint: str | PathLike | None, folder: str | PathLike) -> None:
        self.session = Session(checkpoint)
        self.folder = Path(folder)

    @property
    def names(self) -> list[str]:
        """Names of the checkpoint's speakers."""
        return [speaker["name"] for speaker in self.session.styles()]

    @property
    def steerable(self) -> bool:
        """Whether the checkpoint has controls."""
        return self.session.checkpoint.config.controls > 0

    @property
    def seed_frames(self) -> int:
        """Frames by which windows overlap."""
        return self.session.checkpoint.window[1]

    def known(self, name: str) -> str:
        """Return the name if the checkpoint has it, the default for no name, else another speaker chosen by the name."""
        if not name:
            return styles.default_speaker(self.session.styles())
        return name if name in self.names else self.names[sum(map(ord, name)) % len(self.names)]

    def rest(self, style: str) -> np.ndarray:
        """Return the speaker's pose between gestures, ``(9, 3)``."""
        return np.array(self.session.styles()[self.names.index(style)].get("rest", rest.REST), np.float32)

    def joins(self, frames: int) -> list[int]:
        """Return the frames at which windows of a performance of ``frames`` meet; none where all frames are drawn as one."""
        checkpoint = self.session.checkpoint
        if checkpoint.draws:
            return []
        from ...model import windows  # of the full engine

        return windows.window_starts(frames, *checkpoint.window)[1:]

    def perform(self, talk: Talk, wishes: Sequence[PerformanceOptions]) -> list[np.ndarray]:
        """Return directions ``(takes, frames, 9, 3)`` for every wish."""
        return [np.stack([motion.directions for motion in motions]) for motions in self.motions(talk, wishes, hands=0)]

    def motions(self, talk: Talk, wishes: Sequence[PerformanceOptions], hands: float = 1) -> list[list[Motion]]:
        """Return the takes of every wish; without hands if ``hands`` is 0."""
        requests = [self.request(talk, wish, hands) for wish in wishes]
        return [result.motions for result in self.session.synthesize_all(requests)]

    def request(self, talk: Talk, wish: PerformanceOptions, hands: float = 1) -> Request:
        """Return a wish as a user would ask for it."""
        audio, transcript = self._files(talk)
        of_wish = {"style": wish.style, "seed": wish.seed, "takes": wish.takes, **self._controls(wish.controls)}
        return Request(audio=audio, transcript=transcript, hands=hands, **of_wish)

    def drawn_and_finished(
        self, talk: Talk, style: str, seed: int, intensities: Sequence[float], beats: bool = False
    ) -> tuple[np.ndarray, list[Motion]]:
        """Return the directions ``(frames, 9, 3)`` of one take as the network draws it, and the take at each intensity.

        With ``beats`` the take at its usual size without any gesture of meaning is one more, the last.
        """
        audio, transcript = self._files(talk)
        self.session.remember()  # the recording is heard once, and the take drawn once for all intensities
        wish = {"transcript": transcript, "style": style, "seed": seed, "hands": 1.0}
        requests = [Request(audio, intensity=size, **wish) for size in intensities]
        if beats:
            requests.append(replace(requests[0], intensity=1.0, meanings={"format": 1, "gestures": []}))
        heard, performers = self.session.hear(requests[0], Stages(lambda stage, value: None, lambda: False))
        drawn = generation.generate(self.session.checkpoint, heard, [performers]).directions[0]
        return drawn, [self.session.synthesize(request).motions[0] for request in requests]

    def _controls(self, controls: dict[str, float]) -> dict:
        """Return controls as arguments of a :class:`Request`; nothing for a checkpoint without controls."""
        arguments = {name: value for name, value in controls.items() if value} if self.steerable else {}
        affect = {name: arguments.pop(name) for name in ("arousal", "valence", "dominance") if name in arguments}
        return {**arguments, "affect": affect} if affect else arguments

    def _files(self, talk: Talk) -> tuple[Path, Path | None]:
        """Write the recording and its timed words as files, if they are missing."""
        name = f"{talk.name}-{zlib.crc32(talk.audio.tobytes()):08x}"  # pieces of a recording may share their name
        audio, transcript = self.folder / f"{name}.wav", self.folder / f"{name}.json"
        if not audio.exists():
            write_wave(talk.audio, audio)
            transcript.write_text(json.dumps(talk.words), "utf-8")
        return audio, transcript if talk.words else None


def write_wave(audio: np.ndarray, path: str | PathLike) -> None:
    """Write ``(n,)`` float32 at 16 kHz as 16-bit WAV."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(SAMPLE_RATE)
        file.writeframes(np.round(np.clip(audio, -1, 1) * 32767).astype("<i2").tobytes())
