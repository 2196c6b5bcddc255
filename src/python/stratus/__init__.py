"""Multiple scattering of light in layers: solved, baked into tables, looked up.

    import stratus

    table = stratus.bake("recipe.toml")                    # or stratus.load("table.h5")
    bsdf = table.bsdf(optical_depth=1.5, albedo=0.95)      # one layer
    bsdf.reflection(0.8, 0.8, 1.57)                        # R at mu_in, mu_out, azimuth

Conventions are those of all of Stratus: R = pi I / (mu0 F0), a white Lambert surface has R = 1,
azimuth 0 is the forward side, angles are radians. Arguments broadcast as NumPy's do. Bad arguments
raise ValueError, files that cannot be opened OSError. Other Python threads run during every long
call but the reading and writing of .h5 and .exr files.
"""

from ._fit import Fit, fit
from ._phase import PhaseFunction, phase_function_help
from ._scene import EffectShare, LeftOut, Plan, ScenePlan, plan, render
from ._slice import Bsdf, Sample, Slice
from ._solve import (
    Directions, Fluxes, FluxesInside, Light, LightInside, Stack, directions, fluxes, solve, solve_stack,
    solve_stack_inside, stack_fluxes, stack_fluxes_inside,
)
from ._stratus import version as __version__
from ._table import EffectOptions, Table, bake, bind_single, load

__all__ = [
    "Bsdf", "Directions", "EffectOptions", "EffectShare", "Fit", "Fluxes", "FluxesInside", "LeftOut", "Light",
    "LightInside", "PhaseFunction", "Plan", "Sample", "ScenePlan", "Slice", "Stack", "Table", "bake", "bind_single",
    "directions", "fit", "fluxes", "load", "phase_function_help", "plan", "render", "solve", "solve_stack",
    "solve_stack_inside", "stack_fluxes", "stack_fluxes_inside",
]
