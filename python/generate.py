"""Writes what follows from the native module: `windswept/scene.py`, the docstrings of `windswept/_native.pyi`, and the
schema of scene files.

    cargo xtask stubs                     # builds the module, then runs this
    python -I python/generate.py --check  # says what differs
"""

from __future__ import annotations

import ast
import inspect
import json
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

from windswept import _native

PACKAGE = Path(__file__).parent / "windswept"
SCENES = Path(__file__).parent.parent / "examples/scenes"
HEAD = '''"""The tables of a scene and their keys, made by `cargo xtask stubs` from the keys that the engine declares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

from windswept._table import Key, SceneTable, Table, key

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import ArrayLike, NDArray

'''
KEYS: list[dict[str, Any]] = json.loads(_native._keys())
TYPES = {"number": "float", "count": "int", "bool": "bool", "text": "str", "values": "Mapping[str, object]"}
#: Tables that every scene has.
PRESENT = _native.CheckedScene.parse('time = { step = 1.0, duration = 1.0 }\ninteraction.model = "none"').values(False)


def scene_classes() -> dict[str, str]:
    """The source of each class, tables before those that have them."""
    classes: dict[str, str] = {}
    add_table("", "Scene", "A scene: what to simulate, in SI; `windswept.Simulation` runs it.", classes)
    return classes


def add_table(path: str, name: str, doc: str, classes: dict[str, str]) -> tuple[str, ...]:
    """Adds the class of the table at a path, or the classes of the tables that may stand there; returns their names."""
    keys = [own for own in KEYS if own["path"].rpartition(".")[0] == path]
    tag = next((own for own in keys if own["words"] and own["variants"]), None)
    names: tuple[str, ...] = ()
    for variant, word in zip(tag["variants"], tag["words"]) if tag else []:
        tables = [other["table"] for other in tag["variants"]]
        names += (variant["table"] if tables.count(variant["table"]) == 1 else variant["name"],)
        of_word = f"`{tag['path']} = \"{word}\"`"
        own = [needed(key, tag) for key in keys if variant in key["variants"] and key is not tag]
        word_line = f'    _word = ("{last(tag["path"])}", "{word}")\n'
        classes[names[-1]] = class_of(names[-1], path, f"{variant['doc']} {of_word}.", own, classes, word_line)
    if tag and all(own["variants"] for own in keys):
        return names
    if tag:
        tag["tables"] = names
    docs = [f"{own['help']}: `[{own['path']}]`." for own in KEYS if own["table"] == name]
    classes[name] = class_of(name, path, " ".join(docs) or doc, keys, classes, "")
    return (name,)


def needed(own: dict[str, Any], tag: dict[str, Any]) -> dict[str, Any]:
    """A key of one table of a choice, which needs it if the choice says so."""
    choices = [f"with {last(tag['path'])} {word}" for word in tag["words"]]
    return {**own, "needed_if": None if own["needed_if"] in choices else own["needed_if"]}


def class_of(name: str, path: str, doc: str, keys: list[dict[str, Any]], classes: dict[str, str], more: str) -> str:
    base = "SceneTable" if name == "Scene" else "Table"
    lines = "".join(attribute(own, classes) for own in keys)
    path_line = f'    _path = "{path}"\n' if path else ""
    head = f"class {name}({base}):\n{docstring(doc)}\n\n{path_line}{more}"
    return f"{head.rstrip()}\n\n{lines}"


