"""Errors a user can act on: one sentence that says what is wrong, one that says what to do."""

_LONGEST_WORD, _LONGEST = 400, 1200
"""Letters of what a message quotes without a space, and of a whole message; paths are shorter."""


def readable(text: str) -> str:
    """``text`` as a terminal may show it, whatever it quotes: of bounded length, without control characters."""
    words = [_cut(word, _LONGEST_WORD) for word in _cut(str(text), 4 * _LONGEST).split(" ")]
    shown = _cut(" ".join(words), _LONGEST)
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in shown)


def _cut(text: str, longest: int) -> str:
    """The beginning and the end of what is longer."""
    return text if len(text) <= longest else f"{text[: longest * 3 // 4]}…{text[-(longest // 4) :]}"


class S2agError(Exception):
    """An expected failure with a remedy.

    ``kind`` is the stable name that crosses the worker protocol, ``message`` says what is wrong and ``remedy`` what
    to do about it; both are single sentences for people.
    """

    def __init__(self, message: str, remedy: str = "", kind: str = ""):
        message = readable(message)
        super().__init__(message)
        self.message = message
        self.remedy = readable(remedy)
        self.kind = kind or type(self).__name__

    def __str__(self) -> str:
        return f"{self.message} {self.remedy}".strip()


class AudioUnreadable(S2agError):
    """The recording is missing, empty, silent by construction or in no known format."""


class TranscriptUnreadable(S2agError):
    """The transcript file cannot be read or parsed."""


class UnknownStyle(S2agError):
    """A style expression names a speaker the checkpoint does not know."""


class CheckpointUnreadable(S2agError):
    """A checkpoint is missing, damaged or of another version."""


class VectorsUnreadable(S2agError):
    """A word-vector file cannot be read."""


class CorpusUnreadable(S2agError):
    """A packed training corpus cannot be read."""


class MotionUnreadable(S2agError):
    """A motion file cannot be read."""


class ManifestUnusable(S2agError):
    """The manifest of a batch cannot be read, or what it asks for cannot be done."""


class SampleUnreadable(S2agError):
    """A sheet of samples cannot be read, or has no such cell."""


class OutputUnwritable(S2agError):
    """The output folder is missing, read-only or full."""


class RigUnusable(S2agError):
    """The character or armature lacks what gestures need."""


class BlenderUnavailable(S2agError):
    """No Blender that could build, key or render the character."""


class WorkerFailed(S2agError):
    """The worker died, hung or answered with something other than the protocol."""


_FULL = ("torch", "safetensors", "pocketsphinx")
"""Packages of the extra ``full``; those of ``engine`` are smaller."""


class EngineMissing(S2agError):
    """A package that the engine needs is not installed."""

    @classmethod
    def of(cls, error: ModuleNotFoundError) -> "EngineMissing":
        """The same news for people."""
        extra = "full" if error.name in _FULL else "engine"
        return cls(f"The Python package {error.name} is not installed.", f'Install it with: pip install "s2ag[{extra}]"')


class Cancelled(S2agError):
    """The user cancelled."""


class UsageError(S2agError):
    """An option or a combination of options makes no sense."""
