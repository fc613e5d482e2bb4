"""Skeletons of people, animals and things, as ``{bone: (head, parent)}``, to be named, dressed up and turned around.

Metres, Blender's frame: z up, facing -y, left at +x. Bones have random axes and rolls, for their heads alone count.
"""

from dataclasses import replace

import numpy as np
from bodies import Body
from s2ag.rigs.family import ARM_PARTS, SIDES, Family
from s2ag.rigs.skeleton import Bones

SIGN = {"left": 1.0, "right": -1.0}
REACH = {
    "T": ((0.285, 0.0, 0.0), (0.56, -0.01, 0.0)),
    "A": ((0.20, 0.01, -0.20), (0.38, -0.04, -0.40)),
    "I": ((0.03, 0.01, -0.285), (0.06, -0.05, -0.55)),
}
"""From the left shoulder to elbow and wrist, in T pose, A pose and with hanging arms."""
SHOULDER = np.array((0.185, 0.02, 1.44))
FINGERS = {"thumb": (-0.03, 0.02, 0.6), "index": (-0.03, 0.09, 1.0), "middle": (-0.01, 0.095, 1.1), "little": (0.03, 0.08, 0.8)}
"""Sideways, along the hand and length of each finger."""


def between(start, end, count: int) -> list[np.ndarray]:
    """``count`` points from ``start`` towards ``end``, evenly, without the end."""
    return [start + (np.asarray(end) - start) * step / count for step in range(count)]


def arm_joints(side: str, pose: str) -> dict[str, np.ndarray]:
    """Where the parts of an arm start; ``tip`` is where the palm ends."""
    shoulder = SHOULDER * (SIGN[side], 1, 1)
    elbow, wrist = (shoulder + np.array(step) * (SIGN[side], 1, 1) for step in REACH[pose])
    palm = wrist + 0.09 * (wrist - elbow) / np.linalg.norm(wrist - elbow)
    collar = np.array((0.03 * SIGN[side], 0.0, 1.43))
    return {"clavicle": collar, "upper_arm": shoulder, "forearm": elbow, "hand": wrist, "tip": palm}


def add_fingers(joints: dict, hand: str, start, end, prefix: str) -> None:
    """Fingers of three bones below ``hand``, whose palm runs from ``start`` to ``end``; thumbs point forwards."""
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array((0, 1.0, 0)) - along[1] * along
    across /= np.linalg.norm(across)
    for finger, (aside, far, size) in FINGERS.items():
        above = hand
        for link in range(3):
            name = f"{prefix}{finger}{link}"
            joints[name] = (start + (far + 0.03 * size * link) * along + aside * across, above)
            above = name


def add_legs(joints: dict, hips: str, name: str = "leg") -> None:
    """Two legs with toes below ``hips``."""
    for side, sign in SIGN.items():
        above = hips
        for link, at in enumerate(((0.09, 0.0, 0.93), (0.10, -0.01, 0.5), (0.10, 0.03, 0.09), (0.11, -0.12, 0.02))):
            joints[f"{name}_{side}_{link}"] = (np.array(at) * (sign, 1, 1), above)
            above = f"{name}_{side}_{link}"


def person(family: Family, pose: str = "A", prefix: str = "", legs: bool = True, twists: bool = True) -> Body:
    """A person whose bones have a family's names, with a root below, legs, fingers and eyes of other names.

    Bones of loose parts hang on the root, as the controls of a rig do.
    """
    joints = {"Scene Root": (np.zeros(3), None)}

    def add(names, points, above):
        for name, point in zip(names, points, strict=True):
            joints[prefix + name] = (np.asarray(point, float), above)
            above = prefix + name
        return above

    def start(part, above):
        return "Scene Root" if part in family.loose else above

    chains = family.chains
    hips = above = add([family.hips], [(0, 0.01, 0.98)], "Scene Root") if family.hips else "Scene Root"
    spine = between(np.array((0, 0.0, 1.05)), (0, 0.01, 1.42), max(len(chains["torso"]), 1))
    chest = above = add(chains["torso"], spine[: len(chains["torso"])], start("torso", above))
    for part, low, high in (("neck", 1.46, 1.56), ("head", 1.58, 1.6)):
        points = between(np.array((0, 0.01, low)), (0, -0.01, high), max(len(chains[part]), 1))
        above = add(chains[part], points[: len(chains[part])], start(part, above))
    joints |= {f"eye_{side}": (np.array((0.03 * sign, -0.08, 1.66)), above) for side, sign in SIGN.items()}
    for side in SIDES:
        points, above = arm_joints(side, pose), chest
        for part, end in zip(ARM_PARTS, (*ARM_PARTS[1:], "tip"), strict=True):
            names = chains[f"{side}_{part}"]
            above = add(names, between(points[part], points[end], max(len(names), 1))[: len(names)], start(part, above))
            twist = family.twists.get(f"{side}_{part}_twist", ()) if twists else ()
            for place, name in enumerate(twist, 1):
                at = points[part] + (points[end] - points[part]) * place / (len(twist) + 1)
                joints[prefix + name] = (at, prefix + names[0])
        add_fingers(joints, above, points["hand"], points["tip"], f"finger_{side}_")
    if legs:
        add_legs(joints, hips)
    spelt = {part: tuple(prefix + name for name in names) for part, names in chains.items() if names}
    if twists:
        spelt |= {part: tuple(prefix + name for name in names) for part, names in family.twists.items()}
    return Body(joints, spelt, hips=prefix + family.hips if family.hips else "")


