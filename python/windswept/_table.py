"""How the tables of a scene behave. `windswept.scene` declares their keys."""

from __future__ import annotations

import ast
import difflib
import importlib
import inspect
from collections.abc import Callable, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, overload

from windswept._native import CheckedScene, SceneError

if TYPE_CHECKING:
    from typing_extensions import Self, dataclass_transform
else:

    def dataclass_transform(**_: Any) -> Callable[[type], type]:
        return lambda cls: cls


Got = TypeVar("Got")
Taken = TypeVar("Taken")
_NEEDED: Any = object()
#: Tables that another value stands for too: the size of a box whose lower corner is the origin.
_SHORT: dict[str, Callable[[Any], dict[str, Any]]] = {"Bounds": lambda size: {"min": [0.0, 0.0, 0.0], "max": size}}
#: Docstrings of modules that were read.
_READ: dict[str, dict[str, str]] = {}


class Key(Generic[Got, Taken]):
    """A key of a table, as an attribute of its class."""

    def __init__(self, default: Any, factory: Callable[[], Any] | None, of: tuple[type[Table], ...], kind: str) -> None:
        self.default, self.factory, self.of, self.kind = default, factory, of, kind

    def __set_name__(self, owner: type[Table], name: str) -> None:
        self.owner, self.name = owner, name

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]
        return _documentation(self.owner.__module__).get(f"{self.owner.__name__}.{self.name}")

    @overload
    def __get__(self, table: None, owner: type) -> Self: ...
    @overload
    def __get__(self, table: Table, owner: type) -> Got: ...
    def __get__(self, table: Table | None, owner: type) -> Any:
        if table is None:
            return self
        if self.factory and self.name not in vars(table):
            vars(table)[self.name] = self.factory()
        value = self.of_table(table)
        if self.kind == "vector" and value is not None:
            import numpy as np

            value = np.array(value)
            value.flags.writeable = False
        return value

    def __set__(self, table: Table, value: Taken) -> None:
        own: Any = value
        if own is None:
            vars(table).pop(self.name, None)
            return
        if self.kind == "tables":
            own = [self._table(item) for item in (own if isinstance(own, (list, tuple)) else [own])]
        elif self.kind == "word" and isinstance(own, Table):
            # The keys of the choice are the table's own.
            for name in {name for other in self.of for name in other._keys}:
                vars(table).pop(name, None)
            vars(table).update(vars(self._table(own)))
            own = own._word[1]
        elif self.kind == "table":
            own = self._table(own)
        elif self.kind == "vector":
            own = plain(own)
            if not (isinstance(own, list) and len(own) == 3 and all(isinstance(x, (int, float)) for x in own)):
                raise self._fault(f"expected three numbers, [x, y, z], found {value!r}")
            own = [float(x) for x in own]
        elif self.kind == "pairs":
            own = plain(own)
            if not (isinstance(own, list) and own and all(isinstance(pair, list) and len(pair) == 2 for pair in own)):
                raise self._fault(f"expected pairs [part of the length, factor], found {value!r}")
            own = [[float(part), float(factor)] for part, factor in own]
        vars(table)[self.name] = own if self.kind in ("table", "tables") else plain(own)

    def parameter(self) -> inspect.Parameter:
        """The key as an argument of its table."""
        default = None if self.factory else inspect.Parameter.empty if self.default is _NEEDED else self.default
        return inspect.Parameter(self.name, inspect.Parameter.KEYWORD_ONLY, default=default)

    def of_table(self, table: Table) -> Any:
        """The value as it is kept: the one that was set, else the default."""
        value = vars(table).get(self.name, self.factory() if self.factory else self.default)
        return None if value is _NEEDED else value

    def _table(self, value: Any) -> Table:
        if isinstance(value, self.of):
            return value
        if not isinstance(value, (Table, Mapping)) and len(self.of) == 1 and self.of[0].__name__ in _SHORT:
            value = _SHORT[self.of[0].__name__](value)
        if isinstance(value, Mapping):
            tag, default = self.of[0]._word
            words = {table._word[1]: table for table in self.of}
            if (word := value.get(tag, default)) in words:
                return words[word].from_dict(value)
            raise fault(f"{_join(self.owner._path, self.name)}.{tag}", f"expected one of {', '.join(words)}, found {word!r}")
        names = " or ".join(f"windswept.{table.__name__}" for table in self.of)
        raise self._fault(f"expected {names}, found {value!r}")

    def _fault(self, words: str) -> SceneError:
        return fault(_join(self.owner._path, self.name), words)


