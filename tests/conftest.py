from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def examples():
    """The recordings that the repository ships."""
    return ROOT / "examples"


@pytest.fixture(scope="session")
def shared():
    """Public material beside the project; tests that use it skip where it is absent."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the material folder beside the project is absent")
    return folder