def with_helpers(body: Body) -> Body:
    """The same body with a bone in between above every clavicle, forearm, hand and head."""
    joints = dict(body.joints)
    for part in ("head", *(f"{side}_{name}" for side in SIDES for name in ("clavicle", "forearm", "hand"))):
        for name in body.chains.get(part, ())[:1]:
            at, above = joints[name]
            joints[f"helper of {part}"] = (0.5 * (np.asarray(at) + joints[above][0]), above)
            joints[name] = (at, f"helper of {part}")
    return replace(body, joints=in_order(joints))


def with_extras(body: Body, chest: str, head: str, hips: str) -> Body:
    """The same body with a tail, a skirt, long hair and two tails of it, a cape, breasts, ears and wings with feathers."""
    joints = dict(body.joints)

    def chain(name, above, start, step, count):
        for link in range(count):
            joints[f"{name}{link}"] = (np.array(start) + np.array(step) * link, above)
            above = f"{name}{link}"

    chain("tail", hips, (0, 0.12, 0.95), (0, 0.12, 0.02), 9)
    chain("hair", head, (0, 0.10, 1.72), (0, 0.02, -0.12), 8)
    chain("cape", chest, (0, 0.14, 1.42), (0, 0.02, -0.16), 7)
    chain("crest", head, (0, 0.0, 1.80), (0, 0.0, 0.09), 4)
    chain("jaw", head, (0, -0.03, 1.60), (0, -0.06, -0.03), 2)
    for side, sign in SIGN.items():
        for place, (x, y) in enumerate(((0.06, -0.16), (0.16, 0.0), (0.07, 0.17))):
            chain(f"skirt{side}{place}", hips, (sign * x, y, 0.94), (sign * 0.02, y * 0.1, -0.15), 5)
        chain(f"bunch{side}", head, (sign * 0.12, 0.03, 1.70), (sign * 0.03, 0.02, -0.11), 8)
        chain(f"breast{side}", chest, (sign * 0.08, -0.10, 1.30), (0, -0.06, 0), 2)
        chain(f"ear{side}", head, (sign * 0.05, 0.02, 1.80), (sign * 0.01, 0, 0.10), 3)
        chain(f"wing{side}", chest, (sign * 0.06, 0.16, 1.36), (sign * 0.24, 0.08, 0.06), 4)
        for link in range(1, 4):
            at = joints[f"wing{side}{link}"][0]
            for feather in range(3):
                joints[f"feather{side}{link}{feather}"] = (at + (sign * 0.02 * feather, 0.1, -0.1), f"wing{side}{link}")
    return replace(body, joints=in_order(joints))


def in_order(joints: dict) -> dict:
    """The same joints, parents before children."""
    done: dict = {}

    def add(name):
        if name is not None and name not in done:
            add(joints[name][1])
            done[name] = joints[name]

    for name in joints:
        add(name)
    return done


def renamed(body: Body, seed: int) -> tuple[Body, dict[str, str]]:
    """The same body with names that tell nothing, and what each new name was; the bones in another order."""
    random = np.random.default_rng(seed)
    letters = list("bcdfghjkmnpqstvwxz")
    new = {name: "".join(random.choice(letters, 7)) + str(place) for place, name in enumerate(body.joints)}
    order = [list(body.joints)[place] for place in random.permutation(len(body.joints))]
    joints = in_order({new[name]: (body.joints[name][0], new.get(body.joints[name][1])) for name in order})
    chains = {part: tuple(new[name] for name in chain) for part, chain in body.chains.items()}
    return Body(joints, chains, new.get(body.hips, "")), {here: name for name, here in new.items()}


