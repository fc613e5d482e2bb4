"""S2AG in the published size: windows a second of a training step, and the share of the machine's limit that it reaches.

The limit is the rate at which the same device multiplies two large matrices of the training's precision. A step counts every
product in it, three times forward, and once backward for what takes a gradient.

Run: pytest tests/benchmarks/test_bench.py --benchmark-only -s            (S2AG_DEVICE=cuda for a GPU, S2AG_BATCH=512)
"""

import os
import time

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("pytest_benchmark")

from s2ag.core.learning.bench.data import Data  # noqa: E402
from s2ag.core.learning.bench.setting import SETTINGS  # noqa: E402
from s2ag.core.learning.bench.training import Training  # noqa: E402
from s2ag.core.learning.systems.catalogue import SYSTEMS, BuildOptions  # noqa: E402
from toy_bench import write_bench_corpus  # noqa: E402

DEVICE = os.environ.get("S2AG_DEVICE", "cpu")
BATCH = int(os.environ.get("S2AG_BATCH", 64))


def limit(kind: torch.dtype, size: int = 3000) -> float:
    """Floating-point operations a second of a product of two large matrices."""
    a, b = (torch.randn(size, size, device=DEVICE, dtype=kind) for _ in range(2))
    best = float("inf")
    for _ in range(5):
        began = time.perf_counter()
        product = a @ b
        float(product[0, 0])  # waits for a GPU
        best = min(best, time.perf_counter() - began)
    return 2 * size**3 / best


@pytest.mark.parametrize("precision", ["32-true", "bf16-mixed"])
@pytest.mark.parametrize("name", ["s2ag", "gtc"])
def test_published_step(benchmark, tmp_path, name, precision):
    from torch.utils.flop_counter import FlopCounterMode

    torch.set_num_threads(1)
    data = Data(write_bench_corpus(tmp_path / "data", talks=24), tmp_path, filtered=False)
    setting = SETTINGS["full"].replace(batch=BATCH, precision=precision)
    torch.manual_seed(0)
    training = Training(
        SYSTEMS[name].build(BuildOptions(data.vectors, data.speakers)), data, setting, 1, tmp_path / name, DEVICE
    )
    sample = data.sample(data.windows[0][np.arange(BATCH) % len(data.windows[0])])

    def step():
        float(training.step(sample)["huber"])

    with FlopCounterMode(display=False) as counter:
        step()
    benchmark.pedantic(step, rounds=5, warmup_rounds=1)
    seconds = benchmark.stats.stats.min
    work, most = counter.get_total_flops(), limit(torch.float32 if precision == "32-true" else torch.bfloat16)
    share = work / seconds / most
    benchmark.extra_info.update(windows_per_second=round(BATCH / seconds, 1), share_of_limit=round(share, 3))
    print(
        f"\n{name}, batch {BATCH}, {DEVICE}, {precision}: {BATCH / seconds:.1f} windows a second, "
        f"{work / BATCH / 1e9:.2f} GFLOP a window, {work / seconds / 1e9:.1f} of {most / 1e9:.1f} GFLOP/s = {share:.0%} of it"
    )
    assert share > 0.02
