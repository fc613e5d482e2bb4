import handed
import numpy as np
import pytest
from bodies import degrees, performance
from s2ag.core.errors import OutputUnwritable
from s2ag.core.motion import handshape, skeleton
from s2ag.core.motion.motion import Motion
from s2ag.rigs import bvh

JOINTS = {  # where each edge starts and ends in the file
    "torso": ("Spine", "Neck"),
    "neck": ("Neck", "Head"),
    "head": ("Head", "Head End"),
    **{
        f"{side.lower()}_{part}": (side + start, side + end)
        for side in ("Left", "Right")
        for part, start, end in (
            ("clavicle", "Shoulder", "Arm"),
            ("upper_arm", "Arm", "ForeArm"),
            ("forearm", "ForeArm", "Hand"),
        )
    },
}


def parse(path):
    """Joints ``{name: (parent, offset, channels)}`` in file order, motion (frames, channels) and seconds a frame."""
    words = path.read_text().split()
    joints, stack, at = {}, [], 0
    while words[at] != "MOTION":
        word = words[at]
        if word in ("ROOT", "JOINT", "End"):
            name = words[at + 1] if word != "End" else f"{stack[-1]} End"
            joints[name] = [stack[-1] if stack else None, None, []]
            at += 2
        elif word == "{":
            stack.append(name)
            at += 1
        elif word == "}":
            stack.pop()
            at += 1
        elif word == "OFFSET":
            joints[stack[-1]][1] = np.array(words[at + 1 : at + 4], float)
            at += 4
        elif word == "CHANNELS":
            count = int(words[at + 1])
            joints[stack[-1]][2] = words[at + 2 : at + 2 + count]
            at += 2 + count
        else:
            at += 1
    frames = int(words[at + 2])
    seconds = float(words[at + 5])
    return joints, np.array(words[at + 6 :], float).reshape(frames, -1), seconds


def rotation(axis, degrees):
    i, j = {"X": (1, 2), "Y": (2, 0), "Z": (0, 1)}[axis]
    matrix = np.tile(np.eye(3), (len(degrees), 1, 1))
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix[:, i, i], matrix[:, i, j], matrix[:, j, i], matrix[:, j, j] = cosine, -sine, sine, cosine
    return matrix


def positions(joints, motion):
    """World positions ``{joint: (frames, 3)}`` by the channels as they are listed."""
    place, turn, column = {}, {}, 0
    for name, (parent, offset, channels) in joints.items():
        here, local = np.tile(offset, (len(motion), 1)), np.tile(np.eye(3), (len(motion), 1, 1))
        for channel in channels:
            value = motion[:, column]
            column += 1
            if channel.endswith("position"):
                here[:, "XYZ".index(channel[0])] = value
            else:
                local = local @ rotation(channel[0], value)
        above = turn.get(parent, np.eye(3))
        place[name] = place.get(parent, 0) + (above @ here[..., None])[..., 0]
        turn[name] = above @ local
    assert column == motion.shape[1]
    return place


@pytest.mark.parametrize("unit", [1.0, 100.0])
def test_every_edge_points_where_the_motion_says(unit, tmp_path):
    motion = Motion(performance(size=1.5), 15.0)
    bvh.save(motion, tmp_path / "take.bvh", unit)
    joints, channels, seconds = parse(tmp_path / "take.bvh")
    assert seconds == pytest.approx(1 / 15, abs=1e-8)
    places = positions(joints, channels)
    for row, edge in enumerate(skeleton.EDGE_NAMES):
        start, end = (places[name] for name in JOINTS[edge])
        assert degrees(end - start, skeleton.canonical_to_y_up(motion.directions[:, row])).max() < 1e-3
        np.testing.assert_allclose(np.linalg.norm(end - start, axis=-1), unit * skeleton.LENGTHS[row], rtol=1e-4)


