"""Every door by which files of others come in: good files to damage, and what reads them as the product does."""

import io
import json
import os
import pickle
import random
import shutil
import tempfile
import wave
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import moving
import mutations
import numpy as np
import transcripts

ROOT = Path(__file__).resolve().parents[2]
HELLO = ROOT / "examples" / "hello.flac"
Seeds = list[tuple[str, bytes]]


@dataclass(frozen=True)
class Door:
    """``make()`` gives good files by suffix, ``use(path)`` reads one or raises S2agError, ``damage`` suits its form."""

    name: str
    make: Callable[[], Seeds]
    use: Callable[[Path], object]
    damage: Callable = mutations.of_bytes

    def seeds(self) -> Seeds:
        """The good files, made once."""
        return _made(self)

    def valid(self, folder: Path) -> Path:
        """A good file in ``folder``."""
        suffix, data = self.seeds()[0]
        path = folder / f"good{suffix}"
        path.write_bytes(data)
        return path


@cache
def _made(door: Door) -> Seeds:
    return door.make()


def written(*writers) -> Seeds:
    """What functions of a path write, each with the suffix it is named with."""
    with tempfile.TemporaryDirectory() as folder:
        found = []
        for number, (suffix, write) in enumerate(writers):
            path = Path(folder) / f"{number}{suffix}"
            write(path)
            found.append((suffix, path.read_bytes()))
    return found


# Recordings


def _noise(seconds: float = 0.3) -> np.ndarray:
    return (np.random.default_rng(0).normal(0, 3000, int(seconds * 16000))).astype(np.int16)


