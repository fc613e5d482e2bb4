"""Writes a tiny TED Gesture LMDB in the true layout; run by an old interpreter that still has pyarrow.serialize."""

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


def video(vid, clips, seed):
    random = np.random.RandomState(seed)
    made = []
    for number in range(clips):
        start, seconds, fps = 10.0 + 20 * number, 5.0, 25
        poses = np.tile(MEAN, (int(seconds * fps), 1, 1))
        poses[:, [6, 9], 1] += 0.2 * np.sin(np.arange(len(poses)) / 5)[:, None]
        made.append({
            "words": [["hello", start + 0.5, start + 0.9], ["there", start + 1.0, start + 1.4]],
            "skeletons_3d": poses.astype(np.float32) if number else poses.tolist(),
            "skeletons": [], "audio_feat": random.rand(128, 50).astype(np.float16),
            "audio_raw": (0.1 * random.randn(int(seconds * 16000))).astype(np.float16),
            "start_frame_no": int(start * fps), "end_frame_no": int((start + seconds) * fps),
            "start_time": start, "end_time": start + seconds,
        })  # fmt: skip
    return {"vid": vid, "clips": made}


class Foreign:
    """An object that pyarrow stores as a pickle."""


def write(folder, evil=False):
    context = pyarrow.SerializationContext()
    context.register_type(Foreign, "Foreign", pickle=True)
    for part, clips in (("train", 2), ("val", 1), ("test", 0)):
        os.makedirs(folder, exist_ok=True)
        environment = lmdb.open(os.path.join(folder, "lmdb_" + part), map_size=2**25)
        with environment.begin(write=True) as transaction:
            for number in range(3):
                value = video(f"video{number:05d}_x", clips, number)
                if evil:
                    value["extra"] = Foreign()
                data = pyarrow.serialize(value, context).to_buffer().to_pybytes()
                transaction.put(f"{number:010d}".encode(), data)
        environment.close()


if __name__ == "__main__":
    write(sys.argv[1], sys.argv[2:] == ["evil"])
