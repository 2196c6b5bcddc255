"""Opens a table with h5py, xarray and h5dump: axes have their names, order, values and units without any code of Stratus.

Usage: open_with_xarray.py WRITE_SAMPLE_TABLE. Exits 77 (skipped) where a package is missing.
"""

import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

try:
    import h5netcdf  # noqa: F401  (xarray's engine)
    import h5py
    import numpy
    import xarray
except ImportError as missing:
    print(missing)
    sys.exit(77)

AXES = ["albedo", "optical_depth", "mu_in", "mu_out", "azimuth"]
SIZES = [3, 5, 3, 2, 5]
SAMPLES = [
    "reflection_multiple",
    "transmission_multiple",
    "plane_albedo",
    "diffuse_transmittance",
    "spherical_albedo",
]
RANKS = dict(zip(SAMPLES, [5, 5, 3, 3, 2]), diffusion_exponent=1)


def check_with_h5py(path):
    with h5py.File(path) as file:
        made = []
        file.id.links.iterate(made.append, idx_type=h5py.h5.INDEX_CRT_ORDER)
        assert [name.decode() for name in made] == AXES + ["diffusion_exponent"] + SAMPLES, made
        assert file.attrs["format"] == b"stratus-table", file.attrs["format"]
        assert file.attrs["format_version"] == 1 and "features" not in file.attrs
        assert len(file.attrs["moments"]) == 64
        for axis in AXES:
            assert h5py.h5ds.is_scale(file[axis].id), axis
            assert file[axis].dtype == "<f8", axis
        for name, rank in RANKS.items():
            dataset = file[name]
            assert list(dataset.shape) == SIZES[:rank], name
            attached = [scales[0].name for scales in dataset.dims]
            assert attached == ["/" + axis for axis in AXES[:rank]], (name, attached)
            if rank == 5:
                assert dataset.dtype == "<f4" and dataset.compression == "gzip" and dataset.shuffle


def check_with_xarray(path):
    with xarray.open_dataset(path, engine="h5netcdf") as table:
        assert list(table.sizes) == AXES, list(table.sizes)
        for name, rank in RANKS.items():
            assert list(table[name].dims) == AXES[:rank], name
            assert table[name].attrs["units"] == "1", name
        for axis, size in zip(AXES, SIZES):
            assert table[axis].dims == (axis,) and table[axis].size == size, axis
            assert table[axis].attrs["units"] == ("radian" if axis == "azimuth" else "1"), axis
            assert table[axis].attrs["long_name"], axis
        assert numpy.allclose(table.albedo, [0, 0.75, 1], rtol=1e-14)
        assert table.optical_depth[0] == 0.01 and table.optical_depth[3] == 8
        assert math.isinf(table.optical_depth[4])
        assert numpy.allclose(table.azimuth, numpy.linspace(0, math.pi, 5), rtol=1e-14)
        assert table.attrs["title"] == "Saturn's rings, \u03c9 and \u03c4", table.attrs["title"]
        assert table.attrs["empty"] == "", table.attrs["empty"]
        slice_by_value = table.reflection_multiple.sel(albedo=1, mu_in=1, method="nearest")
        assert slice_by_value.dims == ("optical_depth", "mu_out", "azimuth")
        assert numpy.isfinite(table.reflection_multiple).all()


def check_mixtures(path):
    with h5py.File(path) as file:
        assert (file.attrs["features"], file.attrs["family"]) == (b"family", b"mixture")
        assert file.attrs["second_phase_function"].startswith(b"henyey_greenstein:g=0.33")
    with xarray.open_dataset(path, engine="h5netcdf") as table:
        assert list(table.sizes) == ["mixture"] + AXES, list(table.sizes)
        for name, rank in RANKS.items():
            assert list(table[name].dims) == ["mixture"] + AXES[:rank], name
        assert numpy.allclose(table.mixture, [0.125, 0.5625, 1], rtol=1e-14)
        assert table.mixture.attrs["scale"] == "identity" and table.mixture.attrs["long_name"]
        assert table.reflection_multiple.sel(mixture=1).dims == tuple(AXES)


def check_with_h5dump(path):
    if not shutil.which("h5dump"):
        return
    done = subprocess.run(["h5dump", path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for name in AXES + list(RANKS):
        assert f'DATASET "{name}"' in done.stdout, name


with tempfile.TemporaryDirectory() as folder:
    table_path = pathlib.Path(folder) / "table.h5"
    subprocess.run([sys.argv[1], table_path], check=True)
    check_with_h5py(table_path)
    check_with_xarray(table_path)
    check_with_h5dump(table_path)
    subprocess.run([sys.argv[1], table_path, "3"], check=True)
    check_mixtures(table_path)
