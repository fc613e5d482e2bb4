"""The data set that the tests of the bench train and judge on."""

import pytest


@pytest.fixture(scope="session")
def corpus(tmp_path_factory):
    """The toy data set with sound and words, as :mod:`toy_bench` writes it; nobody changes it."""
    torch = pytest.importorskip("torch")
    from toy_bench import write_bench_corpus

    torch.set_num_threads(1)
    return write_bench_corpus(tmp_path_factory.mktemp("data") / "corpus")


@pytest.fixture(scope="module")
def data(corpus, tmp_path_factory):
    """Its windows of the usual length, none of them filtered out."""
    from s2ag.core.learning.bench.data import Data

    return Data(corpus, tmp_path_factory.mktemp("cache"), filtered=False)
