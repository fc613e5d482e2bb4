"""Texts of the extension as its source has them, and what the tables of languages lack of them."""

import ast
import json
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "s2ag_blender"


def literals(node):
    """Texts that an expression can become: itself, or the branches of a choice."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return [node.value]
    if isinstance(node, ast.IfExp):
        return literals(node.body) + literals(node.orelse)
    if isinstance(node, ast.BoolOp):
        return [text for value in node.values for text in literals(value)]
    return []


def template(node):
    """An error's text as the table has it: a hole for each name or number."""
    if isinstance(node, ast.JoinedStr):
        return ["".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)]
    if isinstance(node, ast.IfExp):
        return template(node.body) + template(node.orelse)
    return literals(node)


def lacking(texts, folder, locale):
    """Texts that a table lacks, in a form to paste there; one that has no translation yet stands there as ``""``."""
    path = FOLDER / "translations" / folder / f"{locale}.json"
    missing = dict.fromkeys(sorted(set(texts) - json.loads(path.read_text("utf-8")).keys()), "")
    return missing and f"{path}:\n" + json.dumps(missing, indent=1, ensure_ascii=False)
