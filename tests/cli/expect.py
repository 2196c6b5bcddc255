"""Tests of the command line stand on this file: they begin with `from expect import *` and end with `finish()`.

    NAME_test.py STRATUS MAKE_FIXTURE_TABLE

Each test runs in an empty folder of its own, which is removed at its end, with a cache of tables of its own. A test prints
nothing when it passes; an expectation that fails is told with its line, and the test goes on. Commands are written as in a
shell. What a text must say is written as "one fragment | another".
"""

import csv
import io
import json
import math
import os
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import traceback
import xml.dom.minidom
from pathlib import Path
from types import SimpleNamespace

if len(sys.argv) != 3:
    sys.exit(f"usage: {sys.argv[0]} STRATUS MAKE_FIXTURE_TABLE")
stratus, make_fixture = (str(Path(program).resolve(strict=True)) for program in sys.argv[1:])
source = Path(__file__).resolve().parents[2]
sanitized = b"__asan_init" in Path(stratus).read_bytes()  # tests may end before what unsanitized libraries alone do

_own = tempfile.TemporaryDirectory()
logs = Path(_own.name, "logs")  # for what must not count as a file of the test's folder
folder = Path(_own.name, "folder")
for made in (logs, folder, folder / "disk", folder / "shut"):
    made.mkdir()
os.chdir(folder)
os.environ.update(LC_ALL="C", STRATUS_CACHE=str(logs / "cache"))
# Fontconfig, which draws the pictures' words, keeps its cache to the end; HDF5 loses memory on damaged files.
(logs / "not_ours").write_text("leak:libfontconfig\nleak:libhdf5\n")
_given = os.environ.get("LSAN_OPTIONS")
os.environ["LSAN_OPTIONS"] = f"{_given + ':' if _given else ''}suppressions={logs}/not_ours:print_suppressions=0"
for _signal in signal.SIGINT, signal.SIGHUP:  # which background jobs ignore, and so would the program
    signal.signal(_signal, signal.SIG_DFL)

_failures = 0


class Answer:
    """Holds what a command said: its exit code, both texts, and standard output as CSV or as JSON."""

    def __init__(self, command="", code=0, out="", err=""):
        self.command, self.code, self.out, self.err = command, code, out, err
        self.header = out.partition("\n")[0]

    @property
    def rows(self):
        """The rows of a CSV table, as objects with a number, or else a text, for each column."""
        return [SimpleNamespace(**{column: number(cell) for column, cell in row.items()})
                for row in csv.DictReader(io.StringIO(self.out))]

    @property
    def row(self):
        return self.rows[0]

    @property
    def json(self):
        return json.loads(self.out, object_hook=lambda keys: SimpleNamespace(**keys))


_last = Answer()


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


def expect(condition, sentence):
    """Notes a failure where the condition does not hold, and shows what the last command said."""
    global _failures
    if condition:
        return
    _failures += 1
    line = next(frame.lineno for frame in reversed(traceback.extract_stack()) if frame.filename != __file__)
    print(f"FAILED, line {line}: {sentence}\n  after: stratus {_last.command}", file=sys.stderr)
    for name, text in (("stdout", _last.out), ("stderr", _last.err)):
        for shown in text.splitlines()[:20]:
            print(f"    {name}: {shown}", file=sys.stderr)


def finish():
    sys.exit(f"{_failures} failed" if _failures else 0)


def write(name, *lines):
    Path(name).write_text("".join(line + "\n" for line in lines))


def read(name):
    return Path(name).read_bytes().decode(errors="replace")


def edit(name, target, *replacements):
    """Writes the text of a file with replacements (old, new), each of which must change it, to another."""
    text = read(name)
    for old, new in replacements:
        assert old in text, (name, old)
        text = text.replace(old, new)
    Path(target).write_text(text)


def fixtures(*kinds):
    for kind in kinds:
        subprocess.run([make_fixture, kind, kind + ".h5"], check=True)


def snapshot():
    """Returns the bytes of every file of the folder."""
    return {path: path.read_bytes() for path in Path().rglob("*") if path.is_file() and not path.is_symlink()}


