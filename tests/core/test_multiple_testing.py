"""Probabilities of several tests on the same data."""

import pytest
from s2ag.core.multiple_testing import holm_correction


def test_holm_corrects_the_smallest_most():
    assert holm_correction({"a": 0.03, "b": 0.01, "c": 0.02}) == pytest.approx({"a": 0.04, "b": 0.03, "c": 0.04})
    assert holm_correction({"a": 0.9, "b": 0.8}) == {"a": 1.0, "b": 1.0} and holm_correction({}) == {}


def test_holm_keeps_the_order_in_which_they_came():
    found = holm_correction({"a": 0.01, "b": 0.04, "c": 0.03, "d": 0.005})
    assert list(found) == ["a", "b", "c", "d"] and found == pytest.approx({"a": 0.03, "b": 0.06, "c": 0.06, "d": 0.02})
