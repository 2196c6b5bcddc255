"""Directions as observers give them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _stratus
from ._arrays import broadcast


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
