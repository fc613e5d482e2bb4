"""What users, farms and other programs write for s2ag: good files, and what reads them."""

import hashlib
import json
import os
import shutil
from pathlib import Path

from door import HELLO, Seeds, put


def maps() -> Seeds:
    content = {"map": 1, "armature": "Hero", "family": "mixamo", "hips": ["Hips"], "torso": ["Spine", "Spine1"]}
    content |= {"left_upper_arm": ["LeftArm"], "switches": [{"bone": "Hand_IK.L", "path": '["ik_fk"]', "value": 1.0}]}
    return [(".json", json.dumps(content, indent=1).encode())]


def read_map(path: Path) -> None:
    from s2ag.rigs import map_table, maps

    found = maps.load(path)
    map_table.table(found)
    maps.parse(json.loads(maps.dump(found)))


def manifests() -> Seeds:
    rows = [{"audio": str(HELLO), "name": f"clip {number}", "seed": number, "outputs": "bvh"} for number in range(3)]
    rows[0] |= {"style": "Emphatic", "takes": 2, "intensity": 1.2, "mirror": True, "text": "hello there"}
    rows[1] |= {"affect": "arousal=0.5", "hand": "left", "delay": 2, "scene": "a"}
    lines = "".join(json.dumps(row) + "\n" for row in rows)
    head = "audio,name,style,seed,takes,intensity,transcript,outputs,fps,scene,delay\n"
    cells = "".join(f"{HELLO},c{number},,{number},1,1.0,,bvh,30,,0\n" for number in range(3))
    return [(".jsonl", lines.encode()), (".csv", (head + cells).encode()), (".csv", (head + cells).replace(",", ";").encode())]


def read_manifest(path: Path) -> None:
    from s2ag.core.batch import checks, clip, manifest

    clips, problems = manifest.read(path)
    problems += checks.check(clips)
    for problem in problems:
        assert problem.line > 0 and problem.sentence.strip()
    if not problems:
        clip.units(clips)


def curves() -> Seeds:
    """What a performance is asked for over time."""
    some = {"format": 1, "curves": {"arousal": [[0, -0.5], [2.5, 1]]}, "styles": [[1.5, "stern"], [2, ""]]}
    return [(".json", json.dumps(some).encode())]


def read_curves(path: Path) -> None:
    from s2ag.core import control_curves

    assert control_curves.load(path).keys() == {"curves", "changes"}


def edits() -> Seeds:
    some = [{"do": "move", "at": 1.0, "to": 2.0}, {"do": "add", "word": "so", "kind": "big", "hand": "left", "size": 1.2}]
    some += [{"do": "reroll", "from": 1.0, "to": 2.0, "seed": 1}, {"do": "pose", "at": 1.0, "directions": [[0, 1, 0]] * 9}]
    return [(".json", json.dumps({"format": 1, "edits": some}).encode())]


def read_edits(path: Path) -> None:
    from s2ag.core.editing import edits

    assert edits.check(edits.load(path)) is not None


def sheets() -> Seeds:
    from s2ag.core.model.checkpoint_metadata import describe

    cell = {"row": 0, "column": 0, "style": "a", "seed": 1, "take": 0, "latent": [[0.1] * 16]}
    content = {"format": 1, "audio": str(HELLO), "checkpoint": describe()["hash"]}
    content["cells"] = [cell | {"column": number} for number in range(3)]
    return [(".json", json.dumps(content | {"text": "hello", "intensity": 1.0, "mirror": False}).encode())]


def read_sheet(path: Path) -> None:
    from s2ag.core.sampling import sheet

    assert sheet.Sheet.load(path).columns > 0
    sheet.request_of_cell(f"{path}:1")


