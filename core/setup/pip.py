"""What pip says, for people: the stage it is at, and the one sentence of what went wrong."""

import re
from dataclasses import dataclass, field
from pathlib import Path

_UNITS = {"bytes": 1, "kb": 1e3, "mb": 1e6, "gb": 1e9}
_DOWNLOAD = re.compile(r"\s*(?:Downloading|Processing|Using cached) (?:\S*/)?(\S+?)(?: \(([\d.]+) (bytes|[kMG]B)\))?\s*$")
_INSTALL = re.compile(r"\s*Installing collected packages: (.+)$")

_FAULTS = (
    (
        r"No space left on device|There is not enough space on the disk|Disk quota exceeded|\[Errno 28\]",
        "The disk is full.",
        "Free some space, or name another folder, and set the engine up again.",
    ),
    (
        r"Permission denied|Access is denied|\[Errno 13\]|\[Errno 30\]|Read-only file system",
        "The folder of the engine cannot be written to.",
        "Give yourself the right to write there, or name another folder.",
    ),
    (
        r"CERTIFICATE_VERIFY_FAILED|SSLError",
        "The package registry's certificate is not trusted here.",
        "Ask who runs your network for its certificate and pip's settings, or install from a folder of wheels.",
    ),
    (
        r"ProxyError|407 Proxy|Failed to establish a new connection|Temporary failure in name resolution|"
        r"Max retries exceeded|Name or service not known|getaddrinfo failed|Read timed out|ConnectTimeout|Connection reset|"
        r"NewConnectionError|NameResolutionError",
        "The package registry cannot be reached.",
        "Check the network and its proxy, or install from a folder of wheels.",
    ),
    (
        r"ensurepip|No module named (?:venv|pip)",
        "This Python cannot make environments: it lacks venv or ensurepip.",
        "Install Python 3.11 to 3.13 with both (on Debian: python3-venv), or name another Python for the environment.",
    ),
    (
        r"THESE PACKAGES DO NOT MATCH THE HASHES|BadZipFile|is not a zip file|has an invalid wheel|Wheel .* is invalid",
        "A package file is damaged.",
        "Get it again, and set the engine up again.",
    ),
    (
        r"ResolutionImpossible|conflicting dependencies",
        "The packages that were found do not fit together.",
        "Use a complete and newer folder of wheels; the log names the packages.",
    ),
)
_OWN_INDEX = re.compile(r"download\.pytorch\.org|/whl/cpu\b")
"""What lines are about that tell of PyTorch's own index, not of the registry."""
_ELSEWHERE = {
    "The package registry cannot be reached.": "PyTorch's own package index cannot be reached.",
    "The package registry's certificate is not trusted here.": "The certificate of PyTorch's own package index is not trusted.",
}
_WITHOUT_IT = "Allow its own index, install from a folder of wheels, or take the larger one with --cuda."
_MISSING = re.compile(r"No matching distribution found for (\S+)")


@dataclass
class Listener:
    """Follows pip's lines: ``stage`` for people with its ``names``, ``file`` and ``size`` of what is fetched, ``packages``."""

    stage: str = "Look for packages"
    names: dict = field(default_factory=dict)
    file: str = ""
    size: float = 0.0
    packages: list[str] = field(default_factory=list)

    def hear(self, line: str) -> None:
        """Take in one line."""
        if found := _DOWNLOAD.match(line):
            self.file, number, unit = found.groups()
            self.size = float(number) * _UNITS[unit.lower()] if number else 0.0
            if not self.file.endswith(".metadata"):
                self.stage, self.names = "Fetch {package}", {"package": package(self.file)}
        elif found := _INSTALL.match(line):
            self.stage, self.names, self.file = "Install packages", {}, ""
            self.packages = [name.strip() for name in found.group(1).split(",")]

    def value(self, temporary: Path, installed: Path) -> float:
        """How far the stage is, 0..1, read from what lies in pip's temporary folder and among the installed packages."""
        try:
            if self.packages:
                there = sum(1 for _ in installed.glob("*.dist-info"))
                return min(there / (len(self.packages) + 1), 1.0)  # pip itself lies there too
            if self.size:
                fetched = max((path.stat().st_size for path in temporary.glob(f"pip-*/{self.file}")), default=0)
                return min(fetched / self.size, 1.0)
        except OSError:  # pip moved it away while we looked
            return 0.0
        return 0.0


def package(file: str) -> str:
    """The package and version in the name of a wheel."""
    name, _, rest = Path(file).name.partition("-")
    return f"{name} {rest.split('-')[0]}".strip() if file.endswith(".whl") else file


def explain(lines: list[str], where: str) -> tuple[str, str]:
    """What went wrong and what to do, from the last lines of a failed command; ``where`` is what packages come from."""
    text = "\n".join(lines)
    for pattern, message, remedy in _FAULTS:
        hits = [line for line in lines if re.search(pattern, line)]
        if hits and message in _ELSEWHERE and all(map(_OWN_INDEX.search, hits)):
            return _ELSEWHERE[message], _WITHOUT_IT
        if hits:
            return message, remedy
    if found := _MISSING.search(text):
        name = found.group(1)
        if name.endswith("+cpu"):
            return (
                "PyTorch without CUDA cannot be had here, and nothing larger was fetched.",
                _WITHOUT_IT,
            )
        return (
            f"There is no {name} for this Python and this system in {where}.",
            "Name another Python for the environment, or complete the folder of wheels.",
        )
    said = [line.removeprefix("ERROR:").strip() for line in lines if line.startswith("ERROR:")] or lines[-1:]
    return (f"Setting up the engine failed: {said[-1].strip() if said else 'no reason was given'}", "The log has the details.")
