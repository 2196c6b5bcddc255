"""The solver, without a table: R, T and fluxes of a layer or a stack."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _stratus
from ._arrays import broadcast
from ._errors import errors_of, text_or_path, warn_of
from ._phase import PhaseFunction, phase_function_of

Below = float | tuple[PhaseFunction | str, float]


@dataclass(frozen=True)
class Light:
    """R and diffuse T at geometries, in the shape that these have together.

    `_single` is the light scattered once, over a lower boundary by the layer or the boundary; the
    rest is that of the orders n >= 2. `_error` is the estimated error of the total: 99 % of the true
    ones are below 1.5 times theirs.
    """

    reflection: NDArray[np.float64]
    transmission: NDArray[np.float64]
    reflection_single: NDArray[np.float64]
    transmission_single: NDArray[np.float64]
    reflection_error: NDArray[np.float64]
    transmission_error: NDArray[np.float64]

    @property
    def reflection_multiple(self) -> NDArray[np.float64]:
        return self.reflection - self.reflection_single

    @property
    def transmission_multiple(self) -> NDArray[np.float64]:
        return self.transmission - self.transmission_single


@dataclass(frozen=True)
class Fluxes:
    """Fluxes over the incident flux, of all orders.

    Under uniform illumination, and arrays over `mu_in`. Over a lower boundary transmittances are
    what arrives there, interreflection included, and `absorptance` counts both. With counted
    orders it counts the light of higher ones, too.
    """

    spherical_albedo: float
    total_transmittance: float  # diffuse and beam
    absorptance: float
    ground_absorptance: float  # the lower boundary's share; 0 without one
    mu_in: NDArray[np.float64]
    plane_albedo: NDArray[np.float64]
    diffuse_transmittance: NDArray[np.float64]
    direct_transmittance: NDArray[np.float64]
    error: float  # the largest that is estimated of any of them


class Stack:
    """Layers on top of one another, and what they lie on, from a stack file.

    source   TOML text, or the path of a file: an os.PathLike, or a str that ends in .toml

    Errors   ValueError naming the key, the allowed range and the value met; OSError for a file that
             cannot be opened.
    """

    __slots__ = ("_own",)

    def __init__(self, source: str | os.PathLike[str]) -> None:
        text, is_path = text_or_path(source)
        with errors_of(text if is_path else None):
            self._own, notes = _stratus.read_stack(text, is_path)
        warn_of(notes)


def _boundary(below: Below | None) -> object:
    if isinstance(below, tuple):
        return phase_function_of(below[0])._own, below[1]
    return below


def _light(found: tuple[NDArray[np.float64], ...], shape: tuple[int, ...], tolerance: float) -> Light:
    missed = sum(
        int(np.count_nonzero(error > np.maximum(tolerance * np.abs(value), 1e-15)))
        for value, error in ((found[0], found[4]), (found[1], found[5]))
    )
    if missed:
        warn_of([f"solve: the tolerance of {tolerance:g} is missed by {missed} of {2 * found[0].size} values"])
    return Light(*(values.reshape(shape)[()] for values in found))


def solve(
    phase_function: PhaseFunction | str,
    albedo: float,
    optical_depth: float,
    mu_in: ArrayLike,
    mu_out: ArrayLike,
    azimuth: ArrayLike,
    *,
    tolerance: float = 1e-4,
    nodes: int | None = None,
    orders: int = 0,
    below: Below | None = None,
) -> Light:
    """R and T of one layer at exact geometries, which broadcast.

    albedo, optical_depth   [0, 1] and [0, inf]
    mu_in, mu_out, azimuth  cosines (0, 1], radians; azimuth 0 is the forward side
    tolerance               relative error of R and T, [1e-12, 1]; as many Gauss nodes as it needs
    nodes                   their number in place of a tolerance, [1, 512]
    orders                  light scattered more often is left out, [0, 200]; 0: all
    below                   what the layer lies on: the albedo of a Lambert surface, or the phase
                            function and albedo of a semi-infinite layer

    Errors   ValueError naming argument, range and value. A tolerance that 512 nodes would not meet is
             a UserWarning, and the errors say by how much it is missed.
    Cost     that of a solution for every 63 cosines, in the order in which they come.
    """
    arrays, shape = broadcast(np.float64, mu_in, mu_out, azimuth)
    own = phase_function_of(phase_function)._own
    found = _stratus.solve_layer(own, albedo, optical_depth, *arrays, nodes or 0, tolerance, orders, _boundary(below))
    return _light(found, shape, tolerance if nodes is None else np.inf)


def solve_stack(
    stack: Stack,
    mu_in: ArrayLike,
    mu_out: ArrayLike,
    azimuth: ArrayLike,
    *,
    tolerance: float = 1e-4,
    nodes: int | None = None,
) -> Light:
    """R and T of a stack lit from above, as `solve` has them."""
    arrays, shape = broadcast(np.float64, mu_in, mu_out, azimuth)
    found = _stratus.solve_stack(stack._own, *arrays, nodes or 0, tolerance, 0)
    return _light(found, shape, tolerance if nodes is None else np.inf)


def _fluxes(found: dict[str, Any], mu_in: NDArray[np.float64]) -> Fluxes:
    passed = 0.0 if found.pop("over_boundary") else found["total_transmittance"]
    rest = 0.0 if found.pop("conservative") else 1 - found["spherical_albedo"] - passed
    return Fluxes(absorptance=rest, mu_in=mu_in, **found)


def fluxes(
    phase_function: PhaseFunction | str,
    albedo: float,
    optical_depth: float,
    mu_in: ArrayLike = 1.0,
    *,
    tolerance: float = 1e-4,
    nodes: int | None = None,
    orders: int = 0,
    below: Below | None = None,
) -> Fluxes:
    """Fluxes of one layer, at cosines mu_in of shape (n,) or one. Arguments as of `solve`."""
    at = np.atleast_1d(np.asarray(mu_in, np.float64))
    own = phase_function_of(phase_function)._own
    found = _stratus.layer_fluxes(own, albedo, optical_depth, at, nodes or 0, tolerance, orders, _boundary(below))
    return _fluxes(found, at)


def stack_fluxes(
    stack: Stack, mu_in: ArrayLike = 1.0, *, tolerance: float = 1e-4, nodes: int | None = None
) -> Fluxes:
    """Fluxes of a stack lit from above, at cosines mu_in of shape (n,) or one."""
    at = np.atleast_1d(np.asarray(mu_in, np.float64))
    return _fluxes(_stratus.stack_fluxes(stack._own, at, nodes or 0, tolerance, 0), at)
