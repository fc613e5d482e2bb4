"""Decodes recordings by Blender's sound system, for an engine that reads nothing but WAV.

Blender's ``aud`` holds Python while it decodes, so a thread requests a few seconds at a time. After a seek some formats
continue a little beside the requested place; pieces therefore overlap and are joined where they are the same."""

import struct
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np

from ...core.errors import AudioUnreadable, Cancelled, OutputUnwritable, S2agError
from ...core.optional_packages import has_av
from ...core.sound import wavefile
from ...core.sound.resample import resample
from .. import compat

RATE = 16000
PIECE, OVERLAP, SEAM = 6.0, 1.0, 0.25
"""Seconds of a piece, of the overlap of two pieces, and of what is compared to join them."""
_MIN_SEAM_CORRELATION = 0.7
"""Correlation from which on two seams count as the same sound."""
_PAUSE = 0.001
"""Seconds between pieces in which Blender's own thread may go on."""
_DECLARES_LENGTH = {".flac", ".aif", ".aiff", ".m4a", ".mp4", ".mov", ".3gp"}
"""Files whose header states the length; elsewhere it is guessed from the bit rate, which proves nothing."""
_MAX_CACHED = 4

_cache: dict[tuple, Path] = {}


def needs_decoding(path: str) -> bool:
    """Return whether Blender has to decode a recording, because it is no WAV file.

    Raises :class:`AudioUnreadable` where it is none and neither this Blender nor its Python can decode it."""
    try:
        head = wavefile.read_header(Path(path))
    except OSError:
        return False  # the engine raises an error for it
    if head is not None and head.kind is not None:
        return False
    if _has_aud():
        return True
    if has_av():
        return False  # the engine decodes by itself
    what = "This build of Blender has no sound system for add-ons, so WAV files are the only recordings that it can read."
    raise AudioUnreadable(what, "Convert the recording to WAV, or choose a Python with the full engine in the preferences.")


def _has_aud() -> bool:
    """Return whether Python reaches the sound system; builds of some distributions and the ``bpy`` 4.2 package lack it."""
    try:
        import aud  # noqa: F401
    except ImportError:
        return False
    return True


class Decoding:
    """Decodes a recording to a WAV file of 16 kHz in a thread; ``value`` is its progress, 0..1."""

    stage = "decode audio"

    def __init__(self, path: str) -> None:
        self.value = 0.0
        self.result: str | None = None
        self.error: S2agError | None = None
        self._path = Path(path)
        self._cancelled = threading.Event()
        self._thread = threading.Thread(target=self._work, name="s2ag decode", daemon=True)
        self._thread.start()

    def poll(self) -> bool:
        """Return whether it ended, with ``result`` or ``error``."""
        return not self._thread.is_alive()

    def cancel(self) -> None:
        """Stop after the current piece."""
        self._cancelled.set()

    def outcome(self) -> str:
        """Wait for the end and return the WAV file; raises the :class:`S2agError` that it ended with."""
        self._thread.join()
        if self.error is not None:
            raise self.error
        assert self.result is not None
        return self.result

    def _work(self) -> None:
        try:
            self.result = str(self._decode())
        except S2agError as error:
            self.error = error
        except OSError as error:
            what = f"The decoded recording cannot be kept: {error.strerror or error}."
            self.error = OutputUnwritable(what, "Free some space in Blender's temporary folder.")
        except Exception as error:  # aud has an exception of its own
            what = f"{self._path} is not a readable recording ({str(error).rstrip('.')})."
            self.error = AudioUnreadable(what, "Export it again, for instance as WAV, FLAC or MP3.")

    def _decode(self) -> Path:
        """Return the decoded WAV file, from the cache if the recording has not changed."""
        status = self._path.stat()
        key = str(self._path), status.st_size, status.st_mtime_ns
        wav = _cache.get(key)
        if wav is None or not wav.is_file():
            while len(_cache) >= _MAX_CACHED:
                _cache.pop(next(iter(_cache))).unlink(missing_ok=True)
            wav = _cache[key] = self._write()
        return wav

    def _write(self) -> Path:
        """Decode to a new temporary WAV file; raises :class:`AudioUnreadable` for empty and truncated recordings."""
        with tempfile.NamedTemporaryFile(dir=compat.temporary_folder(), prefix="s2ag-", suffix=".wav", delete=False) as file:
            try:
                count, declared = self._read(cast(BinaryIO, file))
                seconds = count / RATE
                if not count:
                    raise AudioUnreadable(f"{self._path} holds no sound at all (zero length).", "Choose another recording.")
                if self._path.suffix.lower() in _DECLARES_LENGTH and declared - seconds > max(0.25, 0.02 * declared):
                    raise AudioUnreadable(
                        f"{self._path} is cut off: it ends after {seconds:.1f} s where its header promises {declared:.1f} s.",
                        "Copy or export it again.",
                    )
            except BaseException:
                file.close()
                Path(file.name).unlink(missing_ok=True)
                raise
        return Path(file.name)

    def _read(self, file: BinaryIO) -> tuple[int, float]:
        """Write what ``aud`` decodes; return the number of samples and the seconds that the file declares."""
        import aud

        sound: Any = aud.Sound(str(self._path))  # pyright: ignore[reportCallIssue]
        rate, declared = int(sound.specs[0]), sound.length / sound.specs[0]
        return write_wave(file, resample(join_pieces(self._pieces(sound, declared), rate), rate, RATE)), declared

    def _pieces(self, sound: Any, declared: float) -> Iterator[np.ndarray]:
        """Yield mono pieces ``(n,)`` float32, each beginning :data:`OVERLAP` seconds before the end of the one before."""
        begin = 0.0
        while True:
            if self._cancelled.is_set():
                raise Cancelled("Cancelled.")
            data = sound.limit(max(begin - OVERLAP, 0.0), begin + PIECE).data()
            if not len(data):
                return
            yield np.nan_to_num(data.mean(axis=1, dtype=np.float32), nan=0.0, posinf=0.0, neginf=0.0)
            begin += PIECE
            self.value = min(begin / declared, 1.0) if declared > 0 else 0.0
            time.sleep(_PAUSE)


