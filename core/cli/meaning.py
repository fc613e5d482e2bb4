"""``s2ag meaning``: prints what is understood of a text as a document that people and programs can change."""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from ..errors import UsageError
from ..files import atomic_file
from ..meaning import document, gesture_selection, vocabulary
from ..meaning.document import Wanted
from ..settings import Models, Settings, table
from ..words import markup, readers, spelling, transcript
from . import synthesis_options
from .progress import note

SUMMARY = "print which words of a text are shown by which gestures, as a document to change"
EXAMPLE = """examples:
  s2ag meaning talk.txt -o talk.meanings.json
  s2ag meaning talk.txt --meanings talk.meanings.json    is all of it said?
  s2ag synth talk.mp3 --meanings talk.meanings.json -o talk.bvh
  s2ag meaning --schemas"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("text", metavar="TEXT", type=Path, nargs="?", help="what is said, in any form of a transcript")
    parser.add_argument("-o", "--output", metavar="FILE", type=Path, help="file to write instead of printing")
    parser.add_argument("--schemas", action="store_true", help="list the schemas")
    synthesis_options.add_setting(parser, next(one for one in table(Settings).values() if one.kind == "document" and one.label))
    for name in ("language", "vocabulary"):
        synthesis_options.add_setting(parser, table(Models)[name])


def run(options: argparse.Namespace) -> int:
    """Print the document, or check one."""
    known = vocabulary.load_vocabulary(options.vocabulary)
    if options.schemas:
        print(", ".join(known.gestures))
        return 0
    if options.text is None:
        raise UsageError("No text was given.", "Name a transcript.")
    words = said(options.text, options.language)
    found, missed = gesture_selection.find_occasions(known, words, options.language), []
    given = document.of(options)
    for content in given.values():
        found, missed = document.find(content, [text for text, *_ in words], known.gestures)
    text = write([text for text, *_ in words], found)
    if options.output is None:
        print(text, end="")
    else:
        with atomic_file(options.output) as temporary:
            temporary.write_text(text, "utf-8")
    for sentence in missed:
        note(sentence)
    return 1 if missed else 0


def said(path: Path, language: str | None = None) -> list[tuple[str, float, float]]:
    """Return the words of a transcript as they are written, each with times that do not matter."""
    split = spelling.spoken_words if (language or "en").lower().startswith("en") else spelling.split_foreign
    items = readers.parse(transcript.read_text(path), path).items
    texts = [text for item in items for text in ([item.text.strip()] if item.word else markup.parse(item.text, split).written)]
    return [(text, 0.4 * number, 0.4 * number + 0.3) for number, text in enumerate(texts)]


def write(texts: Sequence[str], found: Mapping[int, Wanted]) -> str:
    """Return the JSON of a document, a gesture a line, of what is ``found`` among the words of a talk."""
    lines, start = [], 0
    for bearer, wanted in sorted(found.items()):
        lines.append("  " + json.dumps(_entry(texts, bearer, wanted, start), ensure_ascii=False))
        start = bearer + 1
    listed = "\n" + ",\n".join(lines) + "\n " if lines else ""
    return f'{{\n "format": {document.FORMAT},\n "gestures": [{listed}]\n}}\n'


def _entry(texts: Sequence[str], bearer: int, wanted: Wanted, start: int) -> dict:
    """Return the entry of a gesture, whose words are looked for from the word ``start`` on."""
    first = bearer - wanted.before
    quoted = [" ".join(document.plain(text)) for text in texts[first : first + wanted.count]]
    entry: dict = {"words": " ".join(texts[first : first + wanted.count]).strip('.,;:!?…"“”()–'), "schema": wanted.schema}
    if wanted.before < len(quoted) - 1:
        entry["on"] = quoted[wanted.before]
    whole = [" ".join(document.plain(text)) for text in texts]
    places = [at for at in range(len(whole)) if whole[at : at + len(quoted)] == quoted]
    if next(at for at in places if at >= min(start, first)) != first or first < start:
        entry["nth"] = 1 + places.index(first)
    hand = next((name for name, side in document.SIDES.items() if side == wanted.side), None)
    numbers = {"hand": hand, "size": wanted.size, "form": wanted.form, "sure": wanted.sure}
    return entry | {name: value for name, value in numbers.items() if value is not None}
