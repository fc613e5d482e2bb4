"""One row of a manifest: what is spoken, who performs it how, and which files are wanted."""

import re
import unicodedata
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

from ..errors import UsageError

MOTION_OUTPUTS = ("npz", "bvh", "json", "dataset")
"""Made from the motion alone, without Blender."""
CHARACTER_OUTPUTS = {"rig-bvh": ".bvh", "fbx": ".fbx", "glb": ".glb", "usd": ".usd"}
"""One file for every character of a scene."""
SCENE_OUTPUTS = {"mp4": ".mp4", "png": ".png", "blend": ".blend", "frames": ".png", "exr": ".exr"}
"""One file, or one folder of numbered images, for the whole scene."""
SEQUENCES = ("frames", "exr")
OUTPUTS = (*MOTION_OUTPUTS, *CHARACTER_OUTPUTS, *SCENE_OUTPUTS)
ASKED = (
    *("text", "recognise", "style", "seed", "take", "takes", "intensity"),
    *("affect", "rate", "hand", "hands", "stance", "meaning", "mirror", "latent"),
    *("face", "face_smoothness"),
    *("listen", "turn", "hears", "later", "toward"),
)
"""What of a row is a field of :class:`synthesis.Request`, beside the files."""
MODELS = ("checkpoint", "vectors", "aligner_model", "recogniser_model", "language", "vocabulary", "backend", "device")
"""What of a row is an argument of :class:`synthesis.Session`: paths, the code of a language, what computes."""


@dataclass(frozen=True)
class Preset:
    """How pictures are made: ``engine``, ``resolution`` in pixels, ``samples`` of the engine, background or none."""

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
class Clip:
    """A row; ``line`` is where it stands in its manifest, ``name`` that of its files, paths are absolute.

    Words come from ``transcript``, ``text`` or ``recognise``, or are none (``no_transcript``). ``checkpoint``,
    ``vectors``, ``aligner_model``, ``recogniser_model`` and ``vocabulary`` are paths, or None for the shipped ones;
    ``hears`` is the recording of another speaker, ``rhubarb`` mouth cues, ``edits`` what an animator changed, ``curves`` what
    goes on in time; ``language`` is a code such as ``de``; ``latent`` is the point of the latent space of a chosen cell;
    ``take`` is the number of the first take; ``stance`` None is 1 on a character of ours and 0 on others. ``scene`` names what
    several rows are rendered into together, each with its own recording, which begins ``delay`` seconds into the film, whose
    first frame is ``start_frame``. ``engine``, ``resolution`` and ``fps`` override the preset; without any of them a
    ``.blend`` keeps its own.
    """

    line: int
    name: str
    audio: str
    transcript: str | None = None
    text: str | None = None
    recognise: bool = False
    no_transcript: bool = False
    style: str = ""
    seed: int = 0
    take: int = 0
    takes: int = 1
    intensity: float = 1.0
    affect: dict[str, float] = field(default_factory=dict)
    rate: float = 0.0
    hand: float = 0.0
    meaning: float = 1.0
    hands: float = 1.0
    stance: float | None = None
    face: float = 0.0
    face_smoothness: float = 0.5
    mirror: bool = False
    latent: list[list[float]] | None = None
    listen: bool = False
    turn: str = ""
    hears: str | None = None
    later: float = 0.0
    toward: float = 0.0
    rhubarb: str | None = None
    edits: str | None = None
    curves: str | None = None
    checkpoint: str | None = None
    vectors: str | None = None
    aligner_model: str | None = None
    recogniser_model: str | None = None
    language: str | None = None
    vocabulary: str | None = None
    backend: str | None = None
    device: str = "cpu"
    outputs: tuple[str, ...] = ("bvh",)
    character: str = "mannequin"
    gender: str = "female"
    armature: str | None = None
    map: str | None = None
    face_map: str | None = None
    scene: str = ""
    delay: float = 0.0
    preset: str | None = None
    engine: str | None = None
    resolution: tuple[int, int] | None = None
    fps: float | None = None
    start_frame: int = 1

    def wanted(self, kinds) -> tuple[str, ...]:
        """Those of the outputs that are of these ``kinds``."""
        return tuple(kind for kind in self.outputs if kind in kinds)

    @property
    def is_filmed(self) -> bool:
        """Whether anything of this clip needs Blender."""
        return bool(self.wanted((*CHARACTER_OUTPUTS, *SCENE_OUTPUTS)))

    def take_name(self, take: int) -> str:
        """``NAME`` of a single take, else ``NAME-1``, ``NAME-2`` ..., as wide as the last number so that names sort."""
        return take_name(self.name, take, self.takes)

    @property
    def look(self) -> Preset | None:
        """How pictures of it are made; None for the settings of its ``.blend``."""
        own = Path(self.character).suffix.lower() == ".blend"
        return PRESETS[self.preset] if self.preset else None if own else PRESETS["preview"]

    def plain(self) -> dict:
        """The row as JSON."""
        return asdict(self)

    @classmethod
    def of(cls, plain: dict) -> "Clip":
        """What :meth:`plain` gave."""
        pairs = {name: tuple(plain[name]) for name in ("outputs", "resolution") if plain.get(name)}
        return replace(cls(**plain), **pairs)


