"""docs/examples/packed_lookup.py against the runtime's own lookup of packed tables, to 1e-5.

Usage: packed_lookup_test.py FOLDER_OF_THE_EXAMPLE
"""

import pathlib
import sys
import tempfile
import warnings

import numpy as np
import stratus
from small_table import RECIPE

sys.path.insert(0, sys.argv[1])
import packed_lookup  # noqa: E402

assert len(pathlib.Path(packed_lookup.__file__).read_text().splitlines()) <= 60
TINY = """
tolerance = 0.1
[discretisation]
nodes = 6
modes = 3
mu_samples = 8
"""


def recipe(phase_function, albedo, depth, more=""):
    top, choices = TINY.split("[discretisation]")
    ranges = f"albedo = {{ min = {albedo[0]}, max = {albedo[1]} }}\noptical_depth = {{ min = {depth[0]}, max = {depth[1]} }}\n"
    return f'phase_function = "{phase_function}"\n{ranges}{top}[discretisation]{choices}{more}'


# Many blocks of layers; one albedo and no azimuth, thinner layers too; few samples of albedo and depth; azimuths in their square root.
TABLES = {
    "usual": (RECIPE, (0.75, 1.0), (0.5, 2.0)),
    "blocks": (recipe("rayleigh", (0.0, 1.0), (0.01, "inf"), "deepest_optical_depth = 64.0"), (0.0, 1.0), (0.01, 60.0)),
    "isotropic": (recipe("isotropic", (0.9, 0.9), (0.1, 8.0)), (0.9, 0.9), (0.001, 8.0)),
    "few": (recipe("rayleigh", (0.9, 1.0), (0.5, 2.0), "albedo_samples = 2\noptical_depth_samples_per_octave = 1"),
            (0.9, 1.0), (0.5, 2.0)),
    "peaked": (recipe("henyey_greenstein:g=0.5", (0.8, 1.0), (1.0, 4.0),
                      'azimuth_samples = 9\nazimuth_scale = "square_root"\nalbedo_samples = 5\n'
                      'albedo_scale = "fourth_root_of_complement"'), (0.8, 1.0), (1.0, 4.0)),
}
random = np.random.default_rng(1982)
warnings.simplefilter("ignore", RuntimeWarning)  # tolerances are missed
with tempfile.TemporaryDirectory() as folder:
    for name, (text, albedos, depths) in TABLES.items():
        path = pathlib.Path(folder) / f"{name}.stratus"
        stratus.bake(text).save(path)
        theirs, mine = stratus.load(path), packed_lookup.PackedTable(path)
        count = 200
        at = (random.uniform(*albedos, count), np.exp(random.uniform(*np.log(depths), count)),
              random.uniform(0.001, 1, count), random.uniform(0.001, 1, count), random.uniform(0, np.pi, count))
        for side in ("reflection", "transmission"):
            expected = getattr(theirs, side)(*at, single=False)
            found = np.array([mine.multiple(side, *map(float, point)) for point in zip(*at)])
            wrong = np.abs(found - expected) > 1e-5 * expected + 1e-12
            assert not wrong.any(), (name, side, [column[wrong] for column in at], found[wrong], expected[wrong])
