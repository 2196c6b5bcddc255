"""Runs the Python blocks of a page, in its order, in an empty folder.

Usage: run_docs.py PAGE.md. Exits 77 (skipped) where a package is missing.
"""

import os
import pathlib
import sys
import tempfile

try:
    import matplotlib
    import xarray  # noqa: F401
except ImportError as missing:
    print(missing)
    sys.exit(77)

matplotlib.use("agg")
page = pathlib.Path(sys.argv[1])
blocks = [part.split("```")[0] for part in page.read_text(encoding="utf-8").split("```python\n")[1:]]
assert len(blocks) >= 7, len(blocks)
names = {}
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    for number, block in enumerate(blocks, 1):
        exec(compile(block, f"{page.name}, block {number}", "exec"), names)
    assert pathlib.Path("haze.png").read_bytes().startswith(b"\x89PNG")
