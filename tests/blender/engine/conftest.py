import bpy
import pytest
import s2ag
from s2ag.s2ag_blender.engine import known


@pytest.fixture
def extension(tmp_path, monkeypatch):
    """The extension registered, with a user folder of its own and no engine known."""
    monkeypatch.delenv("S2AG_PYTHON", raising=False)
    monkeypatch.setattr(known, "folder", lambda: tmp_path / "user")
    known.keep(bpy.context, "")
    s2ag.register()
    yield tmp_path / "user"
    s2ag.unregister()
    known.keep(bpy.context, "")
