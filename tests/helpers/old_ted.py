"""Writes a tiny TED Gesture in its true layout, by lmdb and ``pyarrow.serialize`` (pyarrow 0.14 to 13); nothing imports this.

``tests/core/learning/ted_lmdb.tar.xz`` holds what it wrote with 0.14.1, 0.15.1, 0.17.1 and 11.0.0. No Python of today has
the first three: their own libraries were called out of their wheels (``arrow::py::SerializeObject``, then ``WriteTo``).
"""

import os
import sys

import lmdb
import numpy as np
import pyarrow

MEAN = np.array(
    [
        [0, 0, 0], [0, -0.2, 0], [0, -0.3, 0.04], [0, -0.42, 0], [-0.15, -0.15, 0], [-0.28, 0.07, 0], [-0.23, 0.11, 0.2],
        [0.15, -0.15, 0], [0.29, 0.06, 0], [0.25, 0.11, 0.2],
    ]
)  # fmt: skip
SECONDS, FPS = 3.0, 25


def video(vid, clips, joints=10):
    """Poses of the first clip are lists of lists, those of the second arrays in a list, those of all others an array."""
    made = []
    for number in range(clips):
        start = 10.0 + 20 * number
        poses = np.tile(MEAN, (int(SECONDS * FPS), 5, 1))[:, :joints]
        poses[:, [6, 9], 1] += np.round(0.2 * np.sin(np.arange(len(poses)) / 5), 2)[:, None]
        shapes = [poses.tolist(), list(poses.astype(np.float32)), poses.astype(np.float32)]
        tone = np.tile(np.round(0.3 * np.sin(np.arange(160) / 80 * np.pi), 3), int(SECONDS * 100)).astype(np.float16)
        made.append({
            "words": [["hello", start + 0.5, start + 0.9], ["there", start + 1.0, start + 1.4]],
            "skeletons_3d": shapes[min(number, 2)],
            "skeletons": [[0.0, 1.0, None]] * 3, "audio_feat": np.zeros((128, 50), np.float16),
            "audio_raw": tone,
            "start_frame_no": int(start * FPS), "end_frame_no": int((start + SECONDS) * FPS),
            "start_time": start, "end_time": start + SECONDS,
        })  # fmt: skip
    return {"vid": vid, "clips": made}


class Foreign:
    """An object that pyarrow stores as a pickle."""


def pickled(value):
    """A record with a pickled object in it."""
    context = pyarrow.SerializationContext()
    context.register_type(Foreign, "Foreign", pickle=True)
    return pyarrow.serialize(value | {"extra": Foreign()}, context).to_buffer().to_pybytes()


def write(folder, serialize=lambda value: pyarrow.serialize(value).to_buffer().to_pybytes(), joints=10):
    for part, clips, names in (("train", 3, "abc"), ("val", 1, "a"), ("test", 1, "")):
        place = os.path.join(folder, "lmdb_" + part)
        os.makedirs(place)
        environment = lmdb.open(place, map_size=2**25)
        with environment.begin(write=True) as transaction:
            for number, name in enumerate(names):
                transaction.put(b"%010d" % number, bytes(serialize(video("video-" + name, clips, joints))))
        environment.close()
        os.remove(os.path.join(place, "lock.mdb"))


def many(folder):
    """Records on many pages, some changed and some taken away by later transactions."""
    os.makedirs(folder)
    environment = lmdb.open(folder, map_size=2**25)
    for step in range(3):
        with environment.begin(write=True) as transaction:
            for number in range(step, 600, step + 1):
                transaction.put(b"%05d" % number, b"%d" % step * (number % 40))
            for number in range(100 * step, 100 * step + 50):
                transaction.delete(b"%05d" % number)
    environment.close()
    os.remove(os.path.join(folder, "lock.mdb"))


if __name__ == "__main__":
    write(sys.argv[1], *([pickled] if sys.argv[2:] == ["pickled"] else []))
