"""Phase functions."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _stratus
from ._arrays import each, shown
from ._errors import builtin_errors, warn


class PhaseFunction:
    """A phase function, of mean 1 over the sphere, from its text.

    text        as in recipes and on the command line: "henyey_greenstein:g=0.75",
                "mie:radius=10um,variance=0.1", "0.6*lambert_sphere + 0.4*rayleigh";
                `phase_function_help()` has all
    directory   where files named in it are looked for

    Errors   ValueError naming the part that is wrong and what is allowed; OSError for a file that
             cannot be opened. What else there is to know (weights that did not sum to 1, how a
             table is continued) comes as a warning.
    """

    __slots__ = ("_own",)

    def __init__(self, text: str, directory: str | os.PathLike[str] = "") -> None:
        with builtin_errors():
            self._own, notes = _stratus.read_phase_function(text, os.fspath(directory))
        warn(notes)

    @classmethod
    def _of(cls, own: _stratus.PhaseFunction) -> PhaseFunction:
        phase_function = cls.__new__(cls)
        phase_function._own = own
        return phase_function

    def __call__(self, cos_scattering_angle: ArrayLike) -> NDArray[np.float64]:
        """phi at cosines of the scattering angle, [-1, 1]; 1 is straight on. Any shape."""
        return each("PhaseFunction", self._own.values, np.float64, cos_scattering_angle=cos_scattering_angle)

    def moments(self, count: int) -> NDArray[np.float64]:
        """The first `count` Legendre moments: phi = sum (2l+1) chi_l P_l, chi_0 = 1, chi_1 = g."""
        return self._own.moments(count)

    @property
    def g(self) -> float:
        """Mean cosine of the scattering angle, positive forward."""
        return self._own.asymmetry()

    @property
    def albedo(self) -> float | None:
        """Single-scattering albedo of droplets and of tables with a geometric albedo; else None."""
        return self._own.albedo()

    @property
    def text(self) -> str:
        """Text of this same function, complete: numbers in place of the names of files."""
        return self._own.text()

    @property
    def caption(self) -> str:
        """What pictures call it."""
        return self._own.caption()

    def __repr__(self) -> str:
        text = self.text
        return f"PhaseFunction({text if len(text) <= 80 else text[:77] + '...'!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PhaseFunction) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)


def phase_function_help() -> str:
    """What a phase function may be: a line a kind."""
    return _stratus.phase_function_help()


def as_phase_function(phase_function: PhaseFunction | str) -> PhaseFunction:
    if isinstance(phase_function, str):
        return PhaseFunction(phase_function)
    if not isinstance(phase_function, PhaseFunction):
        raise ValueError(f"phase_function must be a text or a PhaseFunction, got {shown(phase_function)}")
    return phase_function
