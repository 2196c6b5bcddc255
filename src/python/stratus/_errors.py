"""Errors of the libraries as Python's own, with the same sentences."""

from __future__ import annotations

import contextlib
import os
import warnings
from collections.abc import Iterable, Iterator


@contextlib.contextmanager
def errors_of(path: str | None = None) -> Iterator[None]:
    """Turns failures into OSError where a file cannot be opened, ValueError otherwise."""
    try:
        yield
    except RuntimeError as failure:
        sentence = str(failure)
    else:
        return
    kind: type[Exception] = FileNotFoundError if "cannot open" in sentence else ValueError
    if path is not None:
        try:
            open(path, "rb").close()
        except OSError as unopened:
            kind = type(unopened)
    raise kind(sentence)


@contextlib.contextmanager
def errors_of_writing() -> Iterator[None]:
    """Turns failures to write a file into OSError."""
    try:
        yield
    except RuntimeError as failure:
        sentence = str(failure)
    else:
        return
    raise OSError(sentence)


def warn_of(notes: Iterable[str]) -> None:
    """Warns the caller of the function that calls this."""
    for note in notes:
        warnings.warn(note, stacklevel=3)


def text_or_path(source: str | os.PathLike[str]) -> tuple[str, bool]:
    """TOML text, or the path of a file: an os.PathLike, or a str that ends in .toml."""
    if isinstance(source, str) and not source.endswith(".toml"):
        return source, False
    return os.fspath(source), True
