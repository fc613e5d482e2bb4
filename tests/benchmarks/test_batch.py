"""Many clips: how many a minute, how much memory, ten kills in the middle. Run: pytest tests/benchmarks --benchmark-only -s."""

import hashlib
import json
import random
import shutil
import signal
import subprocess
import sys
import time

import pytest

for needed in ("torch", "bpy", "piper"):
    pytest.importorskip(needed)

from load import resident_of_children  # noqa: E402
from s2ag.core.batch import folder, manifest, process_pool, stages  # noqa: E402
from s2ag.core.synthesis.session import Request, Session  # noqa: E402
from short_clips import make  # noqa: E402
from sounds import write_wav  # noqa: E402

CLIPS, FILMS, KILLS = 200, 20, 10
POISONED = 7
S2AG = [sys.executable, "-m", "s2ag"]


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """The manifest of two hundred sentences by the neural voice, twenty of them filmed, one cut off in the middle."""
    place = tmp_path_factory.mktemp("clips")
    path = make(place, CLIPS, FILMS)
    poisoned = place / f"{POISONED:04d}.wav"
    poisoned.write_bytes(poisoned.read_bytes()[:20000])
    return path


@pytest.fixture(scope="module")
def calm(clips, tmp_path_factory):
    """The folder of an undisturbed run, and the seconds it took."""
    out = tmp_path_factory.mktemp("calm") / "out"
    began = time.perf_counter()
    assert run(clips, out).wait() == 1
    return out, time.perf_counter() - began


@pytest.fixture(scope="module")
def ten_seconds(tmp_path_factory, examples):
    from s2ag.core.sound import audio

    path = tmp_path_factory.mktemp("voice") / "ten.wav"
    write_wav(path, audio.load(examples / "hello.flac")[: 10 * audio.SAMPLE_RATE])
    return path


def run(path, out):
    return subprocess.Popen([*S2AG, "batch", "run", path, "-o", out], stderr=subprocess.DEVNULL)


def test_killed_ten_times_it_ends_as_if_nothing_had_been(benchmark, clips, calm, tmp_path):
    out, chance = tmp_path / "out", random.Random(3)
    moments = sorted(chance.sample(range(CLIPS + 2 * FILMS), KILLS))

    def disturbed():
        for moment in moments:
            process = run(clips, out)
            while process.poll() is None and steps_done(out) < moment:
                time.sleep(0.05)
            time.sleep(chance.uniform(0, 2))
            process.send_signal(signal.SIGKILL)
            process.wait()
        assert run(clips, out).wait() == 1

    benchmark.pedantic(disturbed, rounds=1)
    assert digests(out) == digests(calm[0])
    (failure,) = [json.loads(line) for line in (out / "failures.jsonl").read_text().splitlines()]
    assert failure["name"] == f"clip{POISONED:04d}"
    counts = [len(list((out / kind).iterdir())) for kind in ("npz", "bvh", "mp4")]
    assert counts == [CLIPS - 1, CLIPS - 1, FILMS - 1]
    print(f"\nkilled after {moments} steps: npz, bvh and mp4 as in the calm run, which took {calm[1]:.0f} s")


def test_clips_a_minute_against_a_process_each(benchmark, clips, tmp_path):
    rows = [json.loads(line) for line in clips.read_text().splitlines()][FILMS : FILMS + 40]
    few = clips.with_name("few.jsonl")
    few.write_text("".join(json.dumps(row) + "\n" for row in rows))
    benchmark.pedantic(lambda: run(few, tmp_path / "out").wait(), rounds=1)
    began = time.perf_counter()
    for row in rows[:5]:
        arguments = [
            "synth",
            clips.with_name(row["audio"]),
            "--text",
            row["text"],
            "-o",
            tmp_path / "a.npz",
            "-o",
            tmp_path / "a.bvh",
        ]
        subprocess.run([*S2AG, *arguments], check=True, capture_output=True)
    singly, together = 60 * 5 / (time.perf_counter() - began), 60 * len(rows) / benchmark.stats.stats.mean
    print(f"\nto BVH: {together:.0f} clips a minute, {singly:.0f} with a process each")


