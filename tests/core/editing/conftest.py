"""Fixtures of directed takes; a module has ``request_``, the take that it directs."""

import pytest
from s2ag.core.editing.director import Director
from s2ag.core.synthesis.session import Session


@pytest.fixture(scope="module")
def director():
    return Director(Session(cache="off"))


@pytest.fixture(scope="module")
def base(director, request_):
    """The take before edits."""
    return director.direct(request_, []).motions[0]