def join_pieces(pieces: Iterable[np.ndarray], rate: int) -> Iterator[np.ndarray]:
    """Yield the sound ``(n,)`` piece by piece of overlapping ``pieces`` at ``rate`` Hz."""
    overlap, seam = int(OVERLAP * rate), int(SEAM * rate)
    before = None
    for piece in pieces:
        fresh = piece if before is None else piece[_seam(before[-overlap:], piece[: 2 * overlap], seam) :]
        if len(fresh):
            yield fresh
        before = fresh if before is None or len(fresh) >= overlap else np.concatenate([before[-overlap:], fresh])


def write_wave(file: BinaryIO, pieces: Iterable[np.ndarray]) -> int:
    """Write mono pieces ``(n,)`` as a WAV of 32-bit floats at :data:`RATE`; return the number of samples."""
    header = struct.Struct("<4sI4s4sIHHIIHH4sI")
    file.write(bytes(header.size))
    count = 0
    for piece in pieces:
        file.write(piece.astype("<f4").tobytes())
        count += len(piece)
    size = 4 * count
    file.seek(0)
    form = b"fmt ", 16, 3, 1, RATE, 4 * RATE, 4, 32
    file.write(header.pack(b"RIFF", min(36 + size, 2**32 - 1), b"WAVE", *form, b"data", min(size, 2**32 - 1)))
    return count


def _seam(before: np.ndarray, piece: np.ndarray, seam: int) -> int:
    """Return the index in ``piece`` where it continues ``before``: where the sound correlates best, else where it should."""
    expected = min(len(before), len(piece))
    end = before[-seam:]
    if len(end) < seam or len(piece) <= seam:
        return expected
    size = 1 << (len(piece) + seam).bit_length()
    product = np.fft.irfft(np.fft.rfft(piece, size) * np.conj(np.fft.rfft(end, size)), size)[: len(piece) - seam + 1]
    power = np.cumsum(np.concatenate([[0.0], piece.astype(float) ** 2]))
    loudness = np.sqrt(np.maximum(power[seam:] - power[:-seam], 1e-12) * max(float(end.astype(float) @ end), 1e-12))
    correlation = product / loudness
    best = int(np.argmax(correlation))
    return best + seam if correlation[best] >= _MIN_SEAM_CORRELATION else expected
