"""Every room includes itself and rooms below it alone. Of other rooms it includes public headers, which are installed, and internal
ones, which rooms share (src/internal/stratus/ROOM), but no private ones; the five floors of the runtime, which are one library,
include private headers of lower floors too. A public header includes public ones and the standard library alone.

    includes_point_downward.py SOURCE_FOLDER
"""
import re
import sys
from pathlib import Path

# Rooms from the ground up; those of one line do not include one another.
STOREYS = """base
phase
layer
table
bsdf
transfer io
bake picture
material scene shader fit
view
c ranks
cli python"""
HEIGHT = {room: height for height, line in enumerate(STOREYS.splitlines()) for room in line.split()}
FLOORS = STOREYS.split()[:5]
INTERNAL = Path("src/internal")


def room_of(path):
    """None for include/stratus/*.h, pages of whole interfaces."""
    if path.parts[0] == "cli":
        return "cli"
    if path.parts[:2] == ("src", "internal"):
        return path.parts[3]
    if path.parts[0] == "include":
        return path.parts[2] if len(path.parts) > 3 else None
    return path.parts[1]


def header_of(root, file, name):
    """The file that `#include NAME` means in a file; None for one that is not of this project, or made by the build."""
    if name[0] == "<":
        return next((top / name[1:-1] for top in (Path("include"), INTERNAL) if (root / top / name[1:-1]).exists()), None)
    beside = (root / file.parent / name[1:-1]).resolve()
    if beside.exists():
        return beside.relative_to(root)
    return next((path.relative_to(root) for path in sorted((root / "src").rglob(name[1:-1]))), None)


def complaints(root):
    sources = [path for top in ("include", "src", "cli", "tests", "bench") for path in sorted((root / top).rglob("*.*"))
               if path.suffix in (".h", ".cpp", ".c")]
    read = 0
    shared = {path.relative_to(root): False for path in (root / INTERNAL).rglob("*.h")}
    for source in sources:
        file = source.relative_to(root)
        room = room_of(file)
        is_public = file.parts[0] == "include"
        for name in re.findall(r'^ *# *include (<[^>]+>|"[^"]+")', source.read_text(), re.M):
            header = header_of(root, file, name)
            if is_public and (header is None and re.search(r"[./]", name) and room or header and header.parts[0] != "include"):
                yield f"{file}, a public header, includes {name}, which is not installed with it"
            if header is None:
                continue
            read += 1
            other = room_of(header)
            if header in shared:
                shared[header] |= other != room or INTERNAL in file.parents
            if file.parts[0] in ("tests", "bench") or None in (room, other) or other == room:
                continue
            if room not in HEIGHT or other not in HEIGHT:
                yield f"{file} includes {header}: the storeys lack one of both rooms"
            elif HEIGHT[other] >= HEIGHT[room]:
                yield f"{file} includes {header}, which is not below it"
            elif header.parts[0] != "include" and header not in shared and not (room in FLOORS and other in FLOORS):
                yield f"{file} includes {header}, a private header of another room"
    if read < 1000:
        yield f"only {read} includes were read"
    for header in sorted(header for header, is_shared in shared.items() if not is_shared):
        yield f"{header} is shared by no two rooms: it is a private header of src/{room_of(header)}"


found = list(complaints(Path(sys.argv[1]).resolve()))
print(*found, sep="\n", end="\n" if found else "")
sys.exit(bool(found))
