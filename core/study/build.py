"""Writes a study as a folder: a static web page, and a separate key that maps clips to conditions."""

import json
import shutil
import tempfile
from os import PathLike
from pathlib import Path

from ..errors import OutputUnwritable
from .design import Design

PAGE = Path(__file__).parent / "page"
QUESTIONS = (
    {
        "id": "plausibility",
        "text": "How plausible do the gestures look?",
        "low": "very unnatural",
        "high": "look like they could be from a real person",
    },
    {
        "id": "synchrony",
        "text": "How well are the gestures synchronized with the speech?",
        "low": "no or arbitrary gestures",
        "high": "well-synchronized with the speech, and appropriately emotionally expressive",
    },
)
"""The paper's two questions with the ends of their five-point scales (section 5.5)."""
FORMS = ("rating", "pairs", "matched")
_SPEECH = {"id": "appropriateness", "text": "In which clip do the gestures fit the speech better?"}
PAIRED = {
    "pairs": ({"id": "realism", "text": "In which clip does the figure move more like a real person?"}, _SPEECH),
    "matched": (_SPEECH,),
}
"""Questions on two clips, answered from -2 (left, clearly) to 2 (right, clearly), as in the GENEA Challenge 2023."""
INTROS = {
    "rating": "You will see short clips of a figure who speaks and gestures, with sound. After each clip please answer two "
    "questions. There are no right answers. The clips of one speech differ in the gestures alone.",
    "pairs": "You will see two short clips side by side, of a figure who speaks and gestures, with sound. After both please "
    "compare them. There are no right answers. Both clips have the same speech and differ in the gestures alone.",
    "matched": "You will see two short clips side by side, of a figure who gestures, with sound. After both please compare "
    "them. Both clips have the same gestures and differ in the speech alone.",
}


def build(design: Design, out: str | PathLike, title: str, participants: int = 24) -> Path:
    """Write ``out/page`` for participants and ``out/key.json`` for the analysis, completely or not at all; return ``out``.

    The page has the orders of ``participants`` people; further ones start again from the first. Raises
    :class:`OutputUnwritable` for a folder that is not empty.
    """
    out = Path(out)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise OutputUnwritable(f"{out} is not empty.", "Choose another folder: answers belong to one study.")
    try:
        temporary = Path(tempfile.mkdtemp(dir=out.parent, prefix=f".{out.name}."))
    except OSError as error:
        raise OutputUnwritable(f"{out} cannot be made: {error.strerror}.", "Choose another folder.") from error
    try:
        page = temporary / "page"
        shutil.copytree(PAGE, page)
        (page / "clips").mkdir()
        for key, path in design.clips.items():
            shutil.copyfile(path, page / "clips" / design.names[key])
        questions = PAIRED.get(design.form, QUESTIONS)
        facts = {"id": f"{title}-{design.seed}", "form": design.form, "questions": questions}
        content = facts | {"title": title, "intro": INTROS[design.form], "orders": design.orders(participants)}
        # Browsers do not let a page on a disk fetch files, so its data is a script.
        (page / "study-data.js").write_text(f"window.STUDY = {json.dumps(content)};\n", encoding="utf-8")
        clips = {design.names[key]: dict(zip(("condition", "excerpt", "sound"), key, strict=False)) for key in design.clips}
        key = {**facts, "conditions": design.conditions, "excerpts": design.excerpts, "clips": clips}
        (temporary / "key.json").write_text(json.dumps(key, indent=1), encoding="utf-8")
        temporary.chmod(0o755)
        if out.exists():
            out.rmdir()
        temporary.rename(out)
    except OSError as error:
        raise OutputUnwritable(f"{out} cannot be written: {error.strerror}.", "Free space or choose another folder.") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return out
