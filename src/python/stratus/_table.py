"""Tables: baked, loaded, looked up, bound, and as xarray."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _stratus
from ._arrays import each, number, shown
from ._errors import builtin_errors, text_or_path, warn
from ._phase import PhaseFunction, as_phase_function
from ._slice import Bsdf, Opposition, Slice, effects_dict, make_medium

if TYPE_CHECKING:
    from typing_extensions import Unpack

    import xarray

_ABOUT = {
    "mixture": ("share of the first phase function", "1"),
    "g": ("g of the Henyey-Greenstein function", "1"),
    "radius": ("effective radius of the droplets", "um"),
    "wavelength": ("wavelength", "um"),
    "variance": ("effective variance of the droplets", "1"),
    "albedo": ("single-scattering albedo", "1"),
    "optical_depth": ("optical depth of the layer", "1"),
    "mu_in": ("cosine of the incident light's angle to the normal", "1"),
    "mu_out": ("cosine of the outgoing light's angle to the normal", "1"),
    "azimuth": ("azimuth between the directions of propagation", "radian"),
}


class EffectOptions(TypedDict, total=False):
    """What a slice is bound for."""

    single: bool  # light scattered once
    multiple: bool  # of the orders n >= 2
    reflection: bool
    transmission: bool
    background: bool  # diffuse light in Slice.background
    density: float  # share of the volume that particles fill, [0, 1)
    opposition: Opposition | None  # "blinn" or "hapke", or with a width, (law, width[, amplitude])


class Table:
    """A baked table, dense (.h5, .exr) or packed (.stratus).

    From `load` or `bake`.
    """

    __slots__ = ("_own",)

    def __init__(self, own: _stratus.Table) -> None:
        self._own = own

    # ---- what it holds

    @property
    def is_packed(self) -> bool:
        return self._own.is_packed()

    @property
    def phase_function(self) -> PhaseFunction:
        """Of mixtures the first; of other families the parameters of its own do not count."""
        return PhaseFunction._of(self._own.facts()["phase_function"])

    @property
    def tolerance(self) -> float:
        """The relative error of R and T that it was baked for."""
        return self._own.facts()["tolerance"]

    @property
    def measured_error(self) -> float:
        """The largest relative error that its bake met at random points."""
        return self._own.facts()["measured_error"]

    @property
    def axes(self) -> dict[str, NDArray[np.float64]]:
        """Samples of every axis, by name."""
        return self._own.axes()

    @property
    def attributes(self) -> dict[str, str]:
        """Texts that its file keeps: title, recipe, resolved_recipe, conventions, ..."""
        return self._own.attributes()

    def __repr__(self) -> str:
        sizes = ", ".join(f"{name} {len(samples)}" for name, samples in self.axes.items())
        return f"<stratus.Table {'packed' if self.is_packed else 'dense'}: {sizes}>"

    # ---- lookups at any layer

    def _member(self, mixture: float | None, family: Mapping[str, float] | None) -> list[float]:
        """A value for each axis of the family."""
        names = list(self._own.axes())
        names = names[: names.index("albedo")]
        if not isinstance(family or {}, Mapping):
            raise ValueError(f"family must map parameters to values, got {shown(family)}")
        given = {name: number("Table", name, value) for name, value in (family or {}).items()}
        unknown = set(given) - set(names)
        if unknown:
            raise ValueError(f"family must be of {', '.join(names) or 'no parameters, of this table'}, got {min(unknown)}")
        share = 1.0 if mixture is None else number("Table", "mixture", mixture)
        if share != 1 and "mixture" not in names:
            raise ValueError(f"mixture must be 1 or left out of a table that mixes nothing, got {share:g}")
        if share != 1 and "mixture" in given:
            raise ValueError(f"mixture must be given once, got {share:g} and {given['mixture']:g} of family")
        if mixture is not None:
            given.setdefault("mixture", share)
        missing = [name for name in names if name not in given]
        if missing == ["mixture"]:
            raise ValueError("mixture must be given, of a table that mixes two phase functions, got none")
        if missing:
            raise ValueError(f"family must give {', '.join(names)}, of this table, got {', '.join(given) or 'none'}")
        return [given[name] for name in names]

    def _look_up(self, transmitted: bool, at: tuple[ArrayLike, ...], member: list[float], single: bool, multiple: bool) -> Any:
        def look_up(*arrays: NDArray[np.float64]) -> NDArray[np.float64]:
            return self._own.look_up(transmitted, *arrays, member, single, multiple)

        return each("transmission" if transmitted else "reflection", look_up, np.float64, **dict(zip(("albedo", "optical_depth", "mu_in", "mu_out", "azimuth"), at)))

    def reflection(
        self,
        albedo: ArrayLike,
        optical_depth: ArrayLike,
        mu_in: ArrayLike,
        mu_out: ArrayLike,
        azimuth: ArrayLike,
        *,
        mixture: float | None = None,
        family: Mapping[str, float] | None = None,
        single: bool = True,
        multiple: bool = True,
    ) -> NDArray[np.float64]:
        """R where everything varies; arguments broadcast. Of one layer a `Slice` is faster.

        albedo, optical_depth   of a layer that the table holds, or a thinner one
        mu_in, mu_out, azimuth  cosines (0, 1], radians, 0 the forward side
        mixture                 share of the first phase function, needed of a table that mixes two
        family                  parameters of the phase function, needed of a table of a family, by name:
                                {"radius": 10}; lengths in um
        single, multiple        light scattered once, and of the orders n >= 2

        Errors   ValueError naming argument, range and value.
        Accuracy of a packed table within its tolerance of the samples', in single precision.
        """
        return self._look_up(False, (albedo, optical_depth, mu_in, mu_out, azimuth), self._member(mixture, family), single, multiple)

    def transmission(
        self,
        albedo: ArrayLike,
        optical_depth: ArrayLike,
        mu_in: ArrayLike,
        mu_out: ArrayLike,
        azimuth: ArrayLike,
        *,
        mixture: float | None = None,
        family: Mapping[str, float] | None = None,
        single: bool = True,
        multiple: bool = True,
    ) -> NDArray[np.float64]:
        """Diffuse T likewise; the beam, exp(-optical_depth / mu_in), is not part of it."""
        return self._look_up(True, (albedo, optical_depth, mu_in, mu_out, azimuth), self._member(mixture, family), single, multiple)

    # ---- one layer

    def _bound(self, optical_depth: ArrayLike, albedo: ArrayLike, member: list[float], clamp: bool, sampled: bool,
               effects: Mapping[str, Any]) -> _stratus.Bound:
        medium = make_medium(optical_depth, albedo)
        return _stratus.bind_table(self._own, *medium, member, clamp, sampled,
                                   effects_dict("Table.bsdf" if sampled else "Table.bind", effects))

    def bind(
        self,
        optical_depth: ArrayLike,
        albedo: ArrayLike,
        *,
        mixture: float | None = None,
        family: Mapping[str, float] | None = None,
        clamp: bool = False,
        **effects: Unpack[EffectOptions],
    ) -> Slice:
        """One layer, or red, green and blue of it, for lookups along many directions.

        optical_depth, albedo   one number, or three; one for both where only the other varies
        mixture                 [0, 1], needed of a table of two phase functions
        family                  parameters by name, needed of a table of a family: {"radius": 10},
                                lengths in um
        clamp                   take orders n >= 2 of the nearest layer where the table does not know this one
        effects                 `EffectOptions`

        Errors   ValueError for a layer that the table does not know, naming the range.
        Cost     2 to 20 ms. The table may go.
        """
        return Slice(self._bound(optical_depth, albedo, self._member(mixture, family), clamp, False, effects))

    def bsdf(
        self,
        optical_depth: ArrayLike,
        albedo: ArrayLike,
        *,
        mixture: float | None = None,
        family: Mapping[str, float] | None = None,
        clamp: bool = False,
        **effects: Unpack[EffectOptions],
    ) -> Bsdf:
        """The same, and it can be sampled.

        Errors   as of `bind`; ValueError for a table that was narrowed to some directions.
        Cost     3 to 40 ms more.
        """
        return Bsdf(self._bound(optical_depth, albedo, self._member(mixture, family), clamp, True, effects))

    # ---- files and other forms

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes .h5 or .exr, of dense tables; or .stratus, which packs it. Whole or not at all."""
        try:
            self._own.write(os.fspath(path))
        except RuntimeError as failure:
            raise OSError(str(failure)) from None

    def pack(self) -> Table:
        """The packed table, in memory: what fast lookups read, a tenth of the samples' size."""
        return Table(_stratus.packed(self._own))

    def to_xarray(self) -> xarray.Dataset:
        """The numbers as files name them, with their axes, as an xarray.Dataset.

        Samples are the orders n >= 2 alone: single scattering is never tabulated. Those of a dense
        table are not copied, and are read-only.
        """
        import xarray

        dense = _stratus.unpacked(self._own)
        axes, scales, facts = dense.axes(), dense.scales(), dense.facts()
        coordinates = {
            name: xarray.Variable(name, samples,
                                  {"long_name": _ABOUT[name][0], "units": _ABOUT[name][1], "scale": scales[name]})
            for name, samples in axes.items()
        }
        texts = {name: fact.text() if isinstance(fact, _stratus.PhaseFunction) else fact for name, fact in facts.items()}
        return xarray.Dataset(_stratus.datasets(dense), coordinates, {**dense.attributes(), **texts})


