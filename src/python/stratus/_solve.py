"""The solver, without a table: R, T and fluxes of a layer or a stack; directions as observers give them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _stratus
from ._arrays import as_array, broadcast, number, whole
from ._errors import builtin_errors, text_or_path, warn
from ._phase import PhaseFunction, as_phase_function

Below = float | str | tuple[PhaseFunction | str, float]
PhaseFunctions = PhaseFunction | str | Sequence[Any] | NDArray[np.object_]


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

    def on(self, side: ArrayLike) -> NDArray[np.float64]:
        """R where `side` is "lit", T where it is "unlit", as `directions` has it."""
        sides = np.asarray(side)
        other = sides[(sides != "lit") & (sides != "unlit")]
        if other.size:
            raise ValueError(f"Light.on: side must be lit or unlit, got {other.flat[0]}")
        return np.where(sides == "lit", self.reflection, self.transmission)[()]


@dataclass(frozen=True)
class Fluxes:
    """Fluxes over the incident flux, of all orders.

    Under uniform illumination, over the shape that the layers have together, and with one more axis,
    over `mu_in`. Over a lower boundary transmittances are
    what arrives there, interreflection included, and `absorptance` counts both. With counted
    orders it counts the light of higher ones, too.
    """

    spherical_albedo: NDArray[np.float64]
    total_transmittance: NDArray[np.float64]  # diffuse and beam
    absorptance: NDArray[np.float64]
    ground_absorptance: NDArray[np.float64]  # the lower boundary's share; 0 without one
    mu_in: NDArray[np.float64]
    plane_albedo: NDArray[np.float64]
    diffuse_transmittance: NDArray[np.float64]
    direct_transmittance: NDArray[np.float64]
    error: NDArray[np.float64]  # the largest that is estimated of any of them


class Stack:
    """Layers on top of one another, and what they lie on, from a stack file; or `Stack.of` layers.

    source   TOML text, or the path of a file: an os.PathLike, or a str that ends in .toml

    Errors   ValueError naming the key, the allowed range and the value met; OSError for a file that
             cannot be opened.
    """

    __slots__ = ("_own",)

    def __init__(self, source: str | os.PathLike[str]) -> None:
        given = text_or_path(source)
        with builtin_errors(*given):
            self._own, notes = _stratus.read_stack(*given)
        warn(notes)

    @classmethod
    def of(cls, *layers: tuple[PhaseFunction | str, float, float], below: Below | None = None) -> Stack:
        """Layers of a phase function, an albedo and an optical depth each, top first; `below` as of `solve`."""
        stack = cls.__new__(cls)
        parts = [
            (as_phase_function(phase_function)._own, number("Stack", "albedo", albedo), number("Stack", "optical_depth", depth))
            for phase_function, albedo, depth in layers
        ]
        stack._own = _stratus.make_stack(parts, _boundary(below))
        return stack


def _options(function: str, nodes: Any, tolerance: Any, orders: Any) -> tuple[int, float, int]:
    return (
        0 if nodes is None else whole(function, "nodes", nodes),
        number(function, "tolerance", tolerance),
        whole(function, "orders", orders),
    )


def _boundary(below: Below | None) -> object:
    if isinstance(below, tuple):
        return as_phase_function(below[0])._own, number("below", "albedo", below[1])
    return below if below is None or isinstance(below, str) else number("below", "albedo", below)


def _layers(
    function: str, phase_function: PhaseFunctions, albedo: ArrayLike, optical_depth: ArrayLike, **more: ArrayLike
) -> tuple[list[tuple[_stratus.PhaseFunction, float, float, NDArray[np.intp]]], list[NDArray[Any]], tuple[int, ...]]:
    """The distinct layers among arguments that broadcast, each with its places; the other arguments, flat; and their shape."""
    phases = as_array(function, "phase_function", object, phase_function)
    indices = np.arange(phases.size).reshape(phases.shape)
    (which, albedos, depths, *others), shape = broadcast(
        function, np.float64, phase_function=indices, albedo=albedo, optical_depth=optical_depth, **more)
    own = [as_phase_function(phase)._own for phase in phases.reshape(-1)]
    places: dict[tuple[float, float, float], list[int]] = {}
    for at, layer in enumerate(zip(which.tolist(), albedos.tolist(), depths.tolist())):
        places.setdefault(layer, []).append(at)
    return [(own[int(k)], w, depth, np.array(at)) for (k, w, depth), at in places.items()], others, shape


def _missed(function: str, found: Sequence[NDArray[np.float64]], tolerance: float, nodes: int | None) -> list[str]:
    """Says how many of two kinds of values miss the tolerance, relative to them but to no less than 1e-8."""
    missed = sum(
        int(np.count_nonzero(error > np.maximum(tolerance * np.maximum(np.abs(value), 1e-8), 1e-15)))
        for value, error in ((found[0], found[4]), (found[1], found[5]))
    )
    if nodes is not None or not missed:
        return []
    return [f"{function}: the tolerance of {tolerance:g} is missed by {missed} of {2 * found[0].size} values"]


def _missed_fluxes(function: str, error: float, tolerance: float, nodes: int | None) -> list[str]:
    """Says that fluxes miss the tolerance, by their largest relative error."""
    if nodes is not None or error <= tolerance:
        return []
    return [f"{function}: the tolerance of {tolerance:g} is missed: the largest relative error is some {error:.2g}"]


def _light(found: tuple[NDArray[np.float64], ...], shape: tuple[int, ...]) -> Light:
    return Light(*(values.reshape(shape)[()] for values in found))


def _gathered(count: int, parts: Iterable[tuple[NDArray[np.intp], Any]]) -> tuple[NDArray[np.float64], ...]:
    """Six arrays of `count` numbers from parts, each of which has its places."""
    found = tuple(np.empty(count) for _ in range(6))
    for places, of_part in parts:
        for to, values in zip(found, of_part):
            to[places] = values
    return found


def solve(
    phase_function: PhaseFunctions,
    albedo: ArrayLike,
    optical_depth: ArrayLike,
    mu_in: ArrayLike,
    mu_out: ArrayLike,
    azimuth: ArrayLike,
    *,
    tolerance: float = 1e-4,
    nodes: int | None = None,
    orders: int = 0,
    below: Below | None = None,
) -> Light:
    """R and T of layers at exact geometries; all of these broadcast.

    phase_function          one, or an array of them, as texts or `PhaseFunction`s
    albedo, optical_depth   [0, 1] and [0, inf]
    mu_in, mu_out, azimuth  cosines (0, 1], radians; azimuth 0 is the forward side
    tolerance               relative error of R and T, [1e-12, 1]; as many Gauss nodes as it needs
    nodes                   their number in place of a tolerance, [1, 512]
    orders                  light scattered more often is left out, [0, 200]; 0: all
    below                   what the layer lies on: the albedo of a Lambert surface, a ground by its
                            text ("ocean:wind=5"), or the phase function and albedo of a
                            semi-infinite layer

    Errors   ValueError naming argument, range and value. A tolerance that 512 nodes would not meet is
             a UserWarning, and the errors say by how much it is missed.
    Cost     for each distinct layer that of a solution for every 63 cosines, in the order in which they
             come.
    """
    layers, at, shape = _layers("solve", phase_function, albedo, optical_depth, mu_in=mu_in, mu_out=mu_out, azimuth=azimuth)
    options, ground = _options("solve", nodes, tolerance, orders), _boundary(below)
    found = _gathered(
        at[0].size,
        ((places, _stratus.solve_stack(_stratus.make_layer(own, w, depth, ground, "solve"), [values[places] for values in at], options))
         for own, w, depth, places in layers))
    warn(_missed("solve", found, tolerance, nodes))
    return _light(found, shape)


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
    arrays, shape = broadcast("solve_stack", np.float64, mu_in=mu_in, mu_out=mu_out, azimuth=azimuth)
    found = _stratus.solve_stack(stack._own, arrays, _options("solve_stack", nodes, tolerance, 0))
    warn(_missed("solve_stack", found, tolerance, nodes))
    return _light(found, shape)


def _cosines(function: str, mu_in: ArrayLike) -> NDArray[np.float64]:
    at = np.atleast_1d(as_array(function, "mu_in", np.float64, mu_in))
    if at.ndim > 1:
        raise ValueError(f"{function}: mu_in must be one number or of shape (n,), got the shape {at.shape}")
    return at


def _fluxes(
    found: Sequence[dict[str, Any]], shape: tuple[int, ...], mu_in: NDArray[np.float64], alike: dict[str, Any]
) -> Fluxes:
    """Fluxes of layers one after the other, put together over `shape`; `alike` are those of one layer."""
    return Fluxes(mu_in=mu_in, **{
        name: np.array([of_layer[name] for of_layer in found]).reshape((*shape, *np.shape(one)))[()]
        for name, one in alike.items()
    })


def fluxes(
    phase_function: PhaseFunctions,
    albedo: ArrayLike,
    optical_depth: ArrayLike,
    mu_in: ArrayLike = 1.0,
    *,
    tolerance: float = 1e-4,
    nodes: int | None = None,
    orders: int = 0,
    below: Below | None = None,
) -> Fluxes:
    """Fluxes of layers, which broadcast, at cosines mu_in of shape (n,) or one. Arguments as of `solve`."""
    at = _cosines("fluxes", mu_in)
    layers, _, shape = _layers("fluxes", phase_function, albedo, optical_depth)
    options, ground = _options("fluxes", nodes, tolerance, orders), _boundary(below)
    found: dict[int, dict[str, Any]] = {}
    error = 0.0
    nothing = as_phase_function("isotropic")._own, 0.0, 0.0, np.array([], int)  # where there are no layers
    for own, w, depth, places in layers or [nothing]:
        of_layer = _stratus.stack_fluxes(_stratus.make_layer(own, w, depth, ground, "fluxes"), at, options)
        error = max(error, of_layer.pop("relative_error"))
        found.update((place, of_layer) for place in places.tolist())
    warn(_missed_fluxes("fluxes", error, tolerance, nodes))
    return _fluxes([found[place] for place in range(len(found))], shape, at, of_layer)


def stack_fluxes(
    stack: Stack, mu_in: ArrayLike = 1.0, *, tolerance: float = 1e-4, nodes: int | None = None
) -> Fluxes:
    """Fluxes of a stack lit from above, at cosines mu_in of shape (n,) or one."""
    at = _cosines("stack_fluxes", mu_in)
    found = _stratus.stack_fluxes(stack._own, at, _options("stack_fluxes", nodes, tolerance, 0))
    warn(_missed_fluxes("stack_fluxes", found.pop("relative_error"), tolerance, nodes))
    return _fluxes([found], (), at, found)


@dataclass(frozen=True)
class FluxesInside:
    """Fluxes at levels inside, over the incident flux: arrays over `levels` and `mu_in`."""

    levels: NDArray[np.float64]  # optical depths from the top
    mu_in: NDArray[np.float64]
    direct_flux: NDArray[np.float64]  # down, exp(-level / mu_in)
    diffuse_flux: NDArray[np.float64]  # down, without the beam
    upward_flux: NDArray[np.float64]
    actinic_flux: NDArray[np.float64]  # 4 pi times the mean intensity, beam included
    heating_rate: NDArray[np.float64]  # absorbed per unit of optical depth; between two layers in the lower one
    error: float  # the largest that is estimated of any flux

    @property
    def net_flux(self) -> NDArray[np.float64]:
        """Down less up: what falls from one level to the next is absorbed between."""
        return self.direct_flux + self.diffuse_flux - self.upward_flux


def stack_fluxes_inside(
    stack: Stack, levels: ArrayLike, mu_in: ArrayLike = 1.0, *, tolerance: float = 1e-4, nodes: int | None = None
) -> FluxesInside:
    """Fluxes, actinic flux and heating at optical depths inside a stack, [0, its whole depth].

    A single layer is `Stack.of((phase_function, albedo, optical_depth))`. Options as of `solve`.
    """
    name = "stack_fluxes_inside"
    at, depths = _cosines(name, mu_in), np.atleast_1d(as_array(name, "levels", np.float64, levels)).reshape(-1)
    *arrays, error, relative = _stratus.stack_fluxes_inside(stack._own, depths, at, _options(name, nodes, tolerance, 0))
    warn(_missed_fluxes(name, relative, tolerance, nodes))
    return FluxesInside(depths, at, *(values.reshape(depths.size, at.size) for values in arrays), error=error)


@dataclass(frozen=True)
class LightInside:
    """Diffuse radiance inside, pi I / (mu_in F0), going up and down, in the shape that the geometries have together."""

    upward: NDArray[np.float64]
    downward: NDArray[np.float64]
    upward_single: NDArray[np.float64]
    downward_single: NDArray[np.float64]
    upward_error: NDArray[np.float64]
    downward_error: NDArray[np.float64]


def solve_stack_inside(
    stack: Stack,
    level: ArrayLike,
    mu_in: ArrayLike,
    mu_out: ArrayLike,
    azimuth: ArrayLike,
    *,
    tolerance: float = 1e-4,
    nodes: int | None = None,
) -> LightInside:
    """Radiance at optical depths inside a stack, where the beam is not part of it; level and geometries broadcast."""
    name = "solve_stack_inside"
    (depths, *at), shape = broadcast(name, np.float64, level=level, mu_in=mu_in, mu_out=mu_out, azimuth=azimuth)
    options = _options(name, nodes, tolerance, 0)
    levels, which = np.unique(depths, return_inverse=True)
    at_level = ((depth, np.flatnonzero(which == k)) for k, depth in enumerate(levels))
    found = _gathered(
        depths.size,
        ((places, _stratus.solve_stack_inside(stack._own, depth, [values[places] for values in at], options))
         for depth, places in at_level))
    warn(_missed(name, found, tolerance, nodes))
    return LightInside(*(values.reshape(shape)[()] for values in found))


class Directions(NamedTuple):
    """Cosines, the azimuth in radians, and the side on which light leaves: "lit" or "unlit"."""

    mu_in: NDArray[np.float64]
    mu_out: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    side: NDArray[np.str_]


def directions(incidence_deg: ArrayLike, emission_deg: ArrayLike, phase_deg: ArrayLike) -> Directions:
    """The directions of observed angles, which broadcast; degrees.

    incidence_deg   of the light from the normal of the lit side, [0, 90)
    emission_deg    of the eye from it, [0, 180] without 90; beyond 90 it is on the unlit side
    phase_deg       between the two: 180 degrees less the scattering angle. Of the two azimuths that have
                    it, mirror images, that in [0, pi] comes back

    `solve(phase_function, albedo, optical_depth, *found[:3])` takes them, and
    `fit(brightness, sigma, **found._asdict())`.

    Errors   ValueError naming argument, range and value, and for three angles that no directions have.
    """
    arrays, shape = broadcast("directions", np.float64, incidence_deg=incidence_deg, emission_deg=emission_deg, phase_deg=phase_deg)
    *cosines, is_lit = _stratus.observed_directions(*arrays)
    mu_in, mu_out, azimuth = (values.reshape(shape)[()] for values in cosines)
    return Directions(mu_in, mu_out, azimuth, np.where(is_lit.reshape(shape) > 0, "lit", "unlit")[()])
