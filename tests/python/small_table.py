"""A small table, baked once for all tests of a program."""

import functools
import warnings

import stratus

RECIPE = """
title = "Looked up from Python"
phase_function = "henyey_greenstein:g=0.4"
tolerance = 1e-2
optical_depth = { min = 0.5, max = 2.0 }
albedo = { min = 0.75, max = 1.0 }
[discretisation]
nodes = 12
modes = 9
mu_samples = 16
azimuth_samples = 8
optical_depth_samples_per_octave = 5
albedo_samples = 4
"""


@functools.cache
def small_table(more: str = "") -> stratus.Table:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return stratus.bake(RECIPE + more)
