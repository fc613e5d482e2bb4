"""Finds what a rig's bones depend on: constraints, drivers, and other objects."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, cast

import bpy

from ..datablocks import ArmatureObject

_BONE = re.compile(r'bones\["((?:[^"\\]|\\.)*)"\]')
_IK = ("IK", "SPLINE_IK")


def bone_of(path: str) -> str:
    """Return the name of the bone in a data path such as ``pose.bones["Arm"].location``, or ""."""
    match = _BONE.search(path or "")
    return bpy.utils.unescape_identifier(match[1]) if match else ""


def drivers(datablock: bpy.types.ID | None) -> list[bpy.types.FCurve]:
    """Return the driver F-curves of a datablock."""
    animation = getattr(datablock, "animation_data", None)
    return list(animation.drivers) if animation is not None else []


def chain(bone: bpy.types.PoseBone, constraint: bpy.types.Constraint) -> Iterator[bpy.types.PoseBone]:
    """Yield the bones that an inverse kinematics constraint on ``bone`` turns, the last of the chain first."""
    link = bone if getattr(constraint, "use_tail", True) else bone.parent
    count = cast(bpy.types.KinematicConstraint, constraint).chain_count
    while link is not None:
        yield link
        link, count = link.parent, count - 1
        if count == 0:
            return


def ik_constraints(armature: ArmatureObject) -> dict[str, list[tuple[bpy.types.PoseBone, bpy.types.Constraint]]]:
    """Return ``{bone: [(bone with the constraint, constraint)]}`` of all bones turned by inverse kinematics constraints."""
    result = {}
    for bone in armature.pose.bones:
        for constraint in bone.constraints:
            if constraint.type in _IK:
                for link in chain(bone, constraint):
                    result.setdefault(link.name, []).append((bone, constraint))
    return result


def needed_bones(armature: ArmatureObject, bones: Sequence[str]) -> set[str]:
    """Return the names of ``bones`` and of all bones on which their pose depends."""
    pose, puller, driven = armature.pose.bones, ik_constraints(armature), {}
    for curve in drivers(armature):
        driven.setdefault(bone_of(curve.data_path), []).append(curve)
    names, queue = set(), [*bones, *(_driver_bones(driven.get("", ())))]
    while queue:
        name = queue.pop()
        if name in names or name not in pose:
            continue
        names.add(name)
        bone = pose[name]
        queue += [bone.parent.name] if bone.parent else []
        queue += [owner.name for owner, _ in puller.get(name, ())]
        queue += [subtarget for constraint in bone.constraints for _, subtarget in _targets(constraint)]
        queue += _driver_bones(driven.get(name, ()))
    return names


def trim(armature: ArmatureObject, bones: Sequence[str]) -> None:
    """Remove the constraints and drivers on which ``bones`` do not depend from a private copy of a rig."""
    if any(_driver(curve).use_self or "bpy" in _driver(curve).expression for curve in drivers(armature)):
        return  # such a driver may read anything
    kept = needed_bones(armature, bones)
    curves: Any = armature.animation_data.drivers if armature.animation_data else ()
    for index in reversed(range(len(curves))):
        bone = bone_of(curves[index].data_path)
        if bone and bone not in kept:
            curves.remove(curves[index])
    for bone in armature.pose.bones:
        if bone.name not in kept:
            for constraint in list(bone.constraints):
                bone.constraints.remove(constraint)
            armature.data.bones[bone.name].bbone_segments = 1
    constraints = [one for name in kept for one in armature.pose.bones[name].constraints]
    if not any(one.type == "ARMATURE" or getattr(one, "use_bbone_shape", False) for one in constraints):
        armature.data.animation_data_clear()


def dependencies_of(item: bpy.types.Object) -> set[bpy.types.Object]:
    """Return an object and all objects on which it depends through constraints, drivers and parents."""
    objects, queue = set(), [item]
    while queue:
        if (reference := queue.pop()) not in objects:
            objects.add(reference)
            targets = (target for _, _, target in _target_slots(reference) if isinstance(target, bpy.types.Object))
            queue += [*targets, *([reference.parent] if reference.parent else [])]
    return objects


def retarget_references(item: bpy.types.Object, copies: Mapping[bpy.types.ID, bpy.types.Object]) -> None:
    """Make a private object refer to ``copies`` instead of the original objects."""
    if item.parent is not None and item.parent in copies:
        inverse = item.matrix_parent_inverse.copy()
        item.parent = copies[item.parent]
        item.matrix_parent_inverse = inverse
    for holder, name, target in list(_target_slots(item)):
        if target in copies:
            setattr(holder, name, copies[target])


def set_value(item: bpy.types.Object, path: str, value: float | list[float]) -> None:
    """Set the number or numbers at a data path of an object. Raises :class:`ValueError` if it holds no such numbers."""
    former = item.path_resolve(path)
    is_list = hasattr(former, "__len__") and not isinstance(former, str)
    if is_list != isinstance(value, list) or not (is_list or isinstance(former, (bool, int, float))):
        raise ValueError(f"{path} holds something else")
    if not all(isinstance(number, (bool, int, float)) for number in (value if isinstance(value, list) else [value])):
        raise ValueError(f"{path} takes numbers")
    value = value if isinstance(value, list) else cast(type[float], type(former))(value)
    if path.endswith('"]'):
        owner, _, key = path[:-2].rpartition('["')
        item.path_resolve(owner)[bpy.utils.unescape_identifier(key)] = value
    else:
        owner, _, name = path.rpartition(".")
        setattr(item.path_resolve(owner), name, value)


def moves_by_itself(depsgraph: bpy.types.Depsgraph, item: bpy.types.Object) -> bool:
    """Return whether anything on which ``item``, which has no action itself, depends changes with time."""
    if any(isinstance(datablock.original, bpy.types.Action) for datablock in depsgraph.ids):
        return True
    return any("frame" in _driver(curve).expression for reference in dependencies_of(item) for curve in drivers(reference))


def _driver(curve: bpy.types.FCurve) -> bpy.types.Driver:
    return cast(bpy.types.Driver, curve.driver)


def _driver_bones(curves: Iterable[bpy.types.FCurve]) -> list[str]:
    """Return the names of the bones that the variables of driver F-curves read."""
    targets = [target for curve in curves for variable in _driver(curve).variables for target in variable.targets]
    return [name for target in targets for name in (target.bone_target, bone_of(target.data_path)) if name]


def _targets(constraint: Any) -> list[tuple[bpy.types.Object | None, str]]:
    """Return the target objects and bones of a constraint, pole targets included."""
    if constraint.type == "ARMATURE":
        return [(target.target, target.subtarget) for target in constraint.targets]
    pairs = (("target", "subtarget"), ("pole_target", "pole_subtarget"))
    return [(getattr(constraint, a), getattr(constraint, b, "")) for a, b in pairs if getattr(constraint, a, None)]


def _target_slots(item: bpy.types.Object) -> Iterator[tuple[object, str, bpy.types.ID]]:
    """Yield ``(holder, property, datablock)`` of each reference in the constraints and drivers of an object."""
    owners = [item, *(item.pose.bones if item.pose else ())]
    for constraint in (constraint for owner in owners for constraint in owner.constraints):
        holders = constraint.targets if constraint.type == "ARMATURE" else [constraint]
        for holder in holders:
            for name in ("target", "pole_target"):
                if getattr(holder, name, None) is not None:
                    yield holder, name, getattr(holder, name)
    for curve in drivers(item) + drivers(item.data):
        for variable in _driver(curve).variables:
            for target in variable.targets:
                if target.id is not None:
                    yield target, "id", target.id
