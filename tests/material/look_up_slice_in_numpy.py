"""The documented lookup of a slice in numpy, at random pairs beside the solver.

    look_up_slice_in_numpy.py STRATUS LOOK_UP_SLICE.py STACK.toml
"""

import csv
import importlib.util
import pathlib
import re
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    sys.exit(77)

stratus, example, stack = sys.argv[1:4]
specification = importlib.util.spec_from_file_location("look_up_slice", example)
look_up_slice = importlib.util.module_from_spec(specification)
specification.loader.exec_module(look_up_slice)

with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    # Without its ground the stack transmits, and looks otherwise from below.
    free = folder / "free.toml"
    free.write_text(pathlib.Path(stack).read_text().split("[below]")[0])
    exported, query = folder / "free.safetensors", folder / "query.csv"
    subprocess.run([stratus, "export", free, "--format", "slice", "-o", exported, "--quiet"],
                   check=True)
    random = np.random.default_rng(1)
    mu_in, mu_out = random.uniform(0.01, 1, (2, 500))
    degrees = random.uniform(0, 360, 500)
    with open(query, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["mu_in", "mu_out", "azimuth_deg"])
        rows.writerows(zip(mu_in, mu_out, degrees))
    answer = subprocess.run([stratus, "solve", "--layers", free, "--query", query, "--nodes", "48"],
                            check=True, capture_output=True, text=True).stdout
    expected = list(csv.DictReader(answer.splitlines()))
    arrays = look_up_slice.read_arrays(exported)

assert "reflection_below" in arrays
# The ten lines of the page, for one pair at a time.
page = (pathlib.Path(example).parents[1] / "exports.md").read_text()
documented = {"numpy": np}
exec(re.search(r"```python\n(def look_up.*?)```", page, re.DOTALL)[1], documented)
for i in range(20):
    azimuth = np.radians(min(degrees[i], 360 - degrees[i]))
    found = documented["look_up"](arrays["transmission"], mu_in[i], mu_out[i], azimuth)
    same = look_up_slice.look_up(arrays["transmission"], mu_in[i:i + 1], mu_out[i:i + 1], np.array([azimuth]))
    assert np.allclose(found, same[:, 0], rtol=1e-6), (found, same)
for name in "reflection", "transmission", "reflection_multiple", "transmission_multiple":
    solved = np.array([float(row[name]) for row in expected])
    found = look_up_slice.look_up(arrays[name], mu_in, mu_out, np.radians(degrees))
    assert found.shape == (1, 500), found.shape
    errors = np.sort(abs(found[0] / solved - 1))
    print(f"{name}: median {errors[250]:.2e}, 99 % within {errors[494]:.2e}")
    # The file's samples are 1.5 degrees apart; lines between them are off by as much as exports.md has.
    assert errors[250] < 5e-4 and errors[494] < 1e-2, name
