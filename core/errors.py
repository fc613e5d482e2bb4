"""Errors that a user can act on: one sentence says what is wrong, one what to do."""

_MAX_WORD, _MAX_MESSAGE = 400, 1200
"""Characters of a word and of a whole message; paths are shorter."""


def sanitize(text: str) -> str:
    """Make ``text`` safe for a terminal: limit its length and escape control characters."""
    words = [_shorten(word, _MAX_WORD) for word in _shorten(str(text), 4 * _MAX_MESSAGE).split(" ")]
    shown = _shorten(" ".join(words), _MAX_MESSAGE)
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in shown)


def _shorten(text: str, longest: int) -> str:
    """Keep only the beginning and the end of longer texts."""
    return text if len(text) <= longest else f"{text[: longest * 3 // 4]}…{text[-(longest // 4) :]}"


class S2agError(Exception):
    """An expected failure with a remedy.

    ``kind`` is the stable name in the worker protocol, ``message`` says what is wrong and ``remedy`` what to do about it;
    both are single sentences for users."""

    def __init__(self, message: str, remedy: str = "", kind: str = ""):
        message = sanitize(message)
        super().__init__(message)
        self.message = message
        self.remedy = sanitize(remedy)
        self.kind = kind or type(self).__name__

    def __str__(self) -> str:
        return f"{self.message} {self.remedy}".strip()


class AudioUnreadable(S2agError):
    """The recording is missing, empty, without samples or in no known format."""


class TranscriptUnreadable(S2agError):
    """The transcript file cannot be read or parsed."""


class UnknownStyle(S2agError):
    """A style expression is invalid or names a speaker that the checkpoint lacks."""


class CheckpointUnreadable(S2agError):
    """A checkpoint is missing, damaged or of an unsupported version."""


class VectorsUnreadable(S2agError):
    """A word-vector file cannot be read."""


class CorpusUnreadable(S2agError):
    """A packed training corpus cannot be read."""


class MotionUnreadable(S2agError):
    """A motion file cannot be read."""


class OutputUnwritable(S2agError):
    """The output folder is missing, read-only or full."""


class RigUnusable(S2agError):
    """The character or armature lacks bones that gestures need."""


class BlenderUnavailable(S2agError):
    """There is no Blender to build, animate or render the character."""


class WorkerFailed(S2agError):
    """The worker died, hung or violated the protocol."""


_FULL = ("torch", "safetensors", "pocketsphinx")
"""Packages that only the extra ``full`` installs, not ``engine``."""


class EngineMissing(S2agError):
    """A package that the engine needs is not installed."""

    @classmethod
    def of(cls, error: ModuleNotFoundError) -> "EngineMissing":
        """Convert an import error into one that tells users what to install."""
        extra = "full" if error.name in _FULL else "engine"
        return cls(f"The Python package {error.name} is not installed.", f'Install it with: pip install "s2ag[{extra}]"')


class Cancelled(S2agError):
    """The user cancelled."""


class UsageError(S2agError):
    """An option or a combination of options is invalid."""
