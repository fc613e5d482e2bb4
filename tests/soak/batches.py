"""Three processes work on one folder and are killed at random: every clip is made once, and all bytes are those of a calm run.

``python tests/soak/batches.py MINUTES [SEED [PATIENCE]]`` works in a temporary folder and prints the counts; each round begins
with an empty folder, has three slices at work and ends when all three have been left in peace. All waits are ``PATIENCE`` times
as long as on a machine that does nothing else. The exit status is 1 if anything differs.
"""

import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "helpers")]
from sounds import write_wav  # noqa: E402

CLIPS, SLICES = 9, 3
TEXTS = (None, "hello there", "I do not know\u2028it", "{big} yes *really*")
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1"}


def manifest(folder: Path) -> Path:
    """Recordings of a second each, some with words that are not theirs, and the manifest of them."""
    from s2ag.core.sound import audio

    speech = audio.load(ROOT / "examples" / "hello.flac")
    rows = []
    for number in range(CLIPS):
        write_wav(folder / f"{number}.wav", np.roll(speech, -8000 * number)[:16000])
        text = TEXTS[number % len(TEXTS)]
        rows.append({"name": f"clip{number}", "audio": f"{number}.wav", "seed": number, "takes": 1 + number % 2})
        rows[-1] |= {"text": text} if text else {"no_transcript": True}
    path = folder / "clips.jsonl"
    path.write_text("".join(json.dumps(row, ensure_ascii=False) + "\n" for row in rows), "utf-8")
    return path


def started(path: Path, out: Path, part: int) -> subprocess.Popen:
    command = [sys.executable, "-m", "s2ag", "batch", "run", path, "-o", out, "-j", "1", "--slice", f"{part}/{SLICES}"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, env=ENVIRONMENT, start_new_session=True, text=True, errors="replace", **quiet)


def made(out: Path) -> dict[str, str]:
    """Digest of every result."""
    paths = sorted(path for kind in ("npz", "bvh") for path in (out / kind).glob("*"))
    return {path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


def killed(process: subprocess.Popen, chance: random.Random) -> str:
    """End a process, alone or with its children, in one of the ways in which processes end."""
    number, group = chance.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT)), chance.random() < 0.5
    if process.poll() is None:
        (os.killpg if group else os.kill)(process.pid, number)
    process.communicate()
    return f"{number.name} {'group' if group else 'alone'}"


def disturbed(path: Path, out: Path, chance: random.Random, kills: dict[str, int], patience: float) -> list[str]:
    """Run all slices, kill each some times, and let each end in peace; return what those said that did not succeed."""
    running = {part: started(path, out, part) for part in range(1, SLICES + 1)}
    for _ in range(chance.randrange(3, 9)):
        time.sleep(chance.uniform(0.2, 4.0 * patience))
        part = chance.choice(list(running))
        how = killed(running[part], chance)
        kills[how] = kills.get(how, 0) + 1
        running[part] = started(path, out, part)
    wrong = []
    for part, process in running.items():
        said = process.communicate()[1]
        for _ in range(20):  # children of a parent that was killed alone hold its clips until they notice
            if process.returncode == 0 or "Another s2ag batch is at work" not in said:
                break
            time.sleep(patience)
            process = started(path, out, part)
            said = process.communicate()[1]
        if process.returncode:
            wrong.append(f"slice {part} ended with {process.returncode}: {said[-500:]}")
    return wrong


def checked(out: Path, calm: dict[str, str], patience: float) -> list[str]:
    """What is wrong with the results of a round."""
    from s2ag.core.batch.folder import Folder

    wrong = []
    found = made(out)
    wrong += [f"{name} is missing" for name in calm.keys() - found.keys()]
    wrong += [f"{name} is nobody's" for name in found.keys() - calm.keys()]
    wrong += [f"{name} differs" for name in calm.keys() & found.keys() if calm[name] != found[name]]
    records = sorted(path.stem for path in (out / "records" / "synth").glob("*.json"))
    if records != sorted(f"clip{number}" for number in range(CLIPS)):
        wrong.append(f"the records are {records}")
    end = time.monotonic() + 20 * patience
    while (left := [*out.rglob(".s2ag@*"), *out.glob(".part/*")]) and time.monotonic() < end:
        time.sleep(0.5)
        from s2ag.core import files

        files._SWEPT.clear()  # as a new process, which has swept nothing yet
        Folder(out).sweep()
    return wrong + [f"{path.relative_to(out)} was left" for path in left]


def main() -> None:
    """Soak for as many minutes."""
    minutes, seed, patience = map(float, (sys.argv[1:] + ["0", "1"][len(sys.argv) - 2 :])[:3])
    end, chance, kills, rounds, wrong = time.monotonic() + 60 * minutes, random.Random(int(seed)), {}, 0, []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ENVIRONMENT["S2AG_CACHE"] = str(folder / "cache")
        path = manifest(folder)
        for part in range(1, SLICES + 1):
            process = started(path, folder / "calm", part)
            said = process.communicate()[1]
            assert process.returncode == 0, said
        calm = made(folder / "calm")
        while time.monotonic() < end:
            out = folder / f"round{rounds}"
            found = disturbed(path, out, chance, kills, patience) + checked(out, calm, patience)
            wrong += [f"round {rounds}: {one}" for one in found]
            rounds += 1
            print(f"{rounds} rounds, {sum(kills.values())} kills, {len(wrong)} wrong", *found, sep="\n", flush=True)
    clips, results = rounds * CLIPS, rounds * len(calm)
    told = f"{rounds} rounds of {CLIPS} clips in {SLICES} processes: {clips} clips, {results} results"
    print(f"{told}, kills {kills}, {len(wrong)} wrong")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