def attribute(own: dict[str, Any], classes: dict[str, str]) -> str:
    name, kind, default, follows = last(own["path"]), own["kind"], own["default"], own["follows"]
    may_be_absent = follows is not None or own["needed_if"] is not None
    value = json.loads(default or "null")
    default = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value) if default else None
    words = [f"default={default}"] if default else ["default=None"] if may_be_absent else []
    optional = " | None" if may_be_absent else ""
    sentences = [f"{own['help']}."]
    if kind in ("table", "tables"):
        tables = add_table(own["path"], own["table"], f"{own['help']}.", classes)
        got = taken = " | ".join(tables)
        of = tables[0] if len(tables) == 1 else f"({', '.join(tables)})"
        if kind == "tables":
            got, taken, optional, words = f"list[{got}]", f"{taken} | Sequence[{taken}]", "", ["factory=list"]
        elif own["path"] in PRESENT and may_be_absent:
            optional, words = "", [f"factory={of}"]
        elif tables == ("Bounds",):
            taken += " | ArrayLike"
            sentences.append("Three numbers are a box of this size whose lower corner is the origin.")
        words += [f"of={of}", f'kind="{kind}"']
    elif kind == "vector":
        got, taken = "NDArray[float64]", "ArrayLike"
        words.append('kind="vector"')
    elif kind == "pairs":
        got, taken = "list[list[float]]", "ArrayLike"
        words.append('kind="pairs"')
    elif kind == "word":
        got = taken = f"Literal[{', '.join(map(json.dumps, own['words']))}]"
        if tables := own.get("tables", ()):
            taken += f" | {' | '.join(tables)}"
            words += [f"of=({', '.join(tables)})", 'kind="word"']
    else:
        got = taken = TYPES[kind]
    if kind not in ("table", "tables"):
        sentences.append(f"{own['expected'][0].upper()}{own['expected'][1:]}.")
    if default:
        sentences.append(f"Default {default}.")
    elif follows:
        sentences.append(f"Without it: {follows}.")
    elif own["needed_if"]:
        sentences.append(f"Needed {own['needed_if']}.")
    elif follows is None:
        sentences.append("Needed.")
    line = f"    {name}: Key[{got}{optional}, {taken}{optional}] = key({', '.join(words)})\n"
    return line + docstring(" ".join(sentences)) + "\n"


def last(path: str) -> str:
    return path.rpartition(".")[2]


def docstring(text: str, indent: str = "    ") -> str:
    """A docstring, in lines of at most 120 characters."""
    lines = textwrap.wrap(f'{indent}"""{text}', 120, subsequent_indent=indent, break_long_words=False)
    return "\n".join(lines) + ('"""' if len(lines) == 1 and len(lines[0]) < 118 else f'\n{indent}"""')


def scene() -> str:
    classes = scene_classes()
    names = "".join(f'    "{name}",\n' for name in sorted(classes))
    return HEAD + f"__all__ = [\n{names}]\n\n\n" + "\n\n".join(classes.values())


def stub() -> str:
    """The stub as it is, with the docstrings of the module in place of those that it has."""
    path = PACKAGE / "_native.pyi"
    lines = path.read_text(encoding="utf-8").split("\n")
    tree = ast.parse("\n".join(lines))
    places = [(node, getattr(_native, node.name)) for node in tree.body if hasattr(node, "name")]
    places += [
        (member, inspect.getattr_static(thing, member.name))
        for node, thing in places
        if isinstance(node, ast.ClassDef)
        for member in node.body
        if isinstance(member, ast.FunctionDef) and not member.name.startswith("__")
    ]
    # From the end, so that the lines before stay where they are.
    for node, thing in sorted(places, key=lambda place: -place[0].lineno):
        doc = getattr(thing, "__func__", thing).__doc__
        first, indent = node.body[0], " " * (node.col_offset + 4)
        is_only = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
        if not doc or not isinstance(first, (ast.Expr, ast.FunctionDef, ast.AnnAssign)):
            continue
        quoted = textwrap.indent(f'"""{inspect.cleandoc(doc)}', indent).split("\n")
        quoted = [line.rstrip() for line in quoted]
        quoted[-1:] = [quoted[-1] + '"""'] if len(quoted) == 1 else [quoted[-1], indent + '"""']
        if is_only:
            before = lines[first.lineno - 1][: first.col_offset].rstrip()
            lines[first.lineno - 1 : first.end_lineno] = ([before] if before else []) + quoted
        else:
            at = min([first.lineno, *(d.lineno for d in getattr(first, "decorator_list", []))]) - 1
            lines[at:at] = quoted
    return "\n".join(lines)


def schema() -> str:
    """The schema that the example scenes name in their first line."""
    command = [sys.executable, "-I", "-m", "windswept", "check", "--schema"]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def main() -> int:
    differ = 0
    for path, text in (
        (PACKAGE / "scene.py", scene()),
        (PACKAGE / "_native.pyi", stub()),
        (SCENES / "windswept.schema.json", schema()),
    ):
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        differ += 1
        print(f"{path}: {'differs' if '--check' in sys.argv else 'written'}")
        if "--check" not in sys.argv:
            path.write_text(text, encoding="utf-8")
    return differ if "--check" in sys.argv else 0


if __name__ == "__main__":
    sys.exit(main())
