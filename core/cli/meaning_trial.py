"""Prints whether every schema's gestures differ from the plain performance as they are meant.

    python -m s2ag.core.cli.meaning_trial RECORDING TEXT WORD

Prints a line a schema, and which forms miss what they are meant to do (:mod:`meaning_figures`). With --character a character is
measured as Blender keys it, else the canonical figure.
"""

import argparse
from collections.abc import Iterable

from ..learning import meaning_characters, meaning_figures
from ..learning.meaning_figures import Shown
from ..meaning import vocabulary
from ..synthesis.session import Session
from . import blender


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    for name in ("recording", "text", "word"):
        parser.add_argument(name)
    parser.add_argument("--schema", nargs="*", help="these alone")
    parser.add_argument("--character", help="measure a character as Blender keys it: mannequin, human, human:RIG or a file")
    parser.add_argument("--first", action="store_true", help="with --character: the first form of each schema alone")
    options = parser.parse_args()
    session, rows, failed = Session(remember=True), {}, []
    schemas = options.schema or list(vocabulary.load_vocabulary().gestures)
    performed: Iterable[Shown] = meaning_figures.perform(
        session, schemas, meaning_figures.STYLES, options.word, options.recording, options.text
    )
    measured: Iterable[tuple] = ((one, meaning_figures.figures(one)) for one in performed)
    if options.character:
        performed = [one for one in performed if not options.first or one.form == 1]
        measured = zip(performed, meaning_characters.figures(options.character, performed, blender.run), strict=True)
    for one, seen in measured:
        name, fits = meaning_figures.meant(one.schema, seen)
        rows.setdefault((one.schema, name), []).append((seen[name], fits))
        if not fits:
            failed.append(f"{one.schema} form {one.form}, {one.style}: {name} {seen[name]:.2f}")
    for (schema, name), each in rows.items():
        values, fit = [value for value, _ in each], sum(fits for _, fits in each)
        print(f"{schema:<10} {name:<8} {min(values):7.2f} to {max(values):6.2f}  {fit} of {len(each)}")
    shown, fit = sum(map(len, rows.values())), sum(fits for each in rows.values() for _, fits in each)
    print(f"{fit} of {shown} performances are as meant", *failed, sep="\n")


if __name__ == "__main__":
    main()