def key(
    *, default: Any = _NEEDED, factory: Callable[[], Any] | None = None, of: Any = (), kind: str = "value"
) -> Any:
    """A key with its default, or with a function that makes it; `of` has the classes of the tables that it takes."""
    return Key(default, factory, of if isinstance(of, tuple) else (of,), kind)


@dataclass_transform(kw_only_default=True, eq_default=False, field_specifiers=(key,))
class Table:
    """A table of a scene. Its keys are its attributes; a value that is None follows from others."""

    _keys: ClassVar[dict[str, Key[Any, Any]]] = {}
    #: Path in a scene file.
    _path: ClassVar[str] = ""
    #: Key and word that choose this one among several tables.
    _word: ClassVar[tuple[str, str]] = ("", "")
    __signature__: ClassVar[inspect.Signature] = inspect.Signature()

    def __init_subclass__(cls) -> None:
        cls._keys = {name: own for name, own in vars(cls).items() if isinstance(own, Key)}
        cls.__signature__ = inspect.Signature([own.parameter() for own in cls._keys.values()])

    def __init__(self, **values: Any) -> None:
        needed = (name for name, own in self._keys.items() if own.default is _NEEDED and not own.factory)
        if missing := [name for name in needed if values.get(name) is None]:
            raise TypeError(f"{type(self).__name__}() needs {', '.join(missing)}")
        for name, value in values.items():
            if name not in self._keys:
                raise TypeError(f"{type(self).__name__}() has no argument {name!r}{_nearest(name, self._keys)}")
            setattr(self, name, value)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            raise AttributeError(f"{type(self).__name__} has no key {name!r}{_nearest(name, self._keys)}")

        def __setattr__(self, name: str, value: Any) -> None:
            if name not in self._keys:
                self.__getattr__(name)
            super().__setattr__(name, value)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """The table of these values, with a dict for each table in it, and a list of them for several.

        Raises:
            SceneError: an unknown key, with the nearest name.
        """
        table = cls.__new__(cls)
        for name, value in values.items():
            if name in cls._keys:
                setattr(table, name, value)
            elif name != cls._word[0]:
                raise fault(_join(cls._path, name), f"unknown key{_nearest(name, cls._keys)}")
        return table

    def to_dict(self) -> dict[str, Any]:
        """What was given, with a dict for each table: numbers, words and lists, as JSON and TOML have them."""
        values = dict([self._word]) if self._word[0] else {}
        for name, own in self._keys.items():
            value = plain(vars(self).get(name))
            # Tables that are there in any case need not be written.
            if value is not None and not (own.factory and not value):
                values[name] = value
        return values

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(own.of_table(self) == own.of_table(other) for own in self._keys.values())

    __hash__: ClassVar[None]  # type: ignore[assignment]

    def __repr__(self) -> str:
        given = {own.name: own.of_table(self) for own in self._keys.values() if own.name in vars(self)}
        said = [f"{n}={v!r}" for n, v in given.items() if v != (f() if (f := self._keys[n].factory) else self._keys[n].default)]
        return f"{type(self).__name__}({', '.join(said)})"