def test_films_a_minute_against_a_process_each(benchmark, clips, tmp_path):
    rows = [json.loads(line) for line in clips.read_text().splitlines()][:6]
    few = clips.with_name("films.jsonl")
    few.write_text("".join(json.dumps(row) + "\n" for row in rows))
    benchmark.pedantic(lambda: run(few, tmp_path / "out").wait(), rounds=1)
    began = time.perf_counter()
    for row in rows[:2]:
        looks = ["--character", "mannequin", "--resolution", row["resolution"], "-o", tmp_path / "a.mp4"]
        subprocess.run([*S2AG, "animate", clips.with_name(row["audio"]), "--text", row["text"], *looks], check=True)
    singly, together = 60 * 2 / (time.perf_counter() - began), 60 * len(rows) / benchmark.stats.stats.mean
    print(f"\nto MP4 ({rows[0]['resolution']}, Workbench): {together:.1f} clips a minute, {singly:.1f} with a process each")


def test_nine_takes_as_a_film(benchmark, ten_seconds, tmp_path):
    command = [*S2AG, "sample", ten_seconds, "--takes", "9", "-o", tmp_path / "sheet.mp4"]
    benchmark.pedantic(subprocess.run, args=(command,), kwargs={"check": True}, rounds=1)
    print(f"\nnine takes of ten seconds as a grid: {benchmark.stats.stats.mean:.0f} s")


def test_nine_takes_against_one(benchmark, ten_seconds):
    session = Session()
    seconds = {}
    for takes in (1, 9):
        session.synthesize(Request(ten_seconds, takes=takes))
        began = time.perf_counter()
        for _ in range(5):
            session.synthesize(Request(ten_seconds, takes=takes))
        seconds[takes] = (time.perf_counter() - began) / 5
    benchmark.pedantic(session.synthesize, args=(Request(ten_seconds, takes=9),), rounds=1)
    print(f"\nnine takes: {seconds[9]:.2f} s, one: {seconds[1]:.2f} s, {seconds[9] / seconds[1]:.1f} times as long")


@pytest.mark.parametrize("stage", ["synth", "render"])
def test_memory_over_two_hundred_clips(benchmark, clips, calm, tmp_path, stage):
    """Resident megabytes of the one process after 20, 100 and 200 clips."""
    from s2ag.core.cli import blender

    whole, out = manifest.read(clips)[0], tmp_path / "out"
    whole = [one for one in whole if one.line != POISONED]
    shutil.copytree(calm[0], out)
    batch = stages.Batch(folder.Folder(out), whole)
    command = [*S2AG[:1], "-m", "s2ag.core.batch.tasks"] if stage == "synth" else blender.command("render.serve")
    ready = batch.steps(stage, batch.units)
    if stage == "render":  # one short film again and again, its images thrown away
        job = {**ready[0].task.params["job"], "sequences": [], "outputs": [], "places": {}}
        job["performers"] = [{**one, "outputs": ["c.fbx"]} for one in job["performers"]]
        job["places"] = {"c.fbx": str(out / "c.fbx")}
        tasks = [process_pool.Task("render", {**ready[0].task.params, "job": job}, n) for n in range(200)]
    else:
        tasks = [process_pool.Task("synth", step.task.params, n) for n, step in enumerate(ready)]
    sizes = {}

    def work():
        for task, outcome, _ in process_pool.ProcessPool(command, 1).run(tasks):
            if outcome is not None and task.label + 1 in (20, 100, len(tasks)):
                assert isinstance(outcome, dict), outcome
                sizes[task.label + 1] = resident_of_children()

    benchmark.pedantic(work, rounds=1)
    print(f"\n{stage}: " + ", ".join(f"{size:.0f} MB after {count}" for count, size in sizes.items()))


def steps_done(out):
    return sum(len(list((out / "records" / stage).glob("[!.]*.json"))) for stage in ("synth", "render", "encode"))


def digests(out):
    files = [path for kind in ("npz", "bvh", "mp4") for path in (out / kind).iterdir()]
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
