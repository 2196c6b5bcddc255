"""Scenes: plans, which say what effects change and cost, and pictures."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _stratus
from ._errors import builtin_errors, text_or_path, warn


@dataclass(frozen=True)
class LeftOut:
    """An effect that is left out, and the largest relative change that this makes."""

    name: str
    change: float  # estimated, of any light in the scene
    found: float  # at an exact geometry
    where: str


@dataclass(frozen=True)
class EffectShare:
    """What one effect does to a picture, and costs."""

    name: str
    seen: bool  # by the camera; not: nothing below counts
    mean: float  # relative change of a sparse picture
    max: float
    estimated: bool  # max is an estimate over all that the scene contains, not one pixel's
    where: str  # of max
    fate: str  # kept or left out, and why
    table_seconds: float  # of one processor, that tables take more for it


@dataclass(frozen=True)
class ScenePlan:
    """The plan of one picture of a scene file, or of a panel of a film in all its frames."""

    title: str
    tolerance: float
    effects: list[str]  # that remain
    left_out: list[LeftOut]
    recipes: list[str]  # TOML of the tables that it needs; of colours that are not alike one each
    shares: list[EffectShare] = field(default_factory=list)  # where measured
    orders: dict[str, list[float]] = field(default_factory=dict)  # by side, "lit" or "unlit": order n's share, [n - 1]


@dataclass(frozen=True)
class Plan:
    scenes: list[ScenePlan]
    # Of one processor, that rendering all of them takes, of a film the first frame; not-a-number unless measured.
    seconds: float


def plan(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    *,
    tolerance: float | None = None,
    drop: Sequence[str] = (),
    measure: bool = False,
    threads: int = 0,
    progress: Callable[[float, str], object] | None = None,
) -> Plan:
    """Which effects a scene needs, and the recipes of its tables.

    Of a film ([animation]) the plan leaves out what the plans of all frames do, and the recipes serve every
    frame; what is measured is the first frame's.

    scene      TOML text, a dict in its place, or the path of a scene file: an os.PathLike, or a str that
               ends in .toml
    tolerance  relative change of a pixel, [1e-6, 0.5], in place of the scene's own
    drop       effects to leave out whatever they change
    measure    also what each effect changes and costs, on a sparse picture
    progress   as of `bake`, of measuring

    Errors   ValueError naming the key, the allowed range and the value met; OSError for a file that
             cannot be opened.
    """
    source = text_or_path(scene)
    with builtin_errors(*source):
        told, seconds, notes = _stratus.plan(*source, tolerance, list(drop), measure, threads, progress)
    warn(notes)
    for one in told:
        one["left_out"] = [LeftOut(*effect) for effect in one["left_out"]]
        one["shares"] = [EffectShare(*share) for share in one.get("shares", ())]
    scenes = [ScenePlan(**one) for one in told]
    return Plan(scenes, seconds)


def render(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    *,
    frame: int = 0,
    effects: Sequence[str] = (),
    drop: Sequence[str] = (),
    width: int | None = None,
    table: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
    cache: bool = True,
    threads: int = 0,
    progress: Callable[[float, str], object] | None = None,
) -> NDArray[np.float32]:
    """The picture of a scene, its panels side by side: linear radiance, (height, width, 3), the upper row first.

    Radiance is relative to that of a white Lambert surface which faces the sun. The numbers are those that
    `stratus render` writes to an .exr file.

    scene     as of `plan`; files that text or a dict names are looked for in the working directory
    frame     of the scene's [animation], from 0; tables are made for all its frames, and kept
    effects   in place of the scene's own, all of which are then simulated: "all", "NAME", "-NAME"
    drop      effects to leave out whatever they change
    width     in pixels, [1, 16384], in the scene's shape
    table     paths of tables to look up in place of baking, as `plan` has recipes
    cache     keep tables for the next picture, and use those that are kept, as the program does
    progress  as of `bake`

    Errors   ValueError naming the key or argument, the allowed range and the value met; OSError for a file
             that cannot be opened.
    """
    source = text_or_path(scene)
    tables = [table] if isinstance(table, (str, os.PathLike)) else list(table)
    with builtin_errors(*source):
        light, height, across, notes = _stratus.render(
            *source, frame, list(effects), list(drop), width, [os.fspath(each) for each in tables], cache,
            threads, progress,
        )
    warn(notes)
    return light.reshape(height, across, 3)