@dataclass(frozen=True)
class Unit:
    """What stages work on: clips that share a scene, or one clip; ``number`` counts them from 1 in the manifest's order."""

    number: int
    name: str
    clips: tuple[Clip, ...]

    @property
    def takes(self) -> int:
        """How many times it is performed."""
        return self.clips[0].takes

    @property
    def is_filmed(self) -> bool:
        """Whether Blender has anything to do."""
        return any(clip.is_filmed for clip in self.clips)

    @property
    def scene_outputs(self) -> tuple[str, ...]:
        """What is made of the scene as a whole, by any of its rows."""
        return tuple(kind for kind in SCENE_OUTPUTS if any(kind in clip.outputs for clip in self.clips))

    def take_name(self, take: int) -> str:
        """As :meth:`Clip.take_name`."""
        return take_name(self.name, take, self.takes)


def units(clips: list[Clip]) -> list[Unit]:
    """The clips grouped by scene, in the order of their first row."""
    groups: dict[str | int, list[Clip]] = {}
    for clip in clips:
        groups.setdefault(clip.scene or clip.line, []).append(clip)
    found = enumerate(groups.values(), 1)
    return [Unit(number, group[0].scene or group[0].name, tuple(group)) for number, group in found]


def sliced(every: list[Unit], part: str | None = None, numbers: str | None = None) -> list[Unit]:
    """The units of one slice: ``part`` is ``K/N``, ``numbers`` are like ``1-8`` or ``1,3,5-7``. Raises :class:`UsageError`."""
    if part:
        found = re.fullmatch(r"(\d+)/(\d+)", part.strip())
        k, n = (int(number) for number in found.groups()) if found else (0, 0)
        if not 1 <= k <= n:
            raise UsageError(f"{part!r} is not a slice.", "Write it as 3/10, the third of ten.")
        every = every[len(every) * (k - 1) // n : len(every) * k // n]
    if numbers:
        chosen = ranges(numbers)
        every = [unit for unit in every if any(first <= unit.number <= last for first, last in chosen)]
    return every


def ranges(text: str) -> list[tuple[int, int]]:
    """First and last of every range in ``1,3,5-7``; raises :class:`UsageError`."""
    found = [re.fullmatch(r"\s*(\d+)\s*(?:-\s*(\d+)\s*)?", part) for part in text.split(",")]
    if not all(found):
        raise UsageError(f"{text!r} are not numbers of clips.", "Write them as 1-8 or 1,3,5-7.")
    return [(int(one[1]), int(one[2] or one[1])) for one in found]


def take_name(name: str, take: int, takes: int) -> str:
    """``NAME`` of a single take, else ``NAME-1`` and so on with as many digits as the last has."""
    return name if takes == 1 else f"{name}-{take + 1:0{len(str(takes))}d}"


def safe_name(text: str) -> str:
    """``text`` as a file name that every system takes: letters, digits, dots, hyphens and underscores, 150 bytes at most."""
    short = unicodedata.normalize("NFC", Path(text).name).encode("utf-8", "ignore")[:150].decode("utf-8", "ignore")
    name = re.sub(r"[^\w.-]+", "_", short).strip("._") or "clip"
    return f"{name}_" if re.fullmatch(r"(con|prn|aux|nul|(com|lpt)[\d¹²³])(\..*)?", name, re.IGNORECASE) else name
