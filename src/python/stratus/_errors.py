"""Errors of the libraries as Python's own, with the same sentences."""

from __future__ import annotations

import contextlib
import json
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from typing import Any


@contextlib.contextmanager
def builtin_errors(text: str = "", is_path: bool = False) -> Iterator[None]:
    """Turns failures into OSError where a file, that of `text` or another, cannot be opened, ValueError otherwise."""
    try:
        yield
    except RuntimeError as failure:
        sentence = str(failure)
        kind: type[Exception] = FileNotFoundError if "cannot be opened" in sentence else ValueError
        if is_path:
            try:
                open(text, "rb").close()
            except OSError as unopened:
                kind = type(unopened)
        raise kind(sentence) from None


def warn(notes: Iterable[str]) -> None:
    """Warns the caller of the function that calls this."""
    for note in notes:
        warnings.warn(note, stacklevel=3)


def _toml(value: Any) -> str:
    """A value as TOML writes it, within a line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_toml(str(key))} = {_toml(each)}" for key, each in value.items()) + " }"
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    if isinstance(value, bool):
        return "true" if value else "false"
    if hasattr(value, "tolist"):  # of NumPy
        return _toml(value.tolist())
    if isinstance(value, Iterable):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return repr(value)


def text_or_path(source: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[str, bool]:
    """TOML text, a dict in its place, or the path of a file: an os.PathLike, or a str that ends in .toml."""
    if isinstance(source, Mapping):
        return "".join(f"{_toml(str(key))} = {_toml(value)}\n" for key, value in source.items()), False
    if isinstance(source, str) and not source.endswith(".toml"):
        return source, False
    return os.fspath(source), True
