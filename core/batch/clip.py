"""A row of a manifest: recording, character, settings and output files; and the units that stages work on."""

import re
import unicodedata
from collections.abc import Collection
from dataclasses import asdict, dataclass, field, make_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import declaration
from ..declaration import columns
from ..errors import UsageError
from ..settings import Documents, Models, Settings

MOTION_OUTPUTS = ("npz", "bvh", "json", "dataset")
"""Outputs that need the motion alone, without Blender."""
CHARACTER_OUTPUTS = {"rig-bvh": ".bvh", "fbx": ".fbx", "glb": ".glb", "usd": ".usd"}
"""Outputs with one file for every character of a scene."""
SCENE_OUTPUTS = {"mp4": ".mp4", "png": ".png", "blend": ".blend", "frames": ".png", "exr": ".exr"}
"""Outputs with one file, or one folder of numbered images, for the whole scene."""
SEQUENCES = ("frames", "exr")
OUTPUTS = (*MOTION_OUTPUTS, *CHARACTER_OUTPUTS, *SCENE_OUTPUTS)
REQUESTED = tuple(name for name, one in columns(Settings).items() if one.kind != "document")
"""Columns that are passed to a request unchanged."""
MODELS = tuple(columns(Models))
"""Columns that are arguments of :class:`session.Session`."""
SHARED = ("takes", "preset", "engine", "resolution", "fps", "start_frame")
"""Columns on which rows of one scene must agree."""
MOST_TAKES = int(columns(Settings)["takes"].high or 1)


def _row_of(*classes: type) -> type:
    """Return a dataclass whose fields are the :func:`columns` of classes, with the values of empty cells as defaults.

    The values of documents are their paths."""
    rows = []
    for name, one in columns(*classes).items():
        start = one.usually if one.empty is declaration.SAME else one.empty
        start = None if one.kind == "document" else start
        rows.append((name, Any, field(default_factory=dict) if isinstance(start, dict) else field(default=start)))
    return make_dataclass("Row", rows, frozen=True, kw_only=True)


if TYPE_CHECKING:

    class _Row(Documents, Settings, Models):
        curves: Any  # the path of a document
        meanings: Any  # the same
else:
    _Row = _row_of(Settings, Documents, Models)


@dataclass(frozen=True)
class Preset:
    """Settings of the renderer: ``engine``, ``resolution`` in pixels, ``samples``, and whether there is no background."""

    engine: str
    resolution: tuple[int, int]
    samples: int | None = None
    transparent: bool = False


PRESETS = {
    "preview": Preset("workbench", (640, 360)),
    "hd": Preset("eevee", (1920, 1080), 32),
    "film": Preset("cycles", (1920, 1080), 64),
    "transparent": Preset("eevee", (1920, 1080), 32, transparent=True),
    "exr": Preset("cycles", (1920, 1080), 64, transparent=True),
}


@dataclass(frozen=True)
class Clip(_Row):
    """A row; ``line`` is its line in the manifest, ``name`` the stem of its files. Paths are absolute.

    Words come from ``transcript``, ``text`` or ``recognise``, or there are none (``no_transcript``). The settings are those of
    :class:`settings.Settings`, :class:`settings.Models` and :class:`settings.Documents` that are columns; ``curves`` and
    ``meanings`` are paths of documents; a setting whose default depends on the character is None where the row leaves it
    empty. Rows with the same ``scene`` are rendered together, each with its own recording, which begins ``delay`` seconds
    into the film, whose first frame is ``start_frame``. ``engine``, ``resolution`` and ``fps`` override the preset; without
    any of them a ``.blend`` file keeps its own.
    """

    line: int
    name: str
    audio: str
    no_transcript: bool = False
    outputs: tuple[str, ...] = ("bvh",)
    character: str = "mannequin"
    gender: str = "female"
    armature: str | None = None
    map: str | None = None
    face_map: str | None = None
    seated: str = "auto"
    scene: str = ""
    delay: float = 0.0
    preset: str | None = None
    engine: str | None = None
    resolution: tuple[int, int] | None = None
    fps: float | None = None
    start_frame: int = 1

    def wanted(self, kinds: Collection[str]) -> tuple[str, ...]:
        """Return the outputs that are among ``kinds``."""
        return tuple(kind for kind in self.outputs if kind in kinds)

    @property
    def is_filmed(self) -> bool:
        """Whether any output needs Blender."""
        return bool(self.wanted((*CHARACTER_OUTPUTS, *SCENE_OUTPUTS)))

    @property
    def numbers(self) -> range:
        """The numbers of all takes, from 0; none where the row asks for a number that is out of range."""
        return range(self.takes if 1 <= self.takes <= MOST_TAKES else 0)

    def take_name(self, take: int) -> str:
        """Return ``NAME`` for a single take, else ``NAME-1``, ``NAME-2`` ..., padded with zeros so that names sort."""
        return take_name(self.name, take, self.takes)

    @property
    def take_names(self) -> list[str]:
        """The names of all takes."""
        return [self.take_name(take) for take in self.numbers]

    @property
    def look(self) -> Preset | None:
        """Settings of the renderer; None for those of its ``.blend`` file."""
        is_blend = Path(self.character).suffix.lower() == ".blend"
        return PRESETS[self.preset] if self.preset else None if is_blend else PRESETS["preview"]

    def plain(self) -> dict:
        """Return the row as JSON."""
        return asdict(self)

    @classmethod
    def of(cls, plain: dict) -> "Clip":
        """Return the clip that :meth:`plain` returned as JSON."""
        pairs = {name: tuple(plain[name]) for name in ("outputs", "resolution") if plain.get(name)}
        return replace(cls(**plain), **pairs)