def load(path: str | os.PathLike[str]) -> Table:
    """A table from its file, by the name's ending: .h5, .exr or .stratus.

    Errors   OSError for a file that cannot be opened; ValueError for one that is damaged or
             foreign, with the reason.
    """
    name = os.fspath(path)
    with builtin_errors(name, is_path=True):
        return Table(_stratus.read_table(name))


def bake(
    recipe: str | os.PathLike[str],
    *,
    threads: int = 0,
    progress: Callable[[float, str], object] | None = None,
    note: Callable[[str], object] | None = None,
) -> Table:
    """Bakes a table.

    recipe     TOML text, or the path of a recipe or stack file: an os.PathLike, or a str that ends
               in .toml
    threads    0: all; the table is the same
    progress   called with the share done, [0, 1], and the name of the stage
    note       called with each line on what was chosen and why

    Both are called in the thread that called this, some ten times a second. Ctrl-C, or an exception
    that they raise, ends the bake and leaves nothing. Where the table misses its tolerance, a
    RuntimeWarning says by how much.

    Errors   ValueError naming the key of the recipe, the allowed range and the value met; OSError
             for a file that cannot be opened.
    """
    source = text_or_path(recipe)
    with builtin_errors(*source):
        own, notes, missed = _stratus.bake(*source, threads, note, progress)
    warn(notes)
    if missed:
        warnings.warn("bake: " + missed, RuntimeWarning, stacklevel=2)
    return Table(own)


def bind_single(
    phase_function: PhaseFunction | str, optical_depth: ArrayLike, albedo: ArrayLike, **effects: Unpack[EffectOptions]
) -> Bsdf:
    """Light scattered once, in closed form: a layer that needs no table. Arguments as of `Table.bind`."""
    own = as_phase_function(phase_function)._own
    return Bsdf(_stratus.bind_single(own, *make_medium(optical_depth, albedo), effects_dict("bind_single", effects)))
