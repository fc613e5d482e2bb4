"""One-shot export of the TED Gesture data set out of its old LMDB and pyarrow files: one .npz and one .json a video.

    python ted_export.py lmdb_folder OUT          # OUT/train, OUT/val, OUT/test

This file stands alone and runs in an old Python (3.6 or newer) with lmdb, numpy and the pyarrow that wrote the data (0.14.0
to 0.17.1; later ones cannot read it). No handler for pickled classes is registered, so nothing in the data is run.
"""

import json
import os
import sys

import numpy as np

ARRAYS = ("skeletons_3d", "audio_raw")
TIMES = ("start_frame_no", "end_frame_no", "start_time", "end_time")


def export(source, out):
    """Export every lmdb_* folder in ``source`` (or ``source`` itself) to ``out``; returns the number of videos."""
    import lmdb
    import pyarrow

    context = pyarrow.SerializationContext()
    parts = [(name[5:], os.path.join(source, name)) for name in sorted(os.listdir(source)) if name.startswith("lmdb_")]
    parts = [(part, path) for part, path in parts if not part.endswith("_cache") and "cache" not in part]
    if not parts and os.path.exists(os.path.join(source, "data.mdb")):
        parts = [("train", source)]
    if not parts:
        raise SystemExit(f"{source} holds no lmdb_train, lmdb_val or lmdb_test.")
    count = 0
    for part, path in parts:
        folder = os.path.join(out, part)
        if not os.path.isdir(folder):
            os.makedirs(folder)
        environment = lmdb.open(path, readonly=True, lock=False)
        with environment.begin(write=False) as transaction:
            for key, value in transaction.cursor():
                try:
                    video = pyarrow.deserialize(value, context)
                    save(video, folder, f"{key.decode()}_{video['vid']}")
                except Exception as error:
                    raise SystemExit(f"Record {key!r} of {path} cannot be read: {error}") from error
                count += 1
        environment.close()
    return count


def save(video, folder, name):
    """Write one video: arrays of clip 3 are "3.skeletons_3d" and "3.audio_raw", all else is JSON."""
    arrays, clips = {}, []
    for number, clip in enumerate(video["clips"]):
        for part in ARRAYS:
            array = np.asarray(clip[part])
            if array.dtype == object:
                array = np.asarray(array.tolist(), np.float32)
            arrays[f"{number}.{part}"] = array.astype(np.float16 if part == "audio_raw" else np.float32)
        words = [[str(word), float(start), float(end)] for word, start, end in clip["words"]]
        times = {part: float(clip[part]) for part in TIMES}
        clips.append(dict(times, words=words))
    temporary = os.path.join(folder, name + ".part.npz")
    np.savez_compressed(temporary, **arrays)
    os.replace(temporary, os.path.join(folder, name + ".npz"))
    with open(os.path.join(folder, name + ".json"), "w") as file:
        json.dump({"vid": str(video["vid"]), "clips": clips}, file)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit("usage: python ted_export.py LMDB_FOLDER OUT")
    print(export(sys.argv[1], sys.argv[2]), "videos")
