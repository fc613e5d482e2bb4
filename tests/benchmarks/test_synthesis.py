"""Seconds for a minute of audio, stage by stage, cold and warm; memory. Run: pytest tests/benchmarks --benchmark-only."""

import json
import subprocess
import sys
import time

import numpy as np
import pytest
from sounds import write_wav

av = pytest.importorskip("av")
pytest.importorskip("torch")

from s2ag.core.sound import audio  # noqa: E402
from s2ag.core.synthesis.session import Request, Session  # noqa: E402
from transcripts import words_and_warnings  # noqa: E402

MINUTE = 60.0


@pytest.fixture(scope="module")
def minute(tmp_path_factory, examples):
    """A minute of speech as a WAV file, and its aligned words as JSON: the shipped recording again and again."""
    folder = tmp_path_factory.mktemp("minute")
    sound = audio.load(examples / "hello.flac")
    words, _ = words_and_warnings(sound, transcript=examples / "hello.txt")
    times = int(np.ceil(MINUTE * audio.SAMPLE_RATE / len(sound)))
    offset = len(sound) / audio.SAMPLE_RATE
    repeated = [[word, start + i * offset, end + i * offset] for i in range(times) for word, start, end in words]
    (folder / "minute.json").write_text(json.dumps([word for word in repeated if word[2] < MINUTE]))
    write_wav(folder / "minute.wav", np.tile(sound, times)[: int(MINUTE * audio.SAMPLE_RATE)])
    (folder / "minute.txt").write_text(" ".join(word for word, _, end in repeated if end < MINUTE))
    return folder


@pytest.mark.parametrize("backend", ["numpy", "torch"])
@pytest.mark.parametrize(("words", "rounds"), [("minute.json", 5), ("minute.txt", 2)], ids=["aligned", "plain text"])
def test_warm(benchmark, minute, words, rounds, backend):
    session = Session(backend=backend)
    request = Request(minute / "minute.wav", transcript=minute / words)
    session.synthesize(request)
    result = benchmark.pedantic(session.synthesize, args=(request,), rounds=rounds)
    benchmark.extra_info["seconds"] = result.seconds
    print(f"\nwarm, {backend}:", stages(result.seconds))


def test_eight_takes_against_one_by_one(benchmark, minute):
    session = Session()
    request = Request(minute / "minute.wav", transcript=minute / "minute.json", takes=8)
    began = time.perf_counter()
    for seed in range(8):
        session.synthesize(Request(request.audio, transcript=request.transcript, seed=seed))
    singly = time.perf_counter() - began
    benchmark.pedantic(session.synthesize, args=(request,), rounds=2)
    benchmark.extra_info["ratio"] = singly / benchmark.stats.stats.mean
    print(f"\neight takes in one batch: {benchmark.extra_info['ratio']:.1f} times faster than one by one")


@pytest.mark.parametrize("backend", ["numpy", "torch"])
def test_nine_takes_against_one(benchmark, minute, backend):
    session, wall, busy = Session(backend=backend), {}, {}
    for takes in (1, 9):
        request = Request(minute / "minute.wav", transcript=minute / "minute.json", takes=takes)
        session.synthesize(request)
        rounds = []
        for _ in range(7 if takes == 1 else 4):
            began = time.perf_counter(), time.process_time()
            session.synthesize(request)
            rounds.append((time.perf_counter() - began[0], time.process_time() - began[1]))
        wall[takes], busy[takes] = (min(part) for part in zip(*rounds, strict=True))
    benchmark.extra_info["ratio"] = wall[9] / wall[1]
    benchmark.pedantic(session.synthesize, args=(request,), rounds=1)
    told = ", ".join(f"{takes} takes {wall[takes]:.2f} s ({busy[takes]:.2f} of processors)" for takes in (1, 9))
    print(f"\n{backend}, best of several: {told}; {wall[9] / wall[1]:.2f} times one")


@pytest.mark.parametrize("backend", ["numpy", "torch"])
@pytest.mark.parametrize("words", ["minute.json", "minute.txt"])
def test_cold_command_line(benchmark, minute, tmp_path, words, backend):
    command = [sys.executable, "-m", "s2ag", "synth", minute / "minute.wav", "--transcript", minute / words, "--cache", "off"]
    command += ["--backend", backend]
    benchmark.pedantic(subprocess.run, args=([*command, "-o", tmp_path / "out.npz"],), kwargs={"check": True}, rounds=2)


def test_worker_memory(benchmark, minute):
    from s2ag.s2ag_blender.engine.client import WorkerClient

    client = WorkerClient()
    params = {"audio": str(minute / "minute.wav"), "transcript": str(minute / "minute.txt")}
    benchmark.pedantic(client.call, args=("synthesize", params), rounds=2)
    benchmark.extra_info["peak_mb"] = peak = peak_megabytes(client.pid)
    client.close()
    print(f"\nworker's peak memory: {peak:.0f} MB")


def test_an_hour(benchmark, minute, tmp_path):
    import resource

    write_wav(tmp_path / "hour.wav", np.tile(audio.load(minute / "minute.wav"), 60))
    command = [sys.executable, "-m", "s2ag", "synth", tmp_path / "hour.wav", "--no-transcript", "-o", tmp_path / "out.npz"]
    benchmark.pedantic(subprocess.run, args=(command,), kwargs={"check": True}, rounds=1)
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    benchmark.extra_info["peak_mb"] = peak
    print(f"\nan hour of audio: {benchmark.stats.stats.mean:.1f} s, largest child so far {peak:.0f} MB")


def peak_megabytes(pid):
    with open(f"/proc/{pid}/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) / 1024


def stages(seconds):
    return ", ".join(f"{stage} {value:.3f} s" for stage, value in seconds.items()) + f"; total {sum(seconds.values()):.3f} s"
