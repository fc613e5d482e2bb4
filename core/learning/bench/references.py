"""Rows that need no network: what stillness scores, and real motion that is not the window's own."""

import numpy as np

from ...motion import skeleton
from . import rows, table
from .judging import Bench


def rows_of(bench: Bench) -> dict[str, dict]:
    """Title and figures by name: the given pose held, the window's own mean, real motion of others, and the performed one."""
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
    told = {name: {"title": title, "figures": table.summarise([bench.judge(made)])} for name, (title, made) in motions.items()}
    if bench.elsewhere is not None:
        others = bench.data.motions(bench.elsewhere)
        told["real"] |= rows.answers(bench.judge_elsewhere(lambda draw: others, 1).draws, [bench.judge(bench.real)])
    return told


def same_talker(bench: Bench) -> np.ndarray | None:
    """For every window one ``(n, 2)`` of another talk of its speaker; None where somebody gave one talk alone."""
    speaker, others = bench.data.corpus.speaker[bench.windows[:, 0]], np.empty_like(bench.windows)
    for one in np.unique(np.stack([speaker, bench.talk], 1), axis=0):
        here = (speaker == one[0]) & (bench.talk == one[1])
        rest = np.flatnonzero((speaker == one[0]) & ~here)
        if not len(rest):
            return None
        others[here] = bench.windows[rest[np.linspace(0, len(rest) - 1, here.sum()).astype(int)]]
    return others


def same_speech(bench: Bench) -> np.ndarray | None:
    """For every window the same one ``(n, 2)`` of the recording's next performance; None where one has no other as long."""
    corpus, others = bench.data.corpus, bench.windows.copy()
    for talk in np.unique(bench.windows[:, 0]):
        takes = np.flatnonzero(corpus.recording == corpus.recording[talk])
        next_one = takes[(np.searchsorted(takes, talk) + 1) % len(takes)]
        here = bench.windows[:, 0] == talk
        last = bench.windows[here, 1].max() + bench.real.shape[1]
        if next_one == talk or corpus.starts[next_one + 1] - corpus.starts[next_one] < last:
            return None
        others[here, 0] = next_one
    return others
