"""Bound layers: one optical depth and albedo, or three, made ready for many directions."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _stratus
from ._arrays import broadcast, broadcast_vectors, in_shape, number, shown

Opposition = str | tuple[str, float] | tuple[str, float, float]


class Slice:
    """A layer of one optical depth and albedo, or of three: red, green and blue.

    From `Table.bind`, or of single scattering alone from `bind_single`. Values are 32-bit, over the
    shape that the arguments have together, and over the three channels last where there are three.
    R and T are as everywhere: a white Lambert surface has R = 1; BRDF = R / pi, BTDF = T / pi.
    Vectors, arrays of (..., 3), are of length 1 in the layer's frame, z its normal, and point away
    from it: towards the light (wi) and the eye (wo).

    Accuracy within the table's tolerance; 0 for a side that the table lacks.
    Errors   ValueError for a cosine, an angle or a vector out of range, and for a direction that a
             narrowed table does not know.
    Threads  any number may share it; other Python threads run during a call.
    """

    __slots__ = ("_own",)

    def __init__(self, own: _stratus.Bound) -> None:
        self._own = own

    def _scattered(self, transmitted: bool, mu_in: ArrayLike, mu_out: ArrayLike, azimuth: ArrayLike) -> Any:
        name = "transmission" if transmitted else "reflection"
        arrays, shape = broadcast(name, np.float32, mu_in=mu_in, mu_out=mu_out, azimuth=azimuth)
        return in_shape(self._own.scattered(transmitted, *arrays), shape)

    def reflection(self, mu_in: ArrayLike, mu_out: ArrayLike, azimuth: ArrayLike) -> NDArray[np.float32]:
        """R at cosines (0, 1] and azimuths in radians, 0 the forward side."""
        return self._scattered(False, mu_in, mu_out, azimuth)

    def transmission(self, mu_in: ArrayLike, mu_out: ArrayLike, azimuth: ArrayLike) -> NDArray[np.float32]:
        """Diffuse T likewise; the beam is `direct`."""
        return self._scattered(True, mu_in, mu_out, azimuth)

    def eval(self, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float32]:
        """BRDF or BTDF per steradian, without the cosine, by the sides that wi and wo are on."""
        vectors, shape = broadcast_vectors("eval", wi=wi, wo=wo)
        return in_shape(self._own.eval(*vectors), shape)

    def _behind(self, what: str, mu: ArrayLike) -> Any:
        arrays, shape = broadcast(what, np.float32, mu=mu)
        return in_shape(self._own.behind(what, *arrays), shape)

    def direct(self, mu: ArrayLike) -> NDArray[np.float32]:
        """The beam that is transmitted unscattered, exp(-tau / mu); 0 over a lower boundary."""
        return self._behind("direct", mu)

    def background(self, mu: ArrayLike) -> NDArray[np.float32]:
        """The share of a uniform background that is seen through the layer; of a table without
        diffuse_transmittance (narrowed in mu_in, or without transmission) by the beam and order 1 alone."""
        return self._behind("background", mu)

    def source_behind(self, mu: ArrayLike) -> NDArray[np.float32]:
        """A small bright source straight behind the layer: its beam, and radiance scattered once."""
        return self._behind("source_behind", mu)

    @property
    def bytes(self) -> int:
        """Memory that lookups read."""
        return self._own.bytes()

    @property
    def clamped(self) -> bool:
        """True where `clamp` took orders n >= 2 of the nearest layer that the table knows."""
        return self._own.clamped()


@dataclass(frozen=True)
class Sample:
    """Directions drawn from a BSDF; a sample's weight is value * abs(wo[..., 2]) / pdf."""

    wo: NDArray[np.float32]  # (..., 3)
    value: NDArray[np.float32]  # eval(wi, wo)
    pdf: NDArray[np.float32]  # per steradian; 0: nothing is scattered, and wo is 0, too


class Bsdf(Slice):
    """A slice that can also draw directions, in proportion to the light scattered into them.

    From `Table.bsdf`. The directly transmitted beam is no part of it.
    """

    __slots__ = ()

    def sample(self, wi: ArrayLike, u: ArrayLike) -> Sample:
        """Directions for random numbers u in [0, 1], three for each: arrays of (..., 3) both."""
        vectors, shape = broadcast_vectors("sample", wi=wi, u=u)
        wo, value, pdf = self._own.sample(*vectors)
        return Sample(wo.reshape(*shape, 3), in_shape(value, shape), in_shape(pdf, shape))

    def pdf(self, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float32]:
        """The density with which `sample` draws wo, per steradian. One, of all channels; 0 where wo is 0."""
        vectors, shape = broadcast_vectors("pdf", wi=wi, wo=wo)
        return in_shape(self._own.pdf(*vectors), shape)

    def albedo(self, mu_in: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Shares of a beam that are reflected and transmitted, without the beam itself."""
        arrays, shape = broadcast("albedo", np.float32, mu_in=mu_in)
        reflected, transmitted = (in_shape(shares, shape) for shares in self._own.albedo(*arrays))
        return reflected, transmitted


def make_medium(optical_depth: ArrayLike, albedo: ArrayLike) -> tuple[list[float], list[float]]:
    """One number each, or three."""
    arrays, _ = broadcast("bind", np.float64, optical_depth=optical_depth, albedo=albedo)
    if arrays[0].size not in (1, 3):
        raise ValueError(f"bind: optical_depth and albedo must be one number or three, got {arrays[0].size}")
    return arrays[0].tolist(), arrays[1].tolist()


def opposition_parts(opposition: Opposition | None) -> tuple[str, float, float]:
    """Law, width and amplitude."""
    if opposition is None:
        return "", 0.0, 1.0
    law, *numbers = (opposition, 0.0) if isinstance(opposition, str) else opposition
    if not (isinstance(law, str) and law and 1 <= len(numbers) <= 2):
        raise ValueError(f"opposition must be a law, or (law, width[, amplitude]), got {shown(opposition)}")
    width, amplitude = (*numbers, 1.0)[:2]
    return law, number("opposition", "width", width), number("opposition", "amplitude", amplitude)


def effects_dict(function: str, effects: Mapping[str, Any]) -> dict[str, Any]:
    """Effects by name; refusals of others call the function as Python does.

    Errors   TypeError for an effect that there is not.
    """
    for name in effects:
        if name not in inspect.signature(_effects).parameters:
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}")
    return _effects(**effects)


def _effects(
    single: bool = True,
    multiple: bool = True,
    reflection: bool = True,
    transmission: bool = True,
    background: bool = True,
    density: float = 0.0,
    opposition: Opposition | None = None,
) -> dict[str, Any]:
    return dict(single=single, multiple=multiple, reflection=reflection, transmission=transmission,
                background=background, density=number("bind", "density", density), opposition=opposition_parts(opposition))