@dataclass(frozen=True)
class Unit:
    """A unit of work of a stage: clips that share a scene, or one clip; ``number`` counts from 1 in the manifest's order."""

    number: int
    name: str
    clips: tuple[Clip, ...]

    @property
    def numbers(self) -> range:
        """The numbers of all takes, from 0."""
        return self.clips[0].numbers

    @property
    def is_filmed(self) -> bool:
        """Whether any output needs Blender."""
        return any(clip.is_filmed for clip in self.clips)

    @property
    def scene_outputs(self) -> tuple[str, ...]:
        """Outputs of the whole scene that any of its rows requests."""
        return tuple(kind for kind in SCENE_OUTPUTS if any(kind in clip.outputs for clip in self.clips))

    def take_name(self, take: int) -> str:
        """Return what :meth:`Clip.take_name` returns, for the unit."""
        return take_name(self.name, take, len(self.numbers))


def units(clips: list[Clip]) -> list[Unit]:
    """Group clips by scene, in the order of their first row."""
    groups: dict[str | int, list[Clip]] = {}
    for clip in clips:
        groups.setdefault(clip.scene or clip.line, []).append(clip)
    numbered = enumerate(groups.values(), 1)
    return [Unit(number, group[0].scene or group[0].name, tuple(group)) for number, group in numbered]


def select_units(every: list[Unit], part: str | None = None, numbers: str | None = None) -> list[Unit]:
    """Return the units of a slice: ``part`` is ``K/N``, ``numbers`` is like ``1-8`` or ``1,3,5-7``.

    Raises :class:`UsageError`.
    """
    if part:
        match = re.fullmatch(r"(\d+)/(\d+)", part.strip())
        k, n = (int(number) for number in match.groups()) if match else (0, 0)
        if not 1 <= k <= n:
            raise UsageError(f"{part!r} is not a slice.", "Write it as 3/10, the third of ten.")
        every = every[len(every) * (k - 1) // n : len(every) * k // n]
    if numbers:
        limits = parse_ranges(numbers)
        every = [unit for unit in every if any(first <= unit.number <= last for first, last in limits)]
    return every


def parse_ranges(text: str) -> list[tuple[int, int]]:
    """Return the first and last number of every range in a text like ``1,3,5-7``; raises :class:`UsageError`."""
    limits = []
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d+)\s*(?:-\s*(\d+)\s*)?", part)
        if match is None:
            raise UsageError(f"{text!r} are not numbers of clips.", "Write them as 1-8 or 1,3,5-7.")
        limits.append((int(match[1]), int(match[2] or match[1])))
    return limits


def take_name(name: str, take: int, takes: int) -> str:
    """Return ``NAME`` for a single take, else ``NAME-1`` and so on, with as many digits as the last number has."""
    return name if takes == 1 else f"{name}-{take + 1:0{len(str(takes))}d}"


def safe_name(text: str) -> str:
    """Return ``text`` as a portable file name: letters, digits, dots, hyphens and underscores, 150 bytes at most."""
    short = unicodedata.normalize("NFC", Path(text).name).encode("utf-8", "ignore")[:150].decode("utf-8", "ignore")
    name = re.sub(r"[^\w.-]+", "_", short).strip("._") or "clip"
    return re.sub(r"^(con|prn|aux|nul|(com|lpt)[\d¹²³])(?=\.|$)", r"\1_", name, flags=re.IGNORECASE)  # devices of Windows
