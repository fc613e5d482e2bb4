"""Marks words on the timeline: one marker per word, recognised by the prefix of its name."""

from collections.abc import Iterable

import bpy

from ..keys.apply import scene_fps


def add(
    scene: bpy.types.Scene, words: Iterable[tuple[str, float, float]], start: float, prefix: str, first: int,
    last: int | None = None
) -> int:  # fmt: skip
    """Mark the words ``(word, start, end)`` (seconds) of a recording that begins at frame ``start``; return their number.

    Only frames from ``first`` to ``last`` are marked. Markers with this prefix in that range are replaced."""
    rate = scene_fps(scene)
    placed = [(word, round(start + begin * rate)) for word, begin, _ in words]
    placed = [(word, frame) for word, frame in placed if frame >= first and (last is None or frame <= last)]
    if not placed:
        return 0
    remove(scene, prefix, first, max(frame for _, frame in placed) if last is None else last)
    for word, frame in placed:
        scene.timeline_markers.new(f"{prefix}{word}", frame=frame).select = False
    return len(placed)


def ours(scene: bpy.types.Scene, prefix: str) -> list[bpy.types.TimelineMarker]:
    """Return the markers whose names start with ``prefix``; none for an empty prefix."""
    return [marker for marker in scene.timeline_markers if prefix and marker.name.startswith(prefix)]


def remove(scene: bpy.types.Scene, prefix: str, first: int | None = None, last: int | None = None) -> int:
    """Remove the markers with this prefix, between the given frames if any; return their number."""
    matches = [
        marker
        for marker in ours(scene, prefix)
        if (first is None or marker.frame >= first) and (last is None or marker.frame <= last)
    ]
    for marker in matches:
        scene.timeline_markers.remove(marker)
    return len(matches)
