"""Recordings decoded by Blender's sound system, for an engine that reads nothing but WAV.

Blender's ``aud`` holds Python while it decodes, so it is asked for seconds at a time, in a thread. After each seek some formats
continue a little beside the place that was asked for; pieces therefore overlap and are joined where they are the same.
Where there is no ``aud``, Blender's mixer does it (:mod:`mixing`).
"""

import importlib.util
import struct
import tempfile
import threading
import time
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import AudioUnreadable, Cancelled, OutputUnwritable, S2agError
from ...core.sound import wavefile
from ...core.sound.resample import resampled
from . import mixing

RATE = 16000
PIECE, OVERLAP, SEAM = 6.0, 1.0, 0.25
"""Seconds that are asked for at a time, that pieces share, and that are compared to join them."""
_SAME = 0.7
"""Correlation from which on two seams are the same sound."""
_BREATH = 0.001
"""Seconds between pieces in which Blender's own thread may go on."""
_DECLARES_LENGTH = {".flac", ".aif", ".aiff", ".m4a", ".mp4", ".mov", ".3gp"}
"""Files whose header states the length; elsewhere it is guessed from the bit rate, which proves nothing."""
_KEPT = 4

_kept: dict[tuple, Path] = {}


def needed(path: str) -> bool:
    """Whether a recording is of a kind that Blender has to decode.

    Raises :class:`AudioUnreadable` where it is, and neither this Blender nor its Python can.
    """
    try:
        head = wavefile.header(Path(path))
    except OSError:
        return False  # the engine says what is wrong with it
    if head is not None and head.kind is not None:
        return False
    if _has_aud() or mixing.command():
        return True
    if importlib.util.find_spec("av") is not None:
        return False  # the engine decodes by itself
    what = "This build of Blender has no sound system, so WAV files are the only recordings that it can read."
    raise AudioUnreadable(what, "Save the recording as WAV, or use the Blender of blender.org.")


def _has_aud() -> bool:
    """Whether Python reaches the sound system; some distributions build Blender without, and so are some of its modules."""
    try:
        import aud  # noqa: F401
    except ImportError:
        return False
    return True


class Decoding:
    """A recording on its way to a WAV file of 16 kHz; ``value`` is how far it is, 0..1."""

    stage = "decode audio"

    def __init__(self, path: str):
        self.value = 0.0
        self.result: str | None = None
        self.error: S2agError | None = None
        self._path = Path(path)
        self._mixer = [] if _has_aud() else mixing.command()
        self._cancelled = threading.Event()
        self._thread = threading.Thread(target=self._work, name="s2ag decode", daemon=True)
        self._thread.start()

    def poll(self) -> bool:
        """Whether it ended, with ``result`` or ``error``."""
        return not self._thread.is_alive()

    def cancel(self) -> None:
        """Give up after the piece it is at."""
        self._cancelled.set()

    def outcome(self) -> str:
        """The file once it ended; raises the :class:`S2agError` that it ended with."""
        self._thread.join()
        if self.error is not None:
            raise self.error
        return self.result

    def _work(self) -> None:
        try:
            self.result = str(self._decoded())
        except S2agError as error:
            self.error = error
        except OSError as error:
            what = f"The decoded recording cannot be kept: {error.strerror or error}."
            self.error = OutputUnwritable(what, "Free some space in Blender's temporary folder.")
        except Exception as error:  # aud has an exception of its own
            what = f"{self._path} is not a readable recording ({str(error).rstrip('.')})."
            self.error = AudioUnreadable(what, "Export it again, for instance as WAV, FLAC or MP3.")

    def _decoded(self) -> Path:
        status = self._path.stat()
        key = str(self._path), status.st_size, status.st_mtime_ns
        found = _kept.get(key)
        if found is None or not found.is_file():
            while len(_kept) >= _KEPT:
                _kept.pop(next(iter(_kept))).unlink(missing_ok=True)
            found = _kept[key] = self._write()
        return found

    def _write(self) -> Path:
        with tempfile.NamedTemporaryFile(dir=bpy.app.tempdir, prefix="s2ag-", suffix=".wav", delete=False) as file:
            try:
                if self._mixer:
                    count, declared = self._mix(file), 0.0
                else:
                    count, declared = self._read(file)
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

    def _read(self, file) -> tuple[int, float]:
        """Samples written of what ``aud`` decodes, and the seconds that the file declares."""
        import aud

        sound = aud.Sound(str(self._path))
        rate, declared = int(sound.specs[0]), sound.length / sound.specs[0]
        return write_wave(file, resampled(joined(self._pieces(sound, declared), rate), rate, RATE)), declared

    def _mix(self, file) -> int:
        """Samples written of what Blender's mixer decodes."""
        with tempfile.TemporaryDirectory(dir=bpy.app.tempdir, prefix="s2ag-") as folder:
            whole = Path(folder, "mixed.wav")
            mixing.mixed(self._mixer, self._path.absolute(), whole, self._cancelled.is_set)
            head = wavefile.header(whole)
            pieces = (piece.mean(axis=0, dtype=np.float32) for piece in wavefile.samples(whole, head))
            return write_wave(file, resampled(pieces, head.rate, RATE))

    def _pieces(self, sound, declared: float):
        """Mono pieces ``(n,)`` float32, each beginning :data:`OVERLAP` seconds before the end of the one before."""
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
            time.sleep(_BREATH)


def joined(pieces, rate: int):
    """The sound ``(n,)`` by and by of overlapping ``pieces`` at ``rate`` Hz."""
    overlap, seam = int(OVERLAP * rate), int(SEAM * rate)
    before = None
    for piece in pieces:
        fresh = piece if before is None else piece[_continues(before[-overlap:], piece[: 2 * overlap], seam) :]
        if len(fresh):
            yield fresh
        before = fresh if before is None or len(fresh) >= overlap else np.concatenate([before[-overlap:], fresh])


def write_wave(file, pieces) -> int:
    """Write mono pieces ``(n,)`` as a WAV of 32-bit floats at :data:`RATE`; returns how many samples there were."""
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


def _continues(before: np.ndarray, piece: np.ndarray, seam: int) -> int:
    """Where ``piece`` goes on after the end of ``before``: at the seam that is most like its end, else where it should."""
    supposed = min(len(before), len(piece))
    end = before[-seam:]
    if len(end) < seam or len(piece) <= seam:
        return supposed
    size = 1 << (len(piece) + seam).bit_length()
    product = np.fft.irfft(np.fft.rfft(piece, size) * np.conj(np.fft.rfft(end, size)), size)[: len(piece) - seam + 1]
    power = np.cumsum(np.concatenate([[0.0], piece.astype(float) ** 2]))
    loudness = np.sqrt(np.maximum(power[seam:] - power[:-seam], 1e-12) * max(float(end.astype(float) @ end), 1e-12))
    likeness = product / loudness
    best = int(np.argmax(likeness))
    return best + seam if likeness[best] >= _SAME else supposed