def _wave(path: Path, channels: int, width: int, rate: int = 16000) -> None:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(width)
        file.setframerate(rate)
        file.writeframes(_noise().astype("<i4").tobytes()[: 4800 * width // channels * channels])


def _waves() -> Seeds:
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


def _films() -> Seeds:
    kinds = ((".flac", "flac", "s16"), (".mp3", "libmp3lame", "s16p"), (".ogg", "libopus", "s16"), (".m4a", "aac", "fltp"))
    kinds += ((".mkv", "libopus", "s16"), (".webm", "libopus", "s16"), *((end, "pcm_s16be", "s16") for end in (".aiff", ".au")))
    return written(*((kind[0], lambda path, kind=kind: _encoded(path, *kind[1:])) for kind in kinds))


def _listen(path: Path) -> None:
    from s2ag.core.sound import audio

    samples = audio.load(path)
    assert samples.ndim == 1 and samples.dtype == np.float32 and np.isfinite(samples).all()


# Words


def _read_words(path: Path) -> None:
    """What was read makes sense, and so does all that follows before the sound is needed."""
    from s2ag.core.words import readers, transcript

    source = readers.parse(transcript.read(path), path)
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
    hints.understand(script.marks, words)


def _transcripts() -> Seeds:
    own = written(*((Path(name).suffix, write) for _, name, write, _, _ in transcripts.FORMS))
    return own + [(other, data) for _, data in own for other in (".json", ".txt")]


def _data_words() -> Seeds:
    return written((".json", moving.google), (".TextGrid", moving.textgrid)) + [(".json", b'[["hello", 0.2, 0.6]]')]


def _read_data_words(path: Path) -> None:
    from s2ag.core.learning.datasets import transcripts as reader

    for word, start, end in reader.read(path, np.zeros(16000, np.float32)):
        assert isinstance(word, str) and np.isfinite([start, end]).all()


def _letters(path: Path) -> None:
    from s2ag.core.words import language

    folder = path.parent / "model"
    folder.mkdir(exist_ok=True)
    shutil.copy(path, folder / "letters.json")
    language.fingerprint(language.load(str(folder), None))


def _vocabulary() -> Seeds:
    content = json.loads((ROOT / "core" / "assets" / "vocabulary.json").read_text("utf-8"))
    some = {name: dict(list(part.items())[:6]) for name, part in content.items() if isinstance(part, dict)}
    return [(".json", json.dumps(some).encode())]


def _read_vocabulary(path: Path) -> None:
    from s2ag.core.meaning import vocabulary

    vocabulary.load(path).find(["i", "do", "not", "know"], [False] * 4)


# What users and farms write


def _maps() -> Seeds:
    content = {"map": 1, "armature": "Hero", "family": "mixamo", "hips": ["Hips"], "torso": ["Spine", "Spine1"]}
    content |= {"left_upper_arm": ["LeftArm"], "switches": [{"bone": "Hand_IK.L", "path": '["ik_fk"]', "value": 1.0}]}
    return [(".json", json.dumps(content, indent=1).encode())]


def _read_map(path: Path) -> None:
    from s2ag.rigs import maps

    found = maps.load(path)
    maps.table(found)
    maps.parse(json.loads(maps.dump(found)))


def _manifests() -> Seeds:
    rows = [{"audio": str(HELLO), "name": f"clip {number}", "seed": number, "outputs": "bvh"} for number in range(3)]
    rows[0] |= {"style": "Emphatic", "takes": 2, "intensity": 1.2, "mirror": True, "text": "hello there"}
    rows[1] |= {"affect": "arousal=0.5", "hand": "left", "delay": 2, "scene": "a"}
    lines = "".join(json.dumps(row) + "\n" for row in rows)
    head = "audio,name,style,seed,takes,intensity,transcript,outputs,fps,scene,delay\n"
    cells = "".join(f"{HELLO},c{number},,{number},1,1.0,,bvh,30,,0\n" for number in range(3))
    return [(".jsonl", lines.encode()), (".csv", (head + cells).encode()), (".csv", (head + cells).replace(",", ";").encode())]


def _read_manifest(path: Path) -> None:
    from s2ag.core.batch import checks, clip, manifest

    clips, problems = manifest.read(path)
    problems += checks.check(clips)
    for problem in problems:
        assert problem.line > 0 and problem.sentence.strip()
    if not problems:
        clip.units(clips)


def _sheets() -> Seeds:
    from s2ag.core.model.catalogue import describe

    cell = {"row": 0, "column": 0, "style": "a", "seed": 1, "take": 0, "latent": [[0.1] * 16]}
    content = {"format": 1, "audio": str(HELLO), "checkpoint": describe()["hash"]}
    content["cells"] = [cell | {"column": number} for number in range(3)]
    return [(".json", json.dumps(content | {"text": "hello", "intensity": 1.0, "mirror": False}).encode())]


def _read_sheet(path: Path) -> None:
    from s2ag.core.performance import sampling

    assert sampling.Sheet.load(path).columns > 0
    sampling.again(f"{path}:1")


def _study() -> tuple[dict, dict]:
    from s2ag.core.study.build import QUESTIONS

    clips = {f"{number}": {"condition": "ab"[number % 2], "excerpt": "xy"[number // 2]} for number in range(4)}
    key = {"id": "study", "conditions": ["a", "b"], "excerpts": ["x", "y"], "clips": clips}
    answers = [{"clip": name, **{question["id"]: 3 for question in QUESTIONS}} for name in clips]
    return key, {"study": "study", "participant": 1, "answers": answers}


def _study_files() -> Seeds:
    return [(suffix, json.dumps(one).encode()) for suffix, one in zip((".key", ".json"), _study(), strict=True)]


def _read_study(path: Path) -> None:
    from s2ag.core.study import analysis

    key, answers = _study()
    mine, other = path.with_name("given.json"), path.with_name("good.json")
    shutil.copy(path, mine)
    is_key = path.suffix == ".key"
    other.write_text(json.dumps(answers if is_key else key))
    found = analysis.read([other if is_key else mine], mine if is_key else other)
    if len(found.conditions) < 50:
        analysis.report(analysis.analyse(found, found.conditions[0]), found.conditions[0])


def _records() -> Seeds:
    facts = {"motions": ["d"], "recording": "r", "duration": 1.0, "warnings": []}
    fact = {"key": "k", "files": {"npz/a.npz": 5}, "facts": facts, "seal": "s"}
    failure = {"key": "k", "kind": "AudioUnreadable", "message": "It is broken.", "remedy": "Mend it."}
    return [(".json", json.dumps(fact).encode()), (".failed", json.dumps(failure).encode())]


def _sealed(data: bytes, key: str) -> bytes:
    """A record of the key that is wanted, with the seal that its content asks for if it still holds one."""
    from s2ag.core.batch import folder

    data = data.replace(b'"key": "k"', b'"key": "%s"' % key.encode())
    files, facts = {"npz/a.npz": 5}, {"motions": ["d"], "recording": "r", "duration": 1.0, "warnings": []}
    return data.replace(b'"seal": "s"', b'"seal": "%s"' % folder.key(key, files, facts).encode())


def _read_record(path: Path) -> None:
    """A batch of one clip whose record or failure is the damaged file, which is of the very key that is wanted."""
    from s2ag.core.batch import manifest, stages, summary
    from s2ag.core.batch.folder import Folder

    table = path.with_name("talks.jsonl")
    table.write_text(json.dumps({"audio": str(HELLO), "name": "a", "no_transcript": True}) + "\n")
    batch = stages.Batch(Folder(path.parent / "batch"), manifest.read(table)[0])
    (step,) = batch.steps("synth", batch.units)
    place = step.record.failure_path if path.suffix == ".failed" else step.record.path
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(_sealed(path.read_bytes(), step.key))
    result = batch.folder.result("npz", "a", ".npz")
    result.parent.mkdir(parents=True, exist_ok=True)
    result.write_bytes(b"12345")
    try:
        summary.take_stock(batch, batch.units)
        batch.steps("encode", batch.units)
        summary.write(batch, {})
    finally:
        shutil.rmtree(batch.folder.root)


def _read_cache(path: Path) -> None:
    from s2ag.core.words.cache import Cache

    cache = Cache(path.parent / "cache")
    cache.put("ab", [["a", 0.0, 1.0]])
    (kept,) = (one for one in cache.folder.rglob("*") if one.is_file())
    shutil.copy(path, kept)
    cache.get("ab")
    cache.clear()


def _protocol() -> Seeds:
    good = {"audio": "none.wav", "transcript": "a.txt", "text": "hi", "style": {"calm": 1.0}, "seed": 3, "takes": 2}
    good |= {"pose": [[0, 1, 0]] * 9, "affect": {"arousal": 0.5}, "kept": [[3, [[0, 1, 0]] * 9]], "near": [[0.1] * 16]}
    good |= {"hand": 0.5, "mirror": True}
    requests = [{"id": 1, "method": "synthesize", "params": good}, {"id": "a", "method": "styles", "params": {}}]
    requests += [{"id": 2, "method": "hello", "params": {"checkpoint": "x"}}, {"method": "cancel", "id": 1}]
    return [(".line", json.dumps(one).encode()) for one in requests]


def _serve_line(path: Path) -> None:
    from s2ag.core.engine import protocol
    from s2ag.core.engine.worker import Worker

    replies, end = os.pipe()
    worker = Worker(0, end, alone=False)
    try:
        for line in path.read_bytes().split(b"\n")[:5]:
            worker._accept(line)
        while not worker._waiting.empty():
            worker._serve(worker._waiting.get())
    finally:
        os.close(end)
        with os.fdopen(replies, "rb") as told:
            answers = [protocol.decode(line) for line in told]
        worker._folder.cleanup()
    for answer in answers:
        error = answer.get("error")
        assert error is None or (error["kind"] != "Internal" and error["message"] and error["remedy"]), error


# Motions, tables, pickles


def _motions() -> Seeds:
    from s2ag.core.motion.motion import Motion
    from s2ag.core.motion.skeleton import MEAN_UNIT

    motion = Motion(np.tile(MEAN_UNIT, (40, 1, 1)).astype(np.float32), 15.0, (("hello", 0.1, 0.5),), {"seed": 1})
    return written((".npz", motion.save))


def _read_motion(path: Path) -> None:
    from s2ag.core.motion import as_json, bvh
    from s2ag.core.motion.motion import Motion

    motion = Motion.load(path)
    as_json.save(motion, path.with_name("out.json"))
    bvh.save(motion, path.with_name("out.bvh"))


def _performances() -> Seeds:
    def turned(path):
        moving.bvh(path, frames=8, z_up=True)

    smplx = written((".npz", lambda path: moving.smplx(path)))
    return written((".bvh", lambda path: moving.bvh(path, frames=8)), (".bvh", turned)) + smplx + _motions()


def _read_performance(path: Path) -> None:
    from s2ag.core.learning.datasets.readers import Found, recordings

    (one,) = recordings([Found("a", path, HELLO, None, "me", "train")])
    assert one.directions.shape[1:] == (9, 3) and np.isfinite(one.directions).all()


def _damage_performance(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    return (mutations.of_arrays if data[:2] == b"PK" else mutations.of_text)(data, chance, others)


def _tables() -> Seeds:
    with np.load(ROOT / "core" / "assets" / "words.npz") as held:
        arrays = {name: held[name] for name in held.files}
    small = {"words": np.frombuffer("\n".join(arrays["words"].tobytes().decode().split("\n")[:40]).encode(), np.uint8)}
    for name, array in arrays.items():
        if name != "words":
            rows = name.endswith(("codes", "norms"))
            small[name] = array[:40] % 4 if name.endswith("codes") else array[:40] if rows else array
            if name.endswith("centroids"):
                small[name] = array[:, :4]
    made = io.BytesIO()
    np.savez_compressed(made, **small)
    numbers = " ".join(f"{number / 300:.3f}" for number in range(300))
    return [(".npz", made.getvalue()), (".vec", f"3 300\nthe {numbers}\nof {numbers}\nand {numbers}\n".encode())]


def _read_table(path: Path) -> None:
    from s2ag.core.vectors.table import WordVectors

    table = WordVectors.load(path)
    assert table.vectors(["the", "unheard-of", "25", "–"]).shape == (4, 300)


def _damage_table(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    return (mutations.of_arrays if data[:2] == b"PK" else mutations.of_text)(data, chance, others)


def _pickles() -> Seeds:
    content = {"word2index": {"a": 0, "b": 1}, "array": np.arange(12.0).reshape(3, 4), "number": np.float32(2), "set": {1, 2}}
    content |= {"ordered": OrderedDict(a=1), "bytes": b"12", "list": [[1, (2, "three", None, True)]], "path": complex(1, 2)}
    return [(".pkl", pickle.dumps(content, protocol)) for protocol in range(6)]


def _read_pickle(path: Path) -> None:
    from s2ag.core.model import pickles

    pickles.read(path)


DOORS = {
    door.name: door
    for door in (
        Door("wave", _waves, _listen),
        Door("film", _films, _listen),
        Door("transcript", _transcripts, _read_words, mutations.of_json),
        Door("data-transcript", _data_words, _read_data_words, mutations.of_json),
        Door("letters", lambda: [(".json", b'{"sch": "SH", "a": "AA", "ch": "K"}')], _letters, mutations.of_json),
        Door("vocabulary", _vocabulary, _read_vocabulary, mutations.of_json),
        Door("map", _maps, _read_map, mutations.of_json),
        Door("manifest", _manifests, _read_manifest, mutations.of_lines),
        Door("sheet", _sheets, _read_sheet, mutations.of_json),
        Door("study", _study_files, _read_study, mutations.of_json),
        Door("record", _records, _read_record, mutations.of_json),
        Door("cache", lambda: [(".json", b'[["a", 0.0, 1.0]]')], _read_cache, mutations.of_json),
        Door("protocol", _protocol, _serve_line, mutations.of_json),
        Door("motion", _motions, _read_motion, mutations.of_arrays),
        Door("performance", _performances, _read_performance, _damage_performance),
        Door("vectors", _tables, _read_table, _damage_table),
        Door("pickle", _pickles, _read_pickle),
    )
}  # fmt: skip
