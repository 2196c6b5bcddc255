"""Layers from observed brightness."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _stratus
from ._arrays import broadcast, number
from ._phase import PhaseFunction, as_phase_function
from ._slice import Opposition, opposition_parts
from ._table import Table

_SIDES = {"lit": 0, "unlit": 1, "beam": 2}


@dataclass(frozen=True)
class Fit:
    """A fitted layer.

    Parameters are named optical_depth, and w1, w2, g1, g2, or w and g of particles of one kind;
    radius, wavelength and variance of a table of droplets.
    """

    value: dict[str, float]
    sigma: dict[str, float]  # standard deviations of those that were fitted
    covariance: NDArray[np.float64]  # over `names`, twice
    correlation: NDArray[np.float64]  # likewise
    model: NDArray[np.float64]  # of the brightness of each observation
    residual: NDArray[np.float64]  # brightness less model
    names: list[str]  # of those that were fitted
    chi_square: float
    degrees_of_freedom: int
    probability: float  # of so large a chi-square or a larger one
    remarks: list[str]  # caveats, in words


def fit(
    brightness: ArrayLike,
    sigma: ArrayLike,
    mu_out: ArrayLike,
    *,
    mu_in: ArrayLike = 1.0,
    azimuth: ArrayLike = 0.0,
    side: str | Sequence[str] = "lit",
    table: Table | None = None,
    phase_function: PhaseFunction | str | None = None,
    second_phase_function: PhaseFunction | str | None = None,
    single: bool = False,
    family: Mapping[str, ArrayLike] | None = None,
    fixed: Mapping[str, float] | None = None,
    free: Sequence[str] = (),
    density: float = 0.0,
    opposition: Opposition | None = None,
) -> Fit:
    """Fits a layer to observations, which broadcast.

    Albedos, the optical depth and the parameters that a table's family varies are free unless they are
    fixed; a family's also where they are known of the observations.

    brightness  I/F = mu_in R on the side "lit", mu_in T on the side "unlit", I/F0 of a "beam"
    sigma       its standard deviation
    mu_in, mu_out, azimuth  cosines (0, 1], radians; of a beam mu_out alone counts
    table       predicts all orders; or, in place of it:
    phase_function, second_phase_function
                of one or two kinds of particles: all orders are solved, or with `single` light
                scattered once alone; neither: beams alone
    family      what is known of the parameters of a table's family, observation by observation:
                {"wavelength": [0.55, 0.65]}, lengths in um
    fixed       parameters that are held, by name
    free        asymmetries to fit, too, of Henyey-Greenstein functions: "g", "g1", "g2"
    density, opposition
                as of `Table.bind`

    Errors   ValueError for fewer observations than parameters, for one out of range or of light
             that the model does not know, and for parameters that the model does not have.
    """
    if table is not None and (phase_function is not None or single):
        raise ValueError("fit: table must come without phase_function and single, got both")
    if phase_function is None and (second_phase_function is not None or single):
        raise ValueError("fit: second_phase_function and single must come with phase_function, got none")
    known = dict(family or {})
    arrays, shape = broadcast(
        "fit", np.float64, mu_in=mu_in, mu_out=mu_out, azimuth=azimuth, brightness=brightness, sigma=sigma, **known)
    sides = np.broadcast_to(np.asarray(side), shape).reshape(-1).tolist()
    for name in sides:
        if name not in _SIDES:
            raise ValueError(f"fit: side must be lit, unlit or beam, got {name}")
    if table is None and phase_function is None and any(name != "beam" for name in sides):
        raise ValueError("fit: table or phase_function must be given unless all sides are beams, got neither")
    found = _stratus.fit(
        table._own if table is not None else None,
        as_phase_function(phase_function)._own if phase_function is not None else None,
        as_phase_function(second_phase_function)._own if second_phase_function is not None else None,
        single,
        arrays[:5],
        [_SIDES[name] for name in sides],
        dict(zip(known, arrays[5:])),
        {name: number("fit", f"fixed {name}", value) for name, value in (fixed or {}).items()},
        list(free),
        number("fit", "density", density),
        opposition_parts(opposition),
    )
    count = len(found["names"])
    for name in ("covariance", "correlation"):
        found[name] = found[name].reshape(count, count)
    found["model"] = found["model"].reshape(shape)[()]
    return Fit(residual=arrays[3].reshape(shape)[()] - found["model"], **found)
