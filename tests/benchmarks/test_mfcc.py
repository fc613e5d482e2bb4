"""MFCCs of a minute of sound against librosa: the first call of a fresh process, and a warm one."""

import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("scipy")
librosa = pytest.importorskip("librosa")

from s2ag.core.sound import mfcc  # noqa: E402

OURS = "from s2ag.core.sound.mfcc import mfcc; f = mfcc"
THEIRS = "import librosa; f = lambda y: librosa.feature.mfcc(y=y, sr=16000, n_mfcc=14)"
TIMED = (
    "{}\nimport time, numpy as np\ny = np.random.default_rng(0).normal(0, 0.1, 960000).astype('float32')\n"
    "t = time.perf_counter(); f(y); print(time.perf_counter() - t)"
)


@pytest.fixture(scope="module")
def minute():
    return np.random.default_rng(0).normal(0, 0.1, 960000).astype(np.float32)


def test_warm(benchmark, minute):
    benchmark.pedantic(mfcc.mfcc, args=(minute,), rounds=5, warmup_rounds=1)


def test_warm_librosa(benchmark, minute):
    benchmark.pedantic(librosa.feature.mfcc, kwargs={"y": minute, "sr": 16000, "n_mfcc": 14}, rounds=5, warmup_rounds=1)


@pytest.mark.parametrize("code", [OURS, THEIRS], ids=["ours", "librosa"])
def test_first_call(benchmark, code):
    run = benchmark.pedantic(
        subprocess.run,
        args=([sys.executable, "-c", TIMED.format(code)],),
        kwargs={"check": True, "capture_output": True, "text": True},
        rounds=1,
    )
    benchmark.extra_info["first_call"] = float(run.stdout)
    print(f"\nfirst call: {float(run.stdout):.2f} s")
