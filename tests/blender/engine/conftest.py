import bpy
import pytest
import s2ag
from s2ag.s2ag_blender.engine import engine_state


@pytest.fixture
def extension(tmp_path, monkeypatch):
    """The extension registered, with a user folder of its own and no engine known."""
    monkeypatch.delenv("S2AG_PYTHON", raising=False)
    monkeypatch.setattr(engine_state, "folder", lambda: tmp_path / "user")
    engine_state.choose(bpy.context, "")
    s2ag.register()
    yield tmp_path / "user"
    s2ag.unregister()
    engine_state.choose(bpy.context, "")