def _study() -> tuple[dict, dict]:
    from s2ag.core.study.build import QUESTIONS

    clips = {f"{number}": {"condition": "ab"[number % 2], "excerpt": "xy"[number // 2]} for number in range(4)}
    key = {"id": "study", "conditions": ["a", "b"], "excerpts": ["x", "y"], "clips": clips}
    answers = [{"clip": name, **{question["id"]: 3 for question in QUESTIONS}} for name in clips]
    return key, {"study": "study", "participant": 1, "answers": answers}


def _pairs() -> tuple[dict, dict]:
    from s2ag.core.study.build import PAIRED

    key, answers = _study()
    left_right = [{"left": str(2 * row), "right": str(2 * row + 1), "realism": row, "appropriateness": -2} for row in range(2)]
    return key | {"form": "pairs", "questions": list(PAIRED["pairs"])}, answers | {"answers": left_right}


def study_files() -> Seeds:
    made = zip((".key", ".json", ".pairs-key", ".pairs-json"), (*_study(), *_pairs()), strict=True)
    return [(suffix, json.dumps(one).encode()) for suffix, one in made]


def read_study(path: Path) -> None:
    from s2ag.core.study import analysis, pairs

    paired = "pairs-" in path.suffix
    key, answers = _pairs() if paired else _study()
    mine, other = path.with_name("given.json"), path.with_name("good.json")
    put(path, mine)
    is_key = path.suffix.endswith("key")
    other.write_text(json.dumps(answers if is_key else key))
    given, known = [other if is_key else mine], mine if is_key else other
    if paired:
        votes = pairs.read(given, known)
        if len(votes.conditions) < 50:
            pairs.report(pairs.analyse(votes, votes.conditions[0]))
        return
    found = analysis.read(given, known)
    if len(found.conditions) < 50:
        analysis.report(analysis.analyse(found, found.conditions[0]), found.conditions[0])


RESULT = b"12345"
RESULT_HASH = hashlib.sha256(RESULT).hexdigest()


def records() -> Seeds:
    facts = {"motions": ["d"], "recording": "r", "duration": 1.0, "warnings": []}
    fact = {"key": "k", "files": {"npz/a.npz": RESULT_HASH}, "facts": facts, "seal": "s"}
    failure = {"key": "k", "kind": "AudioUnreadable", "message": "It is broken.", "remedy": "Mend it."}
    return [(".json", json.dumps(fact).encode()), (".failed", json.dumps(failure).encode())]


def _sealed(data: bytes, key: str) -> bytes:
    """A record of the key that is wanted, with the seal that its content asks for if it still holds one."""
    from s2ag.core.batch import folder

    data = data.replace(b'"key": "k"', b'"key": "%s"' % key.encode())
    files, facts = {"npz/a.npz": RESULT_HASH}, {"motions": ["d"], "recording": "r", "duration": 1.0, "warnings": []}
    return data.replace(b'"seal": "s"', b'"seal": "%s"' % folder.content_hash(key, files, facts).encode())


def read_record(path: Path) -> None:
    """A batch of one clip whose record or failure is the damaged file, which is of the very key that is wanted."""
    from s2ag.core.batch import manifest, stages, summary
    from s2ag.core.batch.folder import Folder

    table = path.with_name("talks.jsonl")
    table.write_text(json.dumps({"audio": str(HELLO), "name": "a", "no_transcript": True}) + "\n")
    batch = stages.Batch(Folder(path.parent / "batch"), manifest.read(table)[0])
    (step,) = batch.steps("synth", batch.units)
    place = step.record.failure_path if path.suffix == ".failed" else step.record.path
    place.parent.mkdir(parents=True, exist_ok=True)
    if path.is_file():
        path.write_bytes(_sealed(path.read_bytes(), step.key))
    put(path, place)
    result = batch.folder.result("npz", "a", ".npz")
    result.parent.mkdir(parents=True, exist_ok=True)
    result.write_bytes(RESULT)
    try:
        if path.is_file() and path.read_bytes() == _sealed(records()[0][1], step.key):
            assert step.record.read(step.key), "a good record is believed"
        summary.summarize(batch, batch.units)
        batch.steps("encode", batch.units)
        summary.write(batch, {})
    finally:
        shutil.rmtree(batch.folder.root)


def read_cache(path: Path) -> None:
    from s2ag.core.words.cache import Cache

    cache = Cache(path.parent / "cache")
    cache.put("ab", [["a", 0.0, 1.0]])
    (kept,) = (one for one in cache.folder.rglob("*") if one.is_file())
    put(path, kept)
    cache.get("ab")
    cache.clear()


def lines() -> Seeds:
    good = {"audio": "none.wav", "transcript": "a.txt", "text": "hi", "style": {"calm": 1.0}, "seed": 3, "takes": 2}
    good |= {"pose": [[0, 1, 0]] * 9, "affect": {"arousal": 0.5}, "kept": [[3, [[0, 1, 0]] * 9]], "near": [[0.1] * 16]}
    good |= {"hand": 0.5, "mirror": True}
    requests = [{"id": 1, "method": "synthesize", "params": good}, {"id": "a", "method": "styles", "params": {}}]
    requests += [{"id": 2, "method": "hello", "params": {"checkpoint": "x"}}, {"method": "cancel", "id": 1}]
    return [(".line", json.dumps(one).encode()) for one in requests]


def serve_line(path: Path) -> None:
    from s2ag.core.worker import protocol
    from s2ag.core.worker.server import Worker

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
        worker._folders.close()
    for answer in answers:
        error = answer.get("error")
        assert error is None or (error["kind"] != "Internal" and error["message"] and error["remedy"]), error