class SceneTable(Table):
    """A scene: how it is read, changed, checked and written."""

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
        """Reads a scene file (TOML). Paths in it start from its folder; absolute ones are refused.

        Raises:
            SceneError: names file, line and key, says what was expected and suggests the nearest key.
        """
        return cls._of(CheckedScene.load(path))

    @classmethod
    def parse(cls, text: str) -> Self:
        """Reads a scene from text (TOML). Paths in it start from the current directory, or are absolute.

        Raises:
            SceneError: as `load`.
        """
        return cls._of(CheckedScene.parse(text))

    @classmethod
    def _of(cls, checked: CheckedScene) -> Self:
        scene = cls.from_dict(checked.values(False))
        vars(scene)["_read"] = checked, scene.to_dict()
        return scene

    def _checked(self) -> CheckedScene:
        """The scene as the engine takes it, with the text that it was read from unless it was changed since."""
        read: tuple[CheckedScene, dict[str, Any]] | None = vars(self).get("_read")
        values = self.to_dict()
        if read is None or read[1] != values:
            read = vars(self)["_read"] = CheckedScene.made(values), values
        return read[0]

    def checked(self) -> Self:
        """The scene in which every value stands, those that follow from others included; this one stays as it is.

        Raises:
            SceneError: has every fault, each with its dotted key, what was expected and what was found.
        """
        return self.from_dict(self._checked().values(True))

    def replace(self, **changes: Any) -> Self:
        """The scene with other values under dotted keys, checked; this one stays as it is.

            scene.replace(**{"air.wind": [6, 0, 0], "turbulence.bands.0.scale": 0.018}, title="Storm")

        Raises:
            SceneError: an unknown key, with the nearest name; a value that its key does not take.
        """
        return self._of(self._checked().replaced({key: plain(value) for key, value in changes.items()}))

    def to_toml(self) -> str:
        """The scene as TOML, checked; `parse` of it is an equal scene. Keys that follow from others are left out."""
        return self._checked().to_toml()

    @property
    def text(self) -> str:
        """The text that it was read from, with what `replace` changed; of a scene that code made or changed, `to_toml`."""
        return self._checked().text

    def text_in(self, folder: str | PathLike[str]) -> str:
        """`text` for a scene file in this folder, which is there: paths of files start from the folder."""
        return self._checked().text_in(folder)

    def __getitem__(self, path: str) -> Any:
        """The value under a dotted key, as `turbulence.bands.0.scale` or `hair.NAME.radius`; where it was not given, the one
        that follows from others.

        Raises:
            SceneError: there is no such key or table, or a value that was not given follows from wrong ones.
        """
        try:
            value = self._find(path, make=False)
        except SceneError:
            value = None
        return self.checked()._find(path, make=False) if value is None else value

    def __contains__(self, path: object) -> bool:
        """Whether the scene has a value under a dotted key, its own or one that follows from others."""
        try:
            return isinstance(path, str) and self[path] is not None
        except SceneError:
            return False

    #: A scene is no list of its keys: `to_dict` has them.
    __iter__: ClassVar[None] = None

    def __setitem__(self, path: str, value: Any) -> None:
        head, _, name = path.rpartition(".")
        table = self._find(head, make=True) if head else self
        if isinstance(table, list) and len(table) == 1:
            (table,) = table
        if not isinstance(table, Table) or name not in table._keys:
            raise fault(path, f"unknown key{_nearest(name, getattr(table, '_keys', {}))}")
        setattr(table, name, value)

    def _find(self, path: str, make: bool) -> Any:
        value: Any = self
        names = path.split(".")
        while names:
            name = names[0]
            if isinstance(value, list):
                named = [table for table in value if getattr(table, "name", None) == name]
                indexed = value[int(name) :][:1] if name.isdigit() else []
                if not (found := named or indexed or value * (len(value) == 1)):
                    known = [str(getattr(table, "name", index)) for index, table in enumerate(value)]
                    raise fault(path, f"there is no {name} among {', '.join(known) or 'no tables'}")
                value = found[0]
                if not (named or indexed):
                    continue
            elif isinstance(value, Table) and name in value._keys:
                own = value._keys[name]
                if make and getattr(value, name) is None and own.kind == "table" and len(own.of) == 1:
                    setattr(value, name, {})
                value = getattr(value, name)
            elif isinstance(value, Table) and name and name == value._word[0]:
                value = value._word[1]
            elif value is None:
                raise fault(path, "is not there: this scene has no such table")
            else:
                raise fault(path, f"unknown key{_nearest(name, getattr(value, '_keys', {}))}")
            names.pop(0)
        return value


def plain(value: Any, depth: int = 10) -> Any:
    """The value as JSON and TOML have it: tables as dicts, NumPy's arrays and numbers as Python's own."""
    if isinstance(value, Table):
        return value.to_dict()
    # A list may be in itself. No value of a scene is so deep, which the check of the scene says.
    if isinstance(value, (list, tuple)) and depth:
        return [plain(item, depth - 1) for item in value]
    if isinstance(value, Mapping) and depth:
        return {name: plain(item, depth - 1) for name, item in value.items()}
    return value.tolist() if hasattr(value, "dtype") and hasattr(value, "tolist") else value


def fault(key: str, words: str) -> SceneError:
    error = SceneError(f"{key}: {words}")
    error.key = key
    return error


def _join(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


def _nearest(name: str, names: Mapping[str, Any]) -> str:
    near = difflib.get_close_matches(name, names, n=1)
    return f"; did you mean {near[0]}?" if near else ""


def _documentation(module: str) -> dict[str, str]:
    """The docstrings of attributes, as `Air.wind`, of the classes of a module: Python itself does not keep them."""
    if module not in _READ:
        _READ[module] = {
            f"{table.name}.{key.target.id}": inspect.cleandoc(doc.value.value).strip()
            for table in ast.parse(inspect.getsource(importlib.import_module(module))).body
            if isinstance(table, ast.ClassDef)
            for key, doc in zip(table.body, table.body[1:])
            if isinstance(key, ast.AnnAssign) and isinstance(key.target, ast.Name)
            if isinstance(doc, ast.Expr) and isinstance(doc.value, ast.Constant) and isinstance(doc.value.value, str)
        }
    return _READ[module]
