"""Builds the table of words that call for gestures from WordNet 3.

    python -m s2ag.core.learning.meanings_table /usr/share/wordnet

Every schema has a few dozen senses as seeds (meanings_seeds.json: lemma, part of speech, number of the sense, depth of
hyponyms). A lemma calls for a schema with the share of its uses that WordNet's own counts give to these senses and what follows
from them: hyponyms of verbs and nouns, adjectives like them. WordNet is free to use with its notice (core/assets/NOTICE.txt);
Debian has it as ``wordnet-base``.
"""

import argparse
import json
import re
from collections import defaultdict
from pathlib import Path

from ..files import atomic_file
from ..meaning.sentence import FOLDER

_POS = {"n": "noun", "v": "verb", "a": "adj", "r": "adv"}
_UNCOUNTED = 0.5
"""Added to each sense's count, since many were never seen."""
_LEAST = 0.3
"""Least share of a lemma's uses."""
_RARE = 12
"""Uses counted below which a verb is none whose word is a noun or an adjective more than twice as often (*bridge*, *piece*)."""
_TABLE = FOLDER / "en.words.json"
_SEEDS = Path(__file__).with_name("meanings_seeds.json")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("wordnet", type=Path, help="folder of data.noun, index.noun ...")
    parser.add_argument("-o", "--output", default=_TABLE, help="the file to write (default: %(default)s)")
    args = parser.parse_args()
    net = _WordNet(args.wordnet)
    table = {schema: _lemmas(net, seeds) for schema, seeds in json.loads(_SEEDS.read_text("utf-8")).items()}
    known = {(word[:-1], pos) for each in table.values() for pos, words in each.items() for word in words.split()}
    decides = set(re.findall("[a-z]+", FOLDER.joinpath("en.json").read_text("utf-8")))
    irregular = _irregular(args.wordnet, {part for lemma, _ in known for part in lemma.split("_")} | decides)
    with atomic_file(args.output) as temporary:
        text = json.dumps({"schemas": table, "irregular": irregular}, indent=0, ensure_ascii=False, sort_keys=True)
        Path(temporary).write_text(text + "\n", "utf-8")
    print(f"{len(known)} lemmas for {len(table)} schemas, {len(text) // 1000} KB")


class _WordNet:
    """Synsets by part of speech and offset: ``words`` of each, those ``below`` it, and the senses of each lemma."""

    def __init__(self, folder: Path) -> None:
        self.words, self.below, self.senses, self.counts = {}, defaultdict(list), {}, {}
        counts = {}
        for line in (folder / "cntlist.rev").read_text("latin-1").splitlines():
            key, _, count = line.split()
            counts[key] = int(count)
        for pos, name in _POS.items():
            for line in (folder / f"data.{name}").read_text("latin-1").splitlines():
                if not line.startswith(" "):
                    self._synset(pos, line.split(" | ")[0].split(), counts)
            for line in (folder / f"index.{name}").read_text("latin-1").splitlines():
                if not line.startswith(" "):
                    parts = line.split()
                    self.senses[parts[0], pos] = [(pos, offset) for offset in parts[-int(parts[2]) :]]

    def _synset(self, pos: str, parts: list[str], counts: dict) -> None:
        here, number = (pos, parts[0]), int(parts[3], 16)
        self.words[here] = []
        for place in range(number):
            lemma, which = parts[4 + 2 * place].split("(")[0].lower(), int(parts[5 + 2 * place], 16)
            self.words[here].append(lemma)
            kind = "nvar".index(pos) + 1
            key = f"{lemma}%{kind}:{parts[1]}:{which:02d}::"
            alike = parts[2] == "s"  # an adjective whose key names the one it is like
            self.counts[here, lemma] = self._satellite(lemma, parts[1], which, counts) if alike else counts.get(key, 0)
        rest = parts[4 + 2 * number :]
        for place in range(int(rest[0])):
            sign, offset, other = rest[1 + 4 * place : 4 + 4 * place]
            if sign in ("~", "&"):
                self.below[here].append((other, offset))

    def uses(self, lemma: str, pos: str) -> int:
        """Return how often a lemma was counted as a part of speech."""
        return sum(self.counts.get((one, lemma), 0) for one in self.senses.get((lemma, pos), []))

    def _satellite(self, lemma: str, file: str, which: int, counts: dict) -> int:
        start = f"{lemma}%5:{file}:{which:02d}:"
        if not hasattr(self, "heads"):
            self.heads = defaultdict(int)
            for key, count in counts.items():
                self.heads[key[: key.index(":", key.index(":", key.index(":") + 1) + 1) + 1]] += count
        return self.heads[start]


def _lemmas(net: _WordNet, seeds: list[str]) -> dict[str, str]:
    """Return the lemmas of a schema by part of speech, each with the tenths of its uses that mean it."""
    chosen = set()
    for seed in seeds:
        name, _, depth = seed.partition(":")
        lemma, pos, number = name.rsplit(".", 2)
        senses = net.senses.get((lemma, pos), [])
        layer = senses[int(number) - 1 : int(number)]
        if not layer:
            print(f"{seed} is not in WordNet")
        for _ in range(int(depth or 1) + 1):
            chosen.update(layer)
            layer = [below for each in layer for below in net.below[each]]
    found: dict[str, list[str]] = defaultdict(list)
    for lemma, pos in sorted({(word, synset[0]) for synset in chosen for word in net.words[synset]}):
        weight = {one: net.counts.get((one, lemma), 0) + _UNCOUNTED for one in net.senses.get((lemma, pos), [])}
        share = sum(value for one, value in weight.items() if one in chosen) / max(sum(weight.values()), _UNCOUNTED)
        verb, others = (sum(net.uses(lemma, one) for one in parts) for parts in ("v", "na"))
        if pos == "v" and verb < _RARE and others > 2 * verb + 1:
            continue
        if share >= _LEAST and lemma.replace("_", "").isalpha():
            found[pos].append(f"{lemma}{min(int(10 * share), 9)}")
    return {pos: " ".join(words) for pos, words in found.items()}


def _irregular(folder: Path, lemmas: set[str]) -> dict[str, str]:
    """Return irregular forms of the lemmas, and of those that sentences are decided by."""
    result = {}
    for pos in ("verb", "noun", "adj"):
        for line in (folder / f"{pos}.exc").read_text("latin-1").splitlines():
            form, lemma = line.split()[:2]
            regular = form in (lemma + lemma[-1] + "ed", lemma + lemma[-1] + "ing", lemma[:-1] + "ied")
            if form.isalpha() and lemma in lemmas and not regular:
                result.setdefault(form, lemma)
    return result


if __name__ == "__main__":
    main()
