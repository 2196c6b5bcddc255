"""Opens a table with the programs that come with OpenEXR.

Usage: open_with_openexr_tools.py WRITE_SAMPLE_TABLE. Exits 77 (skipped) where none is installed.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

EXRINFO = ["exrinfo", "--strict", "--verbose"]
COMMANDS = [["exrheader"], EXRINFO, ["exrcheck"]]
COMMANDS = [command for command in COMMANDS if shutil.which(command[0])]
if not COMMANDS:
    print("no OpenEXR programs are installed")
    sys.exit(77)

PARTS = [
    "reflection_multiple",
    "transmission_multiple",
    "plane_albedo",
    "diffuse_transmittance",
    "spherical_albedo",
]

with tempfile.TemporaryDirectory() as folder:
    table_path = pathlib.Path(folder) / "table.exr"
    subprocess.run([sys.argv[1], table_path], check=True)
    for command in COMMANDS:
        done = subprocess.run(command + [table_path], capture_output=True, text=True)
        if command == EXRINFO:  # its exit code is random in OpenEXR 3.1.5, which does not set it
            assert not done.stderr, done.stderr
            assert all(f": {part}\n" in done.stdout for part in PARTS), done.stdout
            continue
        assert done.returncode == 0, (command, done.stdout, done.stderr)
        if command[0] == "exrheader":
            for part in PARTS:
                assert f'name (type string): "{part}"' in done.stdout, part
            assert 'stratus:format (type string): "stratus-table"' in done.stdout
            assert "tiles, one row of tiles per albedo" in done.stdout
    if EXRINFO in COMMANDS:  # what it finds wrong it says
        table_path.write_bytes(table_path.read_bytes()[:3000])
        damaged = subprocess.run(EXRINFO + [table_path], capture_output=True, text=True)
        assert "ERROR" in damaged.stderr, damaged
