"""Recognises speech with Whisper (faster-whisper), as a separate program that :mod:`recognise` starts.

Standard input is one line of JSON ``{"samples": n, "model": folder, "language": code or null, "words": bool}`` and then n
little-endian int16 samples at 16 kHz. Standard output is JSON lines: ``{"progress": 0..1}`` and last
``{"segments": [[text, start, end], ...]}`` in seconds, with ``words`` one for every word. The sound is recognised in chunks of
about five minutes that end in silence, so memory does not grow with the recording.
"""

import json
import os
import sys

import numpy as np

RATE = 16000
_CHUNK = 300 * RATE
_SEARCH_RANGE = 20 * RATE
_HOP = RATE // 10
_OPTIONS = {"beam_size": 1, "condition_on_previous_text": False}


def main() -> None:
    """Serve one request by the protocol at the top of this file."""
    os.environ["HF_HUB_OFFLINE"] = "1"
    from faster_whisper import WhisperModel

    request = json.loads(sys.stdin.buffer.readline())
    model = WhisperModel(request["model"], device="cpu", compute_type="int8", local_files_only=True)
    segments, begin, total = [], 0, request["samples"]
    rest = np.zeros(0, np.float32)
    while begin < total:
        count = min(_CHUNK, total - begin) - len(rest)
        data = sys.stdin.buffer.read(2 * max(count, 0))
        sound = np.concatenate([rest, np.frombuffer(data, "<i2").astype(np.float32) / 32768])
        size = len(sound) if begin + len(sound) >= total or not len(data) else _quietest(sound)
        parts, _ = model.transcribe(sound[:size], language=request["language"], word_timestamps=request["words"], **_OPTIONS)
        for part in parts:
            pieces = [(word.word, word.start, word.end) for word in part.words or ()]
            for text, start, end in pieces or [(part.text, part.start, part.end)]:
                segments.append([text.strip(), begin / RATE + start, begin / RATE + max(start, min(end, size / RATE))])
            print(json.dumps({"progress": min((begin + part.end * RATE) / total, 1.0)}), flush=True)
        rest, begin = sound[size:], begin + size
        if not size:
            break
    print(json.dumps({"segments": segments}), flush=True)


def _quietest(sound: np.ndarray) -> int:
    """Return the sample number of the quietest point in the last :data:`_SEARCH_RANGE` samples."""
    tail = sound[-_SEARCH_RANGE:]
    power = (tail[: len(tail) // _HOP * _HOP].reshape(-1, _HOP) ** 2).sum(1)
    return len(sound) - len(tail) + int(np.argmin(np.convolve(power, np.ones(3), mode="same"))) * _HOP + _HOP // 2


if __name__ == "__main__":
    main()
