"""Recordings and words: good files, and what reads them."""

import json
import wave
from pathlib import Path

import folders
import moving
import numpy as np
import transcripts
from door import ROOT, Seeds, put, written

MEAN_POSE = np.tile([0.0, 1.0, 0.0], (9, 1)).astype(np.float32)


def _noise(seconds: float = 0.3) -> np.ndarray:
    return (np.random.default_rng(0).normal(0, 3000, int(seconds * 16000))).astype(np.int16)


def _wave(path: Path, channels: int, width: int, rate: int = 16000) -> None:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(width)
        file.setframerate(rate)
        file.writeframes(_noise().astype("<i4").tobytes()[: 4800 * width // channels * channels])


def waves() -> Seeds:
    kinds = ((1, 2, 16000), (2, 2, 44100), (8, 2, 48000), (1, 3, 22050), (1, 1, 8000), (2, 4, 96000))
    return written(*((".wav", lambda path, kind=kind: _wave(path, *kind)) for kind in kinds))


def _encoded(path: Path, codec: str, form: str) -> None:
    import av

    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=48000)
        stream.format = form
        frame = av.AudioFrame.from_ndarray(_noise(0.5)[None], format="s16", layout="mono")
        frame.sample_rate = 48000
        for piece in [*av.AudioResampler(form, "mono", 48000).resample(frame), None]:
            container.mux(stream.encode(piece))


def films() -> Seeds:
    kinds = ((".flac", "flac", "s16"), (".mp3", "libmp3lame", "s16p"), (".ogg", "libopus", "s16"), (".m4a", "aac", "fltp"))
    kinds += ((".mkv", "libopus", "s16"), (".webm", "libopus", "s16"), *((end, "pcm_s16be", "s16") for end in (".aiff", ".au")))
    return written(*((kind[0], lambda path, kind=kind: _encoded(path, *kind[1:])) for kind in kinds))


def listen(path: Path) -> None:
    from s2ag.core.sound import audio

    samples = audio.load(path)
    assert samples.ndim == 1 and samples.dtype == np.float32 and np.isfinite(samples).all()


def read_words(path: Path) -> None:
    """What was read makes sense, and so does all that follows before the sound is needed."""
    from s2ag.core.words import readers, transcript

    source = readers.parse(transcript.read_text(path), path)
    for item in source.items:
        assert item.text.strip() or source.form == "plain text"
        assert item.start is None or 0 <= item.start <= item.end < 2e9
        assert not item.word or item.start is not None
    for model in (None, {"acoustic": None, "dictionary": None, "letters": {}, "voice": "de"}):
        _check_script(transcript._Script(source, 3.0, model))


def _check_script(script) -> None:
    from s2ag.core.words import hints

    assert len(script.fixed) + len(script.loose) == len(script.tokens)
    assert sum(len(part.words) for part in script.stretches) == len(script.loose)
    edges = [edge for part in script.stretches for edge in (part.start, part.end)]
    assert edges == sorted(edges)
    words = [(shown, 0.1 * number, 0.1 * number + 0.1) for number, (shown, _) in enumerate(script.tokens)]
    hints.parse_hints(script.marks, words)


def scripts() -> Seeds:
    own = written(*((Path(name).suffix, write) for _, name, write, _, _ in transcripts.FORMS))
    return own + [(other, data) for _, data in own for other in (".json", ".txt")]


def data_words() -> Seeds:
    return written((".json", moving.google), (".TextGrid", moving.textgrid)) + [(".json", b'[["hello", 0.2, 0.6]]')]


def read_data_words(path: Path) -> None:
    from s2ag.core.learning.datasets import transcripts as reader

    for word, start, end in reader.read(path, np.zeros(16000, np.float32)):
        assert isinstance(word, str) and np.isfinite([start, end]).all()


def letters(path: Path) -> None:
    from s2ag.core.words import language

    folder = path.parent / "model"
    folder.mkdir(exist_ok=True)
    put(path, folder / "letters.json")
    language.fingerprint(language.load_language(str(folder), None))


def vocabularies() -> Seeds:
    content = json.loads((ROOT / "core" / "assets" / "vocabulary.json").read_text("utf-8"))
    some = {name: dict(list(part.items())[:6]) for name, part in content.items() if isinstance(part, dict)}
    return [(".json", json.dumps(some).encode())]


def read_vocabulary(path: Path) -> None:
    from s2ag.core.meaning import vocabulary

    vocabulary.load_vocabulary(path).find(["i", "do", "not", "know"], [False] * 4)


def clips() -> Seeds:
    """A vocabulary with a clip, and the clip."""
    return folders.files(_acted)


def _acted(folder: Path) -> None:
    from s2ag.core.motion.motion import Motion
    from s2ag.core.motion.skeleton import MEAN_UNIT

    Motion(np.tile(MEAN_UNIT, (30, 1, 1)).astype(np.float32), 15.0).save(folder / "clip.npz")
    gesture = {"says": ["hello*"], "marks": ["wave"], "clip": "clip.npz", "lands": 0.5, "often": 1.0}
    (folder / "words.json").write_text(json.dumps({"gestures": {"wave": gesture}}))


def read_clip(path: Path) -> None:
    """The clip played over a body."""
    from s2ag.core.meaning import vocabulary

    for gesture in vocabulary.load_vocabulary(folders.beside(_acted, path) / "words.json").gestures.values():
        if gesture.acted is not None:
            body = np.tile(MEAN_POSE, (20, 1, 1))
            gesture.acted.blend_into(body, np.arange(20) / 15 - 0.5, np.ones(20), (True, True))
            gesture.acted.hands(np.arange(20) / 15, (True, False))
            assert np.isfinite(body).all()


def dialogues() -> Seeds:
    text = "ANNA: That is what I mean, *really*.\nBERT: {big} Oh! [pause] It is 20 %.\nANNA: Yes.\nTHE END: so"
    return [(".txt", text.encode()), (".txt", text.replace("ANNA", "Anna").replace("\n", "\r\n").encode("utf-16"))]


def read_turns(path: Path) -> None:
    """What Anna says of a text whose words follow each other."""
    from s2ag.core.words import markup, speaker_turns, transcript

    text = transcript.read_text(path)
    marked = markup.parse(text)
    words = tuple((shown, 0.1 * number, 0.1 * number + 0.1) for number, (shown, _) in enumerate(marked.tokens))
    heard = transcript.TimedTranscript(words, (1.0,) * len(words), tuple(marked.marks))
    mine, spans = speaker_turns.words_of_speaker(heard, None, text, "anna")
    assert len(mine.words) == len(mine.confidence)
    assert (spans[:, 0] <= spans[:, 1]).all() and (spans[1:, 0] >= spans[:-1, 1]).all()
    assert all(0 <= mark.first <= mark.last <= len(mine.words) for mark in mine.marks)
