"""`pip install .` from the source tree, without a network, in a build folder that is there.

Usage: wheel_test.py SOURCE BUILD. Exits 77 (skipped) where pip is missing.
"""

import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile

if importlib.util.find_spec("pip") is None:
    print("no pip")
    sys.exit(77)
source, build = sys.argv[1:]
with tempfile.TemporaryDirectory() as folder:
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--no-cache-dir", "--target", folder,
         "--config-settings", f"build-folder={build}", source],
        check=True, env={**os.environ, "PIP_ROOT_USER_ACTION": "ignore", "PIP_DISABLE_PIP_VERSION_CHECK": "1"})
    told = subprocess.run(
        [sys.executable, "-c", "import stratus; print(stratus.__file__, stratus.fluxes('isotropic', 1, 1).plane_albedo[0])"],
        check=True, capture_output=True, text=True, cwd="/", env={**os.environ, "PYTHONPATH": folder}).stdout.split()
    assert pathlib.Path(told[0]).is_relative_to(folder), told
    assert abs(float(told[1]) - 0.34133) < 6e-6, told  # [vdH80]
    assert list(pathlib.Path(folder).glob("stratus-*.dist-info/RECORD"))