def placed(body: Body, frame: np.ndarray | None = None, scale: float = 1.0, shift=(0, 0, 0), seed: int = 0) -> Bones:
    """Its bones with random axes and rolls, in another frame, at another size and place."""
    frame = np.eye(3) if frame is None else frame
    joints = {name: (scale * (frame @ np.asarray(at, float)) + shift, above) for name, (at, above) in body.joints.items()}
    bones = Body(joints, body.chains, body.hips).bones(seed)
    return replace(bones, lengths=np.full(len(bones.names), 0.05 * scale))


def quadruped(names: dict | None = None) -> Body:
    """A dog, with the names of a person's bones where ``names`` gives them."""
    joints = {"root": (np.zeros(3), None), "hips": (np.array((0, 0.4, 0.6)), "root")}
    above = "hips"
    for link in range(4):
        joints[f"spine{link}"] = (np.array((0, 0.25 - 0.2 * link, 0.63)), above)
        above = f"spine{link}"
    joints["neck"] = (np.array((0, -0.45, 0.68)), above)
    joints["head"] = (np.array((0, -0.6, 0.85)), "neck")
    for link in range(5):
        joints[f"tail{link}"] = (np.array((0, 0.5 + 0.1 * link, 0.62)), f"tail{link - 1}" if link else "hips")
    for side, sign in SIGN.items():
        front = {"shoulder": (0.05, -0.32, 0.64), "arm": (0.09, -0.42, 0.48), "fore": (0.09, -0.36, 0.28)}
        front["paw"] = (0.09, -0.36, 0.05)
        hind = {"thigh": (0.09, 0.38, 0.56), "shin": (0.1, 0.33, 0.34), "hock": (0.1, 0.47, 0.18), "foot": (0.1, 0.43, 0.05)}
        for first, limb in ((above, front), ("hips", hind)):
            for name, at in limb.items():
                joints[f"{name}_{side}"] = (np.array(at) * (sign, 1, 1), first)
                first = f"{name}_{side}"
            joints[f"{first}_toe"] = (joints[first][0] + (0, -0.08, -0.03), first)
    new = {name: (names or {}).get(name, name) for name in joints}
    joints = {new[name]: (at, new.get(above)) for name, (at, above) in joints.items()}
    return Body(joints, {})


def snake(count: int = 40) -> Body:
    """A chain on the ground."""
    joints, above = {}, None
    for link in range(count):
        joints[f"link{link}"] = (np.array((0.05 * np.sin(link / 3), 0.06 * link, 0.05)), above)
        above = f"link{link}"
    return Body(joints, {})


def hand(below: str = "") -> Body:
    """A hand with its forearm."""
    points = arm_joints("left", "T")
    joints = {"arm": (points["upper_arm"], None), "fore": (points["forearm"], "arm"), "hand": (points["hand"], "fore")}
    add_fingers(joints, "hand", points["hand"], points["tip"], below)
    return Body(joints, {})


def spider() -> Body:
    """Four pairs of legs on one body."""
    joints = {
        "root": (np.zeros(3), None),
        "body": (np.array((0, 0, 0.3)), "root"),
        "abdomen": (np.array((0, 0.3, 0.3)), "body"),
    }
    joints["head"] = (np.array((0, -0.2, 0.32)), "body")
    for side, sign in SIGN.items():
        for pair in range(4):
            above = "body"
            for link, (out, high) in enumerate(((0.08, 0.3), (0.3, 0.5), (0.6, 0.35), (0.8, 0.0))):
                name = f"leg{pair}_{side}_{link}"
                joints[name] = (np.array((sign * out, (pair - 1.5) * (0.06 + 0.1 * link), high)), above)
                above = name
    return Body(joints, {})


def without(body: Body, *words: str) -> Body:
    """The body without the bones that have one of ``words`` in their names, and without what hangs on them."""
    joints = {}
    for name, (at, above) in body.joints.items():
        if not any(word in name for word in words) and (above is None or above in joints):
            joints[name] = (at, above)
    chains = {part: kept for part, chain in body.chains.items() if (kept := tuple(name for name in chain if name in joints))}
    return replace(body, joints=joints, chains=chains)
