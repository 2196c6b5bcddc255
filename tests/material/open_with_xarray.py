"""Opens the netCDF file of `stratus export` with xarray and checks what Eradiate checks before it takes one.

Usage: open_with_xarray.py STRATUS STACK.toml. Exits 77 (skipped) where a package is missing.
"""

import pathlib
import subprocess
import sys
import tempfile

try:
    import h5netcdf  # noqa: F401  (xarray's engine)
    import numpy
    import xarray
except ImportError as missing:
    print(missing)
    sys.exit(77)

AXES = ["cos_theta_o", "phi_d", "cos_theta_i"]

with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder) / "material.nc"
    subprocess.run([sys.argv[1], "export", sys.argv[2], "--format", "netcdf", "-o", path, "--quiet"], check=True)
    with xarray.open_dataset(path, engine="h5netcdf") as material:
        assert list(material["brdf"].dims) == AXES, material["brdf"].dims
        assert material["brdf"].attrs["units"] == "sr**-1"
        for axis in AXES:
            coordinate = material.coords[axis]
            assert coordinate.attrs["units"] == ("rad" if axis == "phi_d" else "1"), axis
            count = len(coordinate)
            even = (
                numpy.linspace(0, 2 * numpy.pi, count, endpoint=False)
                if axis == "phi_d"
                else numpy.linspace(0, 1, count)
            )
            assert numpy.allclose(coordinate, even), axis
        values = material["brdf"].values
        assert numpy.isfinite(values).all() and (values > 0).all()
        assert numpy.allclose(values, values.transpose(2, 1, 0))  # reciprocity
