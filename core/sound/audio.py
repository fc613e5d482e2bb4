"""Decodes any audio or video file to 16 kHz mono float32, piece by piece, and normalises its speech level."""

import hashlib
import zlib
from collections.abc import Iterable, Iterator
from os import PathLike
from pathlib import Path
from types import ModuleType

import numpy as np

from ..errors import AudioUnreadable
from ..files import open_file
from ..optional_packages import has_av
from . import wavefile
from .resample import resample

SAMPLE_RATE = 16000
SPEECH_RMS = 0.05
"""RMS of active speech after scaling by :func:`speech_gain`: -26 dB relative to full scale, the usual telephony reference."""

RATE_LIMITS = 1_000, 384_000
"""Accepted sampling rates in Hz: lower ones make the result arbitrarily large, higher ones need long filters."""
LONG_SECONDS, MAX_SECONDS = 3600.0, 12 * 3600.0
"""Limits of duration in seconds: beyond the first a file must hold :data:`_MIN_BYTES_PER_SECOND`, the second is absolute."""

_MIN_BYTES_PER_SECOND = 500
"""The slowest speech codecs in use write 600 bytes a second, whereas days of silence can fit into a tiny file."""
_PARTS, _PART_FLOOR = 16, 1e-6
"""Parts of a recording that :func:`fingerprint` compares, and the share of its energy (-60 dB) below which a part is silent."""
_BLOCK = SAMPLE_RATE * 60
_DECLARES_LENGTH = {"flac", "aiff", "mov,mp4,m4a,3gp,3g2,mj2"}
"""Containers whose header states the length; for others FFmpeg only estimates it from the bit rate."""


def load(path: str | PathLike) -> np.ndarray:
    """Decode the first audio stream of any audio or video file to ``(n,)`` float32 mono at 16 kHz, full scale 1.

    WAV is read by :mod:`wavefile`, other formats by the package ``av``. Decoding goes piece by piece, so memory use is that
    of the result (230 MB an hour). Damaged packets are skipped, as in a player. Raises :class:`AudioUnreadable` if the file
    is missing, a folder, empty, of unknown format, without an audio stream or samples, shorter than its header says, or
    beyond the limits :data:`RATE_LIMITS`, :data:`LONG_SECONDS` and :data:`MAX_SECONDS`."""
    path = Path(path)
    _check(path)
    head = wavefile.read_header(path)
    if head and head.kind is not None:
        audio, declared = _mono(path, wavefile.read_samples(path, head), head.rate), 0.0
    else:
        audio, declared = _decode(path)
    if not len(audio):
        raise AudioUnreadable(f"{path} holds no sound at all (zero length).", "Choose another recording.")
    seconds = len(audio) / SAMPLE_RATE
    declared = max(declared, seconds / (head.share if head else 1.0))
    if declared - seconds > max(0.25, 0.02 * declared):
        raise AudioUnreadable(
            f"{path} is cut off: it ends after {seconds:.1f} s where its header promises {declared:.1f} s.",
            "Copy or export it again.",
        )
    return audio


def check_readable(path: str | PathLike) -> None:
    """Raise :class:`AudioUnreadable` unless ``path`` opens as a recording; no samples are decoded."""
    path = Path(path)
    _check(path)
    head = wavefile.read_header(path)
    if head and head.kind is not None:
        return
    with _decoder(path).audio_container(path):
        pass


def digest(audio: np.ndarray) -> str:
    """Return the hexadecimal SHA-256 of the samples as little-endian float32, independent of file name and format."""
    return hashlib.sha256(np.ascontiguousarray(audio, "<f4").data).hexdigest()


def fingerprint(audio: np.ndarray, part: str = "") -> int:
    """Return a number, 1 to 2**32 - 1, that tells recordings apart by their length and the levels of sixteen parts, and those
    who have a ``part`` in one recording by its name.

    Levels are whole dB relative to the recording's own. So another lossless format, another gain, and the last digits in which
    decoders and processors differ leave the number as it is, whereas :func:`digest` changes with every bit."""
    energy = np.array([np.square(part, dtype=float).sum() for part in np.array_split(audio, _PARTS)])
    levels = 10 * np.log10(energy / max(energy.sum(), 1e-30) + _PART_FLOOR)
    key = zlib.crc32(f"{len(audio)} {np.round(levels).astype(int).tolist()}".encode())
    return zlib.crc32(part.encode(), key) or 1


