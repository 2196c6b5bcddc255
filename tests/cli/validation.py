"""Runs the commands of docs/validation.md, and compares what they print with the tables below them.

Usage: validation.py PROGRAM SOURCE

The last number of every line that a command prints belongs to a row of its table, whose last cells are what the literature
prints and what Stratus finds. Both must agree with it: the latter to its digits, the former to half a unit of its last
digit, or to so many units as the row's cell says in parentheses.
"""

import pathlib
import re
import subprocess
import sys

program, source = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
page = (source / "docs" / "validation.md").read_text(encoding="utf-8")
sections = page.split("```sh\n")[1:]
assert len(sections) >= 6, len(sections)
rows = wrong = 0
for section in sections:
    command, text = section.split("```\n", 1)
    table = [line.strip("| ").split(" | ") for line in text.split("\n## ")[0].splitlines() if line.startswith("|")][2:]
    told = subprocess.run(["bash", "-euo", "pipefail", "-c", command.replace("build/cli/stratus", str(program))],
                          cwd=source, check=True, capture_output=True, text=True).stdout.splitlines()
    assert len(told) == len(table), (command, len(told), len(table))
    for line, cells in zip(told, table):
        found = float(line.split()[-1])
        printed, units = re.fullmatch(r"([-0-9.]+)(?: \((\d+)\))?", cells[-2]).groups()
        unit = 10.0 ** -len(printed.partition(".")[2])
        digits = len(cells[-1].partition(".")[2])
        if abs(found - float(printed)) > (int(units) if units else 0.5) * unit + 1e-12 or f"{found:.{digits}f}" != cells[-1]:
            print(f"{cells}: {found}")
            wrong += 1
        rows += 1
sys.exit(f"{wrong} of {rows} rows") if wrong else None
