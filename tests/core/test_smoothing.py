"""Our smoothing is scipy's."""

import numpy as np
import pytest
from s2ag.core import matrix_products, smoothing

LENGTHS = [1, 2, 11, 1000]


def track(length):
    return np.random.default_rng(length).normal(size=length)


@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("sigma", [0.4, 3.0, 50.0])
def test_gaussian(length, sigma):
    ndimage = pytest.importorskip("scipy.ndimage")
    expected = ndimage.gaussian_filter1d(track(length), sigma, mode="nearest")
    np.testing.assert_allclose(smoothing.gaussian(track(length), sigma), expected, atol=1e-12)


@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("size", [1, 2, 5, 400])
def test_running_mean(length, size):
    ndimage = pytest.importorskip("scipy.ndimage")
    expected = ndimage.uniform_filter1d(track(length), size, mode="nearest")
    np.testing.assert_allclose(smoothing.running_mean(track(length), size), expected, atol=1e-12)


def test_running_maximum():
    found = smoothing.running_maximum(np.array([0, 0, 0, 5, 0, 0, 0, 3.0]), before=1, after=2)
    np.testing.assert_array_equal(found, [0, 0, 5, 5, 5, 5, 3, 3])
    ndimage = pytest.importorskip("scipy.ndimage")
    values = np.abs(track(300))
    expected = ndimage.maximum_filter1d(values, 12, origin=3, mode="constant")
    np.testing.assert_array_equal(smoothing.running_maximum(values, 2, 9), expected)


def test_nothing_stays_nothing():
    empty = np.zeros(0)
    assert not len(smoothing.gaussian(empty, 2)) + len(smoothing.running_mean(empty, 5))
    assert not len(smoothing.running_maximum(empty, 2, 9))


def test_products_with_and_without_blas(monkeypatch):
    left, right = (np.random.default_rng(0).normal(size=(n, 27)).astype(np.float32) for n in (50, 8))
    for there in (True, False):
        monkeypatch.setattr(matrix_products, "has_fast_blas", lambda there=there: there)
        np.testing.assert_allclose(matrix_products.matmul_transposed(left, right), left @ right.T, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "found", "replaced", "fast"),
    [
        ("openblas64", True, False, True),
        ("accelerate", True, False, True),
        ("blas", True, False, False),
        ("blas", True, True, True),
        ("none", False, False, False),
    ],
)
def test_the_reference_blas_is_no_fast_one(monkeypatch, name, found, replaced, fast):
    """A distribution's numpy says "blas": the reference at 1.6 GFLOP/s, unless its user has put another in its place."""
    built = {"Build Dependencies": {"blas": {"name": name, "found": found}}}
    monkeypatch.setattr(matrix_products.np, "show_config", lambda mode: built)
    monkeypatch.setattr(matrix_products, "_has_fast_symbols", lambda: replaced)
    assert matrix_products.has_fast_blas.__wrapped__() is fast
