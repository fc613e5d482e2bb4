"""Reference rows without a network: held poses, and recorded motion of other windows."""

import numpy as np

from ...motion import skeleton
from . import rows, table
from .evaluation import Bench


def reference_rows(bench: Bench) -> dict[str, dict]:
    """Return title and figures by name: last seed pose held, mean pose, recorded motion of other windows, and the own one."""
    held, mean = bench.real.copy(), bench.real.copy()
    held[:, bench.given :] = held[:, bench.given - 1 : bench.given]
    mean[:, bench.given :] = skeleton.normalize(mean[:, bench.given :].mean(1, keepdims=True))
    motions = {"held": ("last given pose held", held), "mean": ("mean pose of the window's own future", mean)}
    for name, title, windows in (
        ("talker", "same talker's performed motion, another talk", same_talker(bench)),
        ("speech", "another talker's performed motion, same speech", same_speech(bench)),
    ):
        if windows is not None:
            motions[name] = title, bench.data.motions(windows)
    motions["real"] = "performed", bench.real
    result = {
        name: {"title": title, "figures": table.summarise([bench.judge(motion)])} for name, (title, motion) in motions.items()
    }
    if bench.elsewhere is not None:
        others = bench.data.motions(bench.elsewhere)
        result["real"] |= rows.speech_gains(bench.judge_elsewhere(lambda draw: others, 1).draws, [bench.judge(bench.real)])
    return result


def same_talker(bench: Bench) -> np.ndarray | None:
    """Return for every window one ``(n, 2)`` of another talk of its speaker; None if a speaker has only one talk."""
    speaker, others = bench.data.corpus.speaker[bench.windows[:, 0]], np.empty_like(bench.windows)
    for owner, talk in np.unique(np.stack([speaker, bench.talk], 1), axis=0):
        here = (speaker == owner) & (bench.talk == talk)
        rest = np.flatnonzero((speaker == owner) & ~here)
        if not len(rest):
            return None
        others[here] = bench.windows[rest[np.linspace(0, len(rest) - 1, here.sum()).astype(int)]]
    return others


def same_speech(bench: Bench) -> np.ndarray | None:
    """Return for every window the same one ``(n, 2)`` of the recording's next performance; None if one has no other as long."""
    corpus, others = bench.data.corpus, bench.windows.copy()
    for talk in np.unique(bench.windows[:, 0]):
        takes = np.flatnonzero(corpus.recording == corpus.recording[talk])
        next_take = takes[(np.searchsorted(takes, talk) + 1) % len(takes)]
        here = bench.windows[:, 0] == talk
        last = bench.windows[here, 1].max() + bench.real.shape[1]
        if next_take == talk or corpus.starts[next_take + 1] - corpus.starts[next_take] < last:
            return None
        others[here, 0] = next_take
    return others
