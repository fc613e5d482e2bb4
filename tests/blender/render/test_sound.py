import bpy
import numpy as np
import pytest
from acted import press
from s2ag.core.errors import AudioUnreadable
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.render import opengl
from s2ag.s2ag_blender.render.sound import add_sound
from sounds import write_wav


@pytest.fixture
def recording(tmp_path):
    """Two seconds of a tone."""
    path = tmp_path / "voice – naïve.wav"
    write_wav(path, 0.25 * np.sin(np.arange(32000) / 20))
    try:
        bpy.data.sounds.remove(bpy.data.sounds.load(str(path)))
        scene = bpy.data.scenes.new("probe")
        compat.sequencer_strips(scene.sequence_editor_create()).new_sound("probe", str(path), 1, 1)
        bpy.data.scenes.remove(scene)
    except RuntimeError as error:
        pytest.skip(f"this Blender was built without sound: {error}")
    return path


def test_a_strip_at_the_start_frame_and_playback_that_follows_it(recording):
    scene = bpy.context.scene
    strip = add_sound(scene, recording, 20)
    assert compat.strip_start(strip) == 20
    assert compat.strip_end(strip) == pytest.approx(20 + 2 * scene.render.fps, abs=1)
    assert scene.sync_mode == "AUDIO_SYNC"
    assert scene.render.ffmpeg.audio_codec == "AAC"  # so that a film of the Render menu has sound


def test_a_strip_that_plays_it_from_there_will_do_and_no_other_is_moved(recording):
    scene = bpy.context.scene
    first = add_sound(scene, recording, 1)
    first.frame_final_start = 20  # cut: what it plays still starts at frame 1
    assert add_sound(scene, recording, 1).name == first.name
    again = add_sound(scene, recording, 48)
    assert again.name != first.name and compat.strip_start(again) == 48 and compat.strip_start(first) == 1
    assert len(compat.sequencer_strips(scene.sequence_editor)) == 2


def test_other_strips_keep_their_place(recording, tmp_path):
    scene = bpy.context.scene
    other = tmp_path / "other.wav"
    other.write_bytes(recording.read_bytes())
    first, second = add_sound(scene, recording, 5), add_sound(scene, other, 5)
    assert compat.strip_start(first) == compat.strip_start(second) == 5
    assert first.channel != second.channel


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(AudioUnreadable, match="does not exist"):
        add_sound(bpy.context.scene, tmp_path / "none.wav", 1)


def test_a_film_from_the_panel_has_sound(speaker, tmp_path):
    av = pytest.importorskip("av")
    path, scene = str(tmp_path / "talk.mp4"), bpy.context.scene
    press(bpy.ops.s2ag.generate)
    scene.camera = None
    with pytest.raises(RuntimeError, match="has no camera"):
        bpy.ops.s2ag.export(filepath=path, format=".mp4")
    if not opengl.is_available():
        pytest.skip("this machine offers no OpenGL, not even in software")
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    scene.frame_end, scene.render.resolution_x, scene.render.resolution_y = 6, 64, 48
    scene.frame_set(4)
    before = scene.render.filepath, scene.render.image_settings.file_format
    assert bpy.ops.s2ag.export(filepath=path, format=".mp4") == {"FINISHED"}
    assert (scene.render.filepath, scene.render.image_settings.file_format) == before and scene.frame_current == 4
    with av.open(path) as film:
        assert film.streams.video[0].frames == 6 and film.streams.audio
