"""Finds body, hands and face in pictures with MediaPipe, as a separate program that :mod:`estimator` starts.

It needs Python 3.9 to 3.12 with the packages numpy and mediapipe, and nothing of ours. Standard input is one line of JSON
``{"width", "height", "mode"}`` and then frames: a byte, 1 where a new scene begins, and ``height * width * 3`` bytes of RGB.
Standard output is a line of JSON a frame, and at the end ``{"done": true}``. Mode ``pose``: ``{"pose", "world", "left",
"right", "face"}``, lists of x, y, z and, of the body, visibility, rounded; None for what was not found. Mode ``faces``:
``{"faces": [[x, y, width, height, lips], ...]}`` in shares of the picture, with how far the lips are apart as a share of the
face's height.
"""

import json
import sys

import numpy as np

FACE = (10, 152, 33, 263, 1, 61, 291, 13, 14, 127, 356)
"""Points of the face that are kept: brow, chin, outer corners of right and left eye, nose, corners of the mouth, inner lips,
temples."""
_WIDER = 0.35
"""Share of a face's size that is added on each side before its lips are looked for."""


def main() -> None:
    """Serve one request by the protocol at the top of this file."""
    answers = sys.stdout
    sys.stdout = sys.stderr  # what the package prints is no answer
    import mediapipe  # pyright: ignore[reportMissingImports]  # of another Python

    request = json.loads(sys.stdin.buffer.readline())
    width, height = request["width"], request["height"]
    work = _faces(mediapipe) if request["mode"] == "faces" else _poses(mediapipe)
    next(work)
    while True:
        data = sys.stdin.buffer.read(1 + width * height * 3)
        if len(data) < 1 + width * height * 3:
            break
        picture = np.frombuffer(data, np.uint8, offset=1).reshape(height, width, 3)
        answers.write(json.dumps(work.send((data[0] == 1, picture)), separators=(",", ":")) + "\n")
        answers.flush()
    answers.write('{"done": true}\n')
    answers.flush()


def _poses(mediapipe):
    """Take (new scene, picture), yield the landmarks of the most prominent body."""
    holistic = mediapipe.solutions.holistic.Holistic(model_complexity=1, smooth_landmarks=False)
    answer = None
    while True:
        new, picture = yield answer
        if new:
            holistic.reset()
        found = holistic.process(picture)
        face = found.face_landmarks
        answer = {
            "pose": _points(found.pose_landmarks, True),
            "world": _points(found.pose_world_landmarks, False),
            "left": _points(found.left_hand_landmarks, False),
            "right": _points(found.right_hand_landmarks, False),
            "face": None if face is None else [_point(face.landmark[row], False) for row in FACE],
        }


def _faces(mediapipe):
    """Take (new scene, picture), yield the faces of all people."""
    detector = mediapipe.solutions.face_detection.FaceDetection(model_selection=1, min_detection_confidence=0.5)
    meshes = mediapipe.solutions.face_mesh.FaceMesh(static_image_mode=True, max_num_faces=1)
    answer = None
    while True:
        _, picture = yield answer
        boxes = [one.location_data.relative_bounding_box for one in detector.process(picture).detections or ()]
        answer = {"faces": [[box.xmin, box.ymin, box.width, box.height, _lips(meshes, picture, box)] for box in boxes]}


def _lips(meshes, picture, box):
    """Return how far the lips of the face in a box are apart, None where they are not seen."""
    height, width = picture.shape[:2]
    left, right = (int(np.clip((box.xmin + box.width * at) * width, 0, width)) for at in (-_WIDER, 1 + _WIDER))
    top, bottom = (int(np.clip((box.ymin + box.height * at) * height, 0, height)) for at in (-_WIDER, 1 + _WIDER))
    if right - left < 16 or bottom - top < 16:
        return None
    found = meshes.process(np.ascontiguousarray(picture[top:bottom, left:right])).multi_face_landmarks
    if not found:
        return None
    mark = found[0].landmark
    return abs(mark[14].y - mark[13].y) / max(abs(mark[152].y - mark[10].y), 1e-6)


def _points(found, seen):
    return None if found is None else [_point(one, seen) for one in found.landmark]


def _point(one, seen):
    point = [round(one.x, 5), round(one.y, 5), round(one.z, 5)]
    return [*point, round(one.visibility, 3)] if seen else point


if __name__ == "__main__":
    main()
