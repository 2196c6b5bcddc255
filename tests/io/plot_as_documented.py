"""Runs the Python block of docs/tables.md on a sample table at the path that it reads.

Usage: plot_as_documented.py WRITE_SAMPLE_TABLE TABLES_MD. Exits 77 (skipped) where a package is missing.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

try:
    import h5netcdf  # noqa: F401  (xarray's engine)
    import matplotlib
    import xarray  # noqa: F401
except ImportError as missing:
    print(missing)
    sys.exit(77)

matplotlib.use("agg")
text = pathlib.Path(sys.argv[2]).read_text(encoding="utf-8")
lines = text.split("```python\n")[1].split("```")[0]
assert len(lines.splitlines()) == 5, lines
writer = pathlib.Path(sys.argv[1]).resolve()

with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    os.mkdir("baked")
    os.mkdir("docs")
    subprocess.run([writer, "baked/saturn_rings.h5"], check=True)
    exec(lines, {})
    assert pathlib.Path("docs/slice.png").read_bytes().startswith(b"\x89PNG")
