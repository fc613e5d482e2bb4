"""Work shared out among threads: all of it is done, in order, and what fails is told."""

import subprocess
import sys
import threading

import numpy as np
import pytest
from s2ag.core import matrix_products, threads


@pytest.fixture(params=[1, 3])
def cores(request, monkeypatch):
    """So many threads, whatever this machine has."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        monkeypatch.setenv(name, str(request.param))
    monkeypatch.setattr(threads.os, "sched_getaffinity", lambda process: range(4), raising=False)
    threads.thread_count.cache_clear()
    threads._pool.cache_clear()
    yield request.param
    threads._pool().shutdown()
    threads._pool.cache_clear()
    threads.thread_count.cache_clear()


def test_every_part_is_done_once_and_answers_stand_in_order(cores):
    assert threads.thread_count() == cores
    assert threads.parallel_map(lambda part: part * part, range(100)) == [part * part for part in range(100)]
    assert threads.parallel_map(str, []) == []


def test_parts_may_be_shared_out_again(cores):
    inner = lambda part: sum(threads.parallel_map(lambda number: number, range(part)))  # noqa: E731
    assert threads.parallel_map(inner, range(40)) == [part * (part - 1) // 2 for part in range(40)]


def test_who_has_a_part_knows_whether_the_others_have_one_too(cores):
    assert not threads.all_busy()
    within = lambda: threads.parallel_map(lambda _: threads.all_busy(), [0])[0]  # noqa: E731
    busy = threads.parallel_map(lambda _: (threads.all_busy(), within()), range(7))
    whole = 7 // cores * cores  # of the seventh part three threads have nothing
    assert busy == [(number < whole, number < whole or cores == 1) for number in range(7)]
    assert threads.parallel_map(lambda _: threads.all_busy(), range(40), 2) == [cores == 1 or cores == 2] * 40
    assert not threads.all_busy()


def test_no_more_at_once_than_asked(cores):
    at_once, most, lock = [0], [0], threading.Lock()

    def work(part):
        with lock:
            at_once[0] += 1
            most[0] = max(most[0], at_once[0])
        np.linalg.svd(np.eye(60))
        with lock:
            at_once[0] -= 1

    threads.parallel_map(work, range(30), 2)
    assert most[0] <= min(cores, 2) and at_once[0] == 0


def test_what_fails_is_raised_and_ends_the_rest(cores):
    done = []

    def work(part):
        if part == 5:
            raise ValueError("five")
        done.append(part)

    with pytest.raises(ValueError, match="five"):
        threads.parallel_map(work, range(10_000))
    assert len(done) < 9_999
    assert threads.parallel_map(abs, [-1]) == [1]


def test_products_are_one_threads_and_the_number_comes_back():
    ask, tell = matrix_products._openblas()
    before = ask()
    tell(2)
    try:
        wanted = ask()
        with matrix_products.single_threaded_blas(), matrix_products.single_threaded_blas():
            assert ask() == 1
        assert ask() == wanted
    finally:
        tell(before)


def test_work_ahead_is_done_beside_what_goes_on_and_beside_each_other():
    done, waits = [], threading.Event()

    def first():
        waits.wait(10)
        done.append(1)
        return "first"

    results = threads.run_in_background(first, lambda: done.append(2))
    results[1](10)
    assert done == [2]
    waits.set()
    assert results[0](10) == "first" and done == [2, 1]


def test_what_work_ahead_raises_meets_who_asks_for_it():
    failed, made = threads.run_in_background(lambda: 1 / 0, lambda: 2)
    with pytest.raises(ZeroDivisionError):
        failed(10)
    assert made(10) == 2


def test_work_ahead_keeps_no_program_from_ending():
    waits = "from s2ag.core import threads; threads.run_in_background(threads.threading.Event().wait)"
    assert subprocess.run([sys.executable, "-c", waits], timeout=60).returncode == 0