def speech_gain(audio: np.ndarray) -> float:
    """Return the factor that brings the active speech level to :data:`SPEECH_RMS`; 1 for silence.

    A 20 ms frame is active if its power is at most 10 dB below the mean of all frames that are not digital silence. These
    two gates follow loudness metering (ITU-R BS.1770); both are relative to the recording, so pauses, digital silence and
    room noise do not count."""
    audio = np.asarray(audio, np.float32)
    size = min(320, len(audio))
    if not size:
        return 1.0
    frames = audio[: len(audio) // size * size].reshape(-1, size)
    power = np.einsum("ij,ij->i", frames, frames) / size
    power = power[power > 1e-6 * power.max()].astype(float)
    if not len(power) or power.max() < 1e-14:
        return 1.0
    active = power[power >= 0.1 * power.mean()]
    return SPEECH_RMS / float(np.sqrt(active.mean()))


def _check(path: Path) -> None:
    if path.is_dir():
        raise AudioUnreadable(f"{path} is a folder, not a recording.", "Name a file inside it.")
    if not path.exists():
        raise AudioUnreadable(f"The recording {path} does not exist.", "Check the name and the folder.")
    try:
        with open_file(path) as file:
            if not file.read(1):
                raise AudioUnreadable(f"{path} is an empty file.", "Export or copy the recording again.")
    except OSError as error:
        raise AudioUnreadable(f"{path} cannot be opened: {error.strerror}.", "Check the file's permissions.") from error


def _decoder(path: Path) -> ModuleType:
    """Return the module that decodes by ``av``; raises :class:`AudioUnreadable` where it is missing."""
    if not has_av():
        what = f"{path} is no WAV file, and the package av, which reads all other recordings, is missing."
        raise AudioUnreadable(what, 'Save it as WAV, or install it with: pip install "s2ag[engine]".')
    from . import av_decoding

    return av_decoding


def _decode(path: Path) -> tuple[np.ndarray, float]:
    """Decode with ``av``; return the sound and the duration in seconds that the file declares, 0 if that is an estimate."""
    decoder = _decoder(path)
    with decoder.audio_container(path) as container:
        stream = container.streams.audio[0]
        rate = stream.rate or SAMPLE_RATE
        audio = _mono(path, decoder.decode_pieces(container, stream, rate), rate)
        if stream.duration and stream.time_base and container.format.name in _DECLARES_LENGTH:
            return audio, float(stream.duration * stream.time_base)
        return audio, 0.0


def _mono(path: Path, parts: Iterable[np.ndarray], rate: int) -> np.ndarray:
    """Mix pieces ``(channels, n)`` to ``(n,)`` float32 at :data:`SAMPLE_RATE`; NaN and infinity become silence."""
    if not RATE_LIMITS[0] <= rate <= RATE_LIMITS[1]:
        what = f"{path} has {rate} samples a second; {RATE_LIMITS[0]} to {RATE_LIMITS[1]} are read."
        raise AudioUnreadable(what, "Export it again, for instance at 48000.")
    mixed = (np.nan_to_num(part.mean(axis=0, dtype=np.float32), nan=0.0, posinf=0.0, neginf=0.0) for part in parts)
    longest = min(max(LONG_SECONDS, path.stat().st_size / _MIN_BYTES_PER_SECOND), MAX_SECONDS)
    return _join(_limit_duration(path, resample(mixed, rate, SAMPLE_RATE), longest))


def _limit_duration(path: Path, parts: Iterable[np.ndarray], seconds: float) -> Iterator[np.ndarray]:
    """Pass the parts on; raise :class:`AudioUnreadable` once they are longer than ``seconds``."""
    left = seconds * SAMPLE_RATE
    for part in parts:
        left -= len(part)
        if left < 0:
            what = f"{path} is longer than {seconds / 3600:.3g} hours, the most that a file of its size may hold."
            raise AudioUnreadable(what, "Cut it into shorter recordings.")
        yield part


def _join(pieces: Iterable[np.ndarray]) -> np.ndarray:
    """Concatenate many small pieces in one buffer that grows in place, so that peak memory is that of the result."""
    audio, filled = np.empty(_BLOCK, np.float32), 0
    for piece in pieces:
        if filled + len(piece) > len(audio):
            audio.resize(filled + len(piece) + _BLOCK, refcheck=False)
        audio[filled : filled + len(piece)] = piece
        filled += len(piece)
    audio.resize(filled, refcheck=False)
    return audio
