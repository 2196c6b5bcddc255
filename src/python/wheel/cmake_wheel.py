"""What `pip install .` runs: the package built by CMake, put into a wheel.

A build backend (PEP 517) of its own, in the standard library alone, so that neither a network nor a
package of Python's is needed. `--config-settings build-folder=build` builds in a folder that is there already.
"""

import base64
import hashlib
import pathlib
import re
import subprocess
import sys
import sysconfig
import zipfile

SOURCE = pathlib.Path(__file__).resolve().parents[3]
CHOICES = {"CMAKE_BUILD_TYPE": "Release", "STRATUS_BUILD_PYTHON": "ON", "STRATUS_BUILD_TESTS": "OFF", "STRATUS_UNITY": "ON"}
TARGETS = ("stratus_python", "stratus_python_package")


def _version() -> str:
    return re.search(r"project\(stratus VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text())[1]


def _tag() -> str:
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def _built(folder: pathlib.Path) -> pathlib.Path:
    """The package in the build folder."""
    if not (folder / "CMakeCache.txt").exists():
        choices = CHOICES | {"Python_EXECUTABLE": sys.executable}
        subprocess.run(["cmake", "-S", SOURCE, "-B", folder, *(f"-D{name}={value}" for name, value in choices.items())], check=True)
    subprocess.run(["cmake", "--build", folder, "--parallel", "--target", *TARGETS], check=True)
    return folder / "src" / "python" / "stratus"


def _about() -> dict[str, bytes]:
    """Files that say what is installed."""
    version = _version()
    return {
        f"stratus-{version}.dist-info/METADATA":
            f"Metadata-Version: 2.1\nName: stratus\nVersion: {version}\nRequires-Python: >=3.10\nRequires-Dist: numpy\n".encode(),
        f"stratus-{version}.dist-info/WHEEL":
            f"Wheel-Version: 1.0\nGenerator: cmake_wheel\nRoot-Is-Purelib: false\nTag: {_tag()}\n".encode(),
    }


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    for name, content in _about().items():
        path = pathlib.Path(metadata_directory) / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
    return path.parent.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    package = _built(pathlib.Path((config_settings or {}).get("build-folder", SOURCE / "build-wheel")))
    extension = "_stratus" + sysconfig.get_config_var("EXT_SUFFIX")
    if not (package / extension).exists():
        raise RuntimeError(f"{package}: must hold {extension}, of the Python that installs it")
    files = {f"stratus/{path.name}": path.read_bytes() for path in sorted(package.glob("*.py"))}
    for name in (extension, "py.typed"):
        files[f"stratus/{name}"] = (package / name).read_bytes()
    files |= _about()
    record = ""
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    record_name = f"stratus-{_version()}.dist-info/RECORD"
    files[record_name] = (record + f"{record_name},,\n").encode()
    wheel = f"stratus-{_version()}-{_tag()}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return wheel


def build_sdist(sdist_directory, config_settings=None):
    raise NotImplementedError("stratus is installed from its source tree: pip install .")
