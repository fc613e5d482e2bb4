"""What a warm engine remembers, so that another style or intensity is not heard or generated anew."""

from pathlib import Path


class Memory:
    """The last recording as it was heard, and the last performance of it."""

    def __init__(self):
        self._heard = self._made = (None, None)

    def heard(self, recording: tuple):
        """What was heard of this recording (:func:`signature`), if it was the last one."""
        return self._heard[1] if self._heard[0] == recording else None

    def made(self, performers: tuple):
        """What these performers made, if they were the last ones."""
        return self._made[1] if self._made[0] == performers else None

    def keep_heard(self, recording: tuple, heard) -> None:
        """Remember a recording instead of the former one."""
        self._heard = (recording, heard)

    def keep(self, recording: tuple, heard, performers: tuple, made) -> None:
        """Remember a recording and a performance instead of the former ones."""
        self._heard, self._made = (recording, heard), (performers, made)


def signature(request) -> tuple:
    """What the recording and the words of a :class:`request.Request` are known by, without reading them.

    Names, sizes and times of writing.
    """
    files = [Path(name) for name in (request.audio, request.transcript, request.hears) if name is not None]
    states = [(str(file), state.st_size, state.st_mtime_ns) for file in files if file.is_file() and (state := file.stat())]
    return (
        *states,
        len(files),
        request.text,
        request.recognise,
        request.face > 0,
        request.listen,
        request.turn,
        str(request.hears),
        request.later,
    )