def start(command, through=(), program=stratus, **how):
    """Starts the program, through the words of another command if any."""
    how = dict(stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace") | how
    return subprocess.Popen([*through, program, *shlex.split(command)], **how)


def ended(process, command, stdin=""):
    """Returns what a process said, once it has ended."""
    global _last
    out, err = process.communicate(stdin)
    _last = Answer(command, process.returncode, out or "", err or "")
    return _last


def run(command, stdin="", **how):
    return ended(start(command, stdin=subprocess.PIPE, **how), command, stdin)


def interrupt(command, seconds, sent):
    """Runs a command, which is sent a signal unless it ends in so many seconds."""
    process = start(command)
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        process.send_signal(sent)
    return ended(process, command)


def cases(*texts):
    """Splits each "SOMETHING => FRAGMENTS"."""
    return [text.split(" => ") for text in texts]


def expect_says(text, fragments, name="the text"):
    for fragment in fragments.split(" | "):
        expect(fragment in text, f"{name} does not say '{fragment}'")


def expect_ok(command, code=0, out=None, err=None, header=None, **how):
    """Runs a command that must exit with this code; out and err are what it must say, "" for nothing, header its first line."""
    said = run(command, **how)
    expect(said.code == code, f"exit code {said.code}, expected {code}")
    expect(header in (None, said.header), f"the first line must be {header}")
    for name, text, wanted in (("stdout", said.out, out), ("stderr", said.err, err)):
        if wanted == "":
            expect(not text, f"{name} must be empty")
        elif wanted:
            expect_says(text, wanted, name)
    return said


def expect_refused(*refusals, prefix="", code=2, **how):
    """Expects of each "ARGUMENTS => FRAGMENT | FRAGMENT" this exit code, nothing on standard output, one line of standard error
    that says the fragments, and no file of the folder made, changed or removed. The prefix precedes all arguments."""
    before = snapshot()
    for arguments, fragments in cases(*refusals):
        said = expect_ok(prefix + arguments, code, out="", err=fragments, **how)
        expect(said.err.startswith("stratus: ") and said.err.count("\n") == 1, "one line must begin with 'stratus: '")
        expect(snapshot() == before, "files differ after the refusal")


def expect_same(*names):
    for name in names[1:]:
        expect(Path(name).read_bytes() == Path(names[0]).read_bytes(), f"{names[0]} and {name} must be the same")


def expect_differ(one, other, why):
    expect(Path(one).read_bytes() != Path(other).read_bytes(), f"{one} and {other}: {why}")


def expect_near(met, expected, tolerance):
    expect(abs(met - expected) <= tolerance, f"{met} must be {expected} within {tolerance}")


def expect_rows(said, count, condition="True"):
    """The answer has so many rows, and the condition, an expression of its columns, holds for each."""
    rows = said.rows
    expect(len(rows) == count, f"{len(rows)} rows, expected {count}")
    for row in rows:
        expect(eval(condition, vars(math) | vars(row)), f"'{condition}' does not hold for {row}")


def expect_svg(name):
    expect(xml.dom.minidom.parse(name).documentElement.tagName == "svg", f"{name} must be an SVG")


# How writing fails: by a limit on the size of a file; on a disk of 16 KiB that only this program sees, mounted on the folder
# `disk`, where a file `older.*` must come to no harm; and as a user whom the folder `shut` refuses. The last two are None
# where the machine permits no such thing.
def size_limited(bytes=4096):
    return dict(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (bytes, bytes)))


def _permitted(*command):
    return bool(shutil.which(command[0])) and subprocess.run(command, capture_output=True).returncode == 0


_root = os.getuid() == 0
_mounts = ["unshare", *([] if _root else ["--map-root-user"]), "--mount", "bash", "-c"]
_mount = "mount -t tmpfs -o size=16k none disk"
_on_disk = _mount + """; echo older >disk/older.h5; cp disk/older.h5 disk/older.csv
    "$@"; code=$?
    for file in disk/older.*; do [ "$(cat $file)" = older ] || echo "$file is harmed" >&2; done
    find disk -type f ! -name 'older.*' >&2; exit $code"""
small_disk = dict(through=[*_mounts, _on_disk, "bash"]) if _permitted(*_mounts, _mount) else None
user_refused = {}
if _root:
    for reached in (Path(_own.name), folder):
        reached.chmod(0o755)
    _nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    user_refused = dict(through=_nobody) if _permitted(*_nobody, stratus, "--version") else None
else:
    Path("shut").chmod(0o555)


def where_permitted(way):
    """Whether the machine permits this way of failing; says so where not."""
    if way is None:
        print("skipped: a way of failing that this machine does not let us make")
    return way is not None


def expect_every_output(command):
    """An answer may go to a new file, in place of an older one, and behind what a device, a pipe or an open file holds."""
    text = expect_ok(command).out
    for target in "-o -", "-o /dev/stdout":
        expect(expect_ok(f"{command} {target}").out == text, f"{target} must be standard output")
    for _ in "new", "older":
        expect_ok(command + " -o out.csv", out="")
        expect(read("out.csv") == text, "out.csv must hold the answer")
        write("out.csv", "older")
    expect_ok(command + " -o /dev/null")
    with open("kept", "a") as kept:
        print("before", file=kept, flush=True)
        expect_ok(command + " -o /dev/stdout", stdout=kept)
        print("after", file=kept)
    expect(read("kept") == f"before\n{text}after\n", "an open file must keep what it holds")
    os.mkfifo("pipe")
    reader = subprocess.Popen(["timeout", "20", "cat", "pipe"], stdout=subprocess.PIPE, text=True)
    expect_ok(command + " -o pipe")
    expect(reader.communicate()[0] == text, "a pipe must take the answer")


def expect_full(command, fragments="standard output: No space left"):
    """Standard output on a disk that is full must be an error."""
    if os.access("/dev/full", os.W_OK):
        with open("/dev/full", "w") as full:
            said = run(command, stdout=full)
        expect(said.code == 1, "an answer that could not be written must not exit 0")
        expect_says(said.err, fragments)
