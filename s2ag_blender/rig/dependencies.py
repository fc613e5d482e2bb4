"""What a rig's bones depend on: constraints, drivers, and other objects."""

import re
from collections.abc import Iterator, Sequence

import bpy

_BONE = re.compile(r'bones\["((?:[^"\\]|\\.)*)"\]')
_IK = ("IK", "SPLINE_IK")


def bone_of(path: str) -> str:
    """The bone that a data path such as ``pose.bones["Arm"].location`` leads through, or ""."""
    found = _BONE.search(path or "")
    return bpy.utils.unescape_identifier(found[1]) if found else ""


def drivers(datablock: bpy.types.ID) -> list[bpy.types.FCurve]:
    """The driver curves of a data-block."""
    animation = getattr(datablock, "animation_data", None)
    return list(animation.drivers) if animation is not None else []


def chain(bone: bpy.types.PoseBone, constraint: bpy.types.Constraint) -> Iterator[bpy.types.PoseBone]:
    """The bones that an inverse kinematics constraint on ``bone`` turns."""
    link = bone if getattr(constraint, "use_tail", True) else bone.parent
    count = constraint.chain_count
    while link is not None:
        yield link
        link, count = link.parent, count - 1
        if count == 0:
            return


def pulled(armature: bpy.types.Object) -> dict[str, list[tuple[bpy.types.PoseBone, bpy.types.Constraint]]]:
    """``{bone: [(bone with an inverse kinematics constraint, the constraint)]}`` of the bones that such constraints turn."""
    result = {}
    for bone in armature.pose.bones:
        for constraint in bone.constraints:
            if constraint.type in _IK:
                for link in chain(bone, constraint):
                    result.setdefault(link.name, []).append((bone, constraint))
    return result


def needed(armature: bpy.types.Object, bones: Sequence[str]) -> set[str]:
    """The bones that decide where ``bones`` are."""
    pose, puller, driven = armature.pose.bones, pulled(armature), {}
    for curve in drivers(armature):
        driven.setdefault(bone_of(curve.data_path), []).append(curve)
    found, waiting = set(), [*bones, *(_driver_bones(driven.get("", ())))]
    while waiting:
        name = waiting.pop()
        if name in found or name not in pose:
            continue
        found.add(name)
        bone = pose[name]
        waiting += [bone.parent.name] if bone.parent else []
        waiting += [other.name for other, _ in puller.get(name, ())]
        waiting += [subtarget for constraint in bone.constraints for _, subtarget in _targets(constraint)]
        waiting += _driver_bones(driven.get(name, ()))
    return found


def trim(armature: bpy.types.Object, bones: Sequence[str]) -> None:
    """Strip a private rig of the constraints and drivers that have no part in where ``bones`` are."""
    if any(curve.driver.use_self or "bpy" in curve.driver.expression for curve in drivers(armature)):
        return  # such a driver may read anything
    kept = needed(armature, bones)
    curves = armature.animation_data.drivers if armature.animation_data else ()
    for index in reversed(range(len(curves))):
        bone = bone_of(curves[index].data_path)
        if bone and bone not in kept:
            curves.remove(curves[index])
    for bone in armature.pose.bones:
        if bone.name not in kept:
            for constraint in list(bone.constraints):
                bone.constraints.remove(constraint)
            armature.data.bones[bone.name].bbone_segments = 1
    if not any(_bends(constraint) for name in kept for constraint in armature.pose.bones[name].constraints):
        armature.data.animation_data_clear()


def between(copy: bpy.types.Object, armature: bpy.types.Object) -> list[bpy.types.Object]:
    """The objects that ``copy``, a copy of ``armature``, depends on and that depend on ``armature`` in turn."""
    return [item for item in reached(copy) if item not in (copy, armature) and armature in reached(item)]


def reached(item: bpy.types.Object) -> set[bpy.types.Object]:
    """An object and all that it depends on through constraints, drivers and parents."""
    found, waiting = set(), [item]
    while waiting:
        if (one := waiting.pop()) not in found:
            found.add(one)
            waiting += _references(one)
    return found


def redirect(item: bpy.types.Object, copies: dict[bpy.types.Object, bpy.types.Object]) -> None:
    """Let a private object refer to the copies of objects instead of the objects."""
    if item.parent in copies:
        inverse = item.matrix_parent_inverse.copy()
        item.parent = copies[item.parent]
        item.matrix_parent_inverse = inverse
    for holder, name, target in list(_target_slots(item)):
        if target in copies:
            setattr(holder, name, copies[target])


def set_value(item: bpy.types.Object, path: str, value: float | list[float]) -> None:
    """Set the number or numbers at a data path of an object. Raises :class:`ValueError` where there are none."""
    former = item.path_resolve(path)
    several = hasattr(former, "__len__") and not isinstance(former, str)
    if several != isinstance(value, list) or not (several or isinstance(former, (bool, int, float))):
        raise ValueError(f"{path} holds something else")
    if not all(isinstance(one, (bool, int, float)) for one in (value if several else [value])):
        raise ValueError(f"{path} takes numbers")
    value = value if several else type(former)(value)
    if path.endswith('"]'):
        owner, _, key = path[:-2].rpartition('["')
        item.path_resolve(owner)[bpy.utils.unescape_identifier(key)] = value
    else:
        owner, _, name = path.rpartition(".")
        setattr(item.path_resolve(owner), name, value)


def moves_by_itself(depsgraph: bpy.types.Depsgraph, item: bpy.types.Object) -> bool:
    """Whether anything that ``item``, which has no action itself, depends on changes with time."""
    if any(isinstance(found.original, bpy.types.Action) for found in depsgraph.ids):
        return True
    return any("frame" in curve.driver.expression for other in reached(item) for curve in drivers(other))


def _bends(constraint) -> bool:
    return constraint.type == "ARMATURE" or getattr(constraint, "use_bbone_shape", False)


def _driver_bones(curves) -> list[str]:
    targets = [target for curve in curves for variable in curve.driver.variables for target in variable.targets]
    return [name for target in targets for name in (target.bone_target, bone_of(target.data_path)) if name]


def _targets(constraint) -> list[tuple[bpy.types.Object | None, str]]:
    """Objects and bones that a constraint looks at."""
    if constraint.type == "ARMATURE":
        return [(target.target, target.subtarget) for target in constraint.targets]
    pairs = (("target", "subtarget"), ("pole_target", "pole_subtarget"))
    return [(getattr(constraint, a), getattr(constraint, b, "")) for a, b in pairs if getattr(constraint, a, None)]


def _target_slots(item) -> Iterator[tuple[object, str, bpy.types.ID]]:
    """Every place where the constraints and drivers of an object name another: its holder, property and value."""
    owners = [item, *(item.pose.bones if item.pose else ())]
    for constraint in (constraint for owner in owners for constraint in owner.constraints):
        holders = constraint.targets if constraint.type == "ARMATURE" else [constraint]
        for holder in holders:
            for name in ("target", "pole_target"):
                if getattr(holder, name, None) is not None:
                    yield holder, name, getattr(holder, name)
    for curve in drivers(item) + drivers(item.data):
        for variable in curve.driver.variables:
            for target in variable.targets:
                if target.id is not None:
                    yield target, "id", target.id


def _references(item) -> list[bpy.types.Object]:
    found = [target for _, _, target in _target_slots(item) if isinstance(target, bpy.types.Object)]
    return found + ([item.parent] if item.parent else [])
