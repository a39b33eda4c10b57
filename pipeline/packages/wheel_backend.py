"""What pip asks for a wheel of the Python module (PEP 517): CMake builds it, the archive is made here.

The wheel needs the Python that builds it and the system's libraries, so its tag is linux, not manylinux.
"""

import base64
import hashlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
VERSION = re.search(r"VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text().split("project(", 1)[1])[1]
ABOUT = f"hexrelief-{VERSION}.dist-info"
METADATA = f"""Metadata-Version: 2.1
Name: hexrelief
Version: {VERSION}
Summary: Stereo pairs and disparity maps to compact, textured, metric 3D meshes
License: MIT
Requires-Python: >=3.9
Requires-Dist: numpy
"""


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Writes what pip wants to know before the wheel is built, which it would else be built for."""
    folder = Path(metadata_directory) / ABOUT
    folder.mkdir()
    (folder / "METADATA").write_text(METADATA)
    return ABOUT


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds, and returns the name of the wheel in wheel_directory.

    config_settings: variables of CMake, and `folder`, that of the build, which is kept; by default a temporary one.
    """
    settings = dict(config_settings or {})
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(settings.pop("folder", temporary)).absolute()
        settings = {"HEXRELIEF_TESTS": "OFF", "HEXRELIEF_BUILD_FOLDER": "", "HEXRELIEF_PYTHON": sys.executable, **settings}
        options = [f"-D{name}={value}" for name, value in settings.items()]
        for command in (
            ["-S", ROOT, "-B", folder, "-G", "Ninja", *options],
            ["--build", folder, "--target", "hexrelief_python"],
        ):
            subprocess.run(["cmake", *command], check=True, stdout=sys.stderr)
        module = sorted(path for path in (folder / "python" / "hexrelief").iterdir() if path.is_file())
        files = {f"hexrelief/{path.name}": path.read_bytes() for path in module}
    files[f"{ABOUT}/METADATA"] = METADATA.encode()
    files[f"{ABOUT}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: hexrelief\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[f"{ABOUT}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    record = ""
    for path, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{path},sha256={digest},{len(content)}\n"
    files[f"{ABOUT}/RECORD"] = (record + f"{ABOUT}/RECORD,,\n").encode()
    name = f"hexrelief-{VERSION}-{tag}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / name, "w") as archive:
        for path, content in files.items():
            archive.writestr(zipfile.ZipInfo(path), content, zipfile.ZIP_DEFLATED)  # dated 1980
    return name