def test_the_skeleton_is_plain(tmp_path):
    bvh.save(Motion(performance(2)), tmp_path / "take.bvh")
    joints, channels, _ = parse(tmp_path / "take.bvh")
    ends = [name for name in joints if name.endswith(" End")]
    assert ends == ["Head End", "LeftHand End", "RightHand End"]
    assert len(joints) - len(ends) == 12 and channels.shape == (2, 6 + 11 * 3)
    np.testing.assert_allclose(channels[:, :3], [[0, bvh.HIPS_HEIGHT, 0]] * 2)
    assert joints["LeftArm"][1][0] > 0.1 > -0.1 > joints["RightArm"][1][0]
    np.testing.assert_allclose(joints["LeftForeArm"][1], [skeleton.LENGTHS[4], 0, 0], atol=1e-6)


@pytest.mark.parametrize("unit", [1.0, 100.0])
def test_feet_stay_below_a_pelvis_that_moves(unit, tmp_path):
    motion = Motion(performance(60), pelvis=handed.pelvis(60))
    bvh.save(motion, tmp_path / "take.bvh", unit)
    joints, channels, _ = parse(tmp_path / "take.bvh")
    places = positions(joints, channels)
    for side in ("Left", "Right"):
        for foot in (f"{side}Foot", f"{side}Foot End"):
            assert np.abs(places[foot] - places[foot][:1]).max() < 1e-4 * unit
        hip, knee, ankle = (places[side + name] for name in ("UpLeg", "Leg", "Foot"))
        assert ((knee - 0.5 * (hip + ankle))[:, 2] > 0).all()
    tall = 0.85 * unit
    np.testing.assert_allclose(np.ptp(places["Hips"][:, 0]), np.ptp(motion.pelvis.place[:, 0]) * tall, rtol=0.1)
    for row, edge in enumerate(skeleton.EDGE_NAMES):
        start, end = (places[name] for name in JOINTS[edge])
        assert degrees(end - start, skeleton.canonical_to_y_up(motion.directions[:, row])).max() < 1e-3


@pytest.mark.parametrize("unit", [1.0, 100.0])
def test_hands_and_fingers_do_what_the_motion_says(unit, tmp_path):
    motion = Motion(performance(60), hands=handed.hands(performance(60)))
    bvh.save(motion, tmp_path / "take.bvh", unit)
    joints, channels, _ = parse(tmp_path / "take.bvh")
    places = positions(joints, channels)
    knuckles, palms = (skeleton.canonical_to_y_up(part) for part in (motion.hands.knuckles, motion.hands.palms))
    for side, name in enumerate(("LeftHand", "RightHand")):
        row = [places[f"{name}{finger}1"] - places[name] for finger in ("Index", "Middle", "Ring", "Pinky")]
        assert degrees(np.mean(row, axis=0), knuckles[:, side]).max() < 1
        across = np.cross(row[0] - row[3], knuckles[:, side]) * (1 if side else -1)
        assert degrees(across, palms[:, side]).max() < 5  # knuckles lie on an arc
        for finger, column in (("Index", "index"), ("Middle", "middle"), ("Ring", "ring"), ("Pinky", "little")):
            first, _, last = (
                places[f"{name}{finger}{end}"] - places[f"{name}{finger}{start}"]
                for start, end in (("1", "2"), ("2", "3"), ("3", "3 End"))
            )
            bend = handshape.column(motion.hands.shape, f"{column}_rest")[:, side]
            assert np.abs(degrees(last, first) - np.abs(bend)).max() < 2


def test_angles_do_not_jump(tmp_path):
    slow = Motion(performance(40, size=0.5), 15.0).resampled(240.0)
    bvh.save(slow, tmp_path / "take.bvh")
    _, channels, seconds = parse(tmp_path / "take.bvh")
    assert seconds == pytest.approx(1 / 240, abs=1e-8)
    assert np.abs(np.diff(channels, axis=0)).max() < 15


def test_one_frame(tmp_path):
    bvh.save(Motion(performance(1)), tmp_path / "take.bvh")
    assert parse(tmp_path / "take.bvh")[1].shape == (1, 39)


def test_a_missing_folder_is_told(tmp_path):
    with pytest.raises(OutputUnwritable):
        bvh.save(Motion(performance(1)), tmp_path / "none" / "take.bvh")
