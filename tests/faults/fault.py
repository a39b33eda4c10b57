"""What all faults need: a folder, runs of the program, and what is expected of one that fails."""

import hashlib
import json
import os
import resource
import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

SAMPLES = Path(__file__).resolve().parents[2] / "samples"
PROGRAM = ""
MOMENTS = 4
NOBODY = 65534
MAP = ["--disparity", str(SAMPLES / "disparity.pfm")]
PAIR = ["--left", str(SAMPLES / "left.png"), "--right", str(SAMPLES / "right.png"), "--calib", str(SAMPLES / "calib.txt")]


def limits(**values):
    """For preexec_fn: soft and hard limits of the child, by the names in `resource` without RLIMIT_."""
    def set_limits():
        for name, value in values.items():
            resource.setrlimit(getattr(resource, "RLIMIT_" + name), (value, value))
    return set_limits


def as_nobody(then=lambda: None):
    def change():
        os.setgroups([])
        os.setgid(NOBODY)
        os.setuid(NOBODY)
        then()
    return change


def sums(folder):
    """The SHA-256 of every file below the folder, by its name."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(Path(folder).rglob("*")) if path.is_file() and not path.is_symlink()}


def batch_arguments(folder, rows):
    """The command for several rows of options of one run each. The only place that knows how a batch is called."""
    jobs = Path(folder) / "jobs.txt"
    jobs.write_text("".join(" ".join(f'"{word}"' for word in row) + "\n" for row in rows))
    return ["batch", str(jobs), "--jobs", "2"]


class Fault(unittest.TestCase):
    def setUp(self):
        # A folder within a folder, for files beside the outputs.
        self.outer = Path(tempfile.mkdtemp(prefix="hexrelief-faults-"))
        self.addCleanup(shutil.rmtree, self.outer, ignore_errors=True)
        self.outer.chmod(0o755)
        self.folder = self.outer / "out"
        self.folder.mkdir()
        self.folder.chmod(0o777)

    def outputs(self, *more, inputs=None, folder=None):
        """A run whose outputs are a set of four formats' files and a report."""
        folder = folder or self.folder
        return ["run", *(inputs or PAIR), "-o", f"{folder}/a.glb", "-o", f"{folder}/a.obj", "-o", f"{folder}/a.drc",
                "--report", f"{folder}/r.json", *more]

    def run_program(self, arguments, **options):
        options.setdefault("stdin", subprocess.DEVNULL)
        options.setdefault("timeout", 120)
        if "stdout" not in options:
            options["stdout"] = subprocess.PIPE
        return subprocess.run([PROGRAM, *arguments], stderr=subprocess.PIPE, **options)

    def start(self, arguments, **options):
        return subprocess.Popen([PROGRAM, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL, **options)

    def wait_until(self, is_so):
        deadline = time.monotonic() + 30
        while not is_so():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)

    def catches(self, process, number):
        """Whether a running program has set its handler of a signal, which would kill it before."""
        status = Path(f"/proc/{process.pid}/status").read_text()
        caught = next(line for line in status.split("\n") if line.startswith("SigCgt:"))
        return int(caught.split()[1], 16) >> (number - 1) & 1 == 1

    def require_other_user(self):
        if os.geteuid() != 0:
            self.skipTest("only root may become another user")
        try:
            subprocess.run([PROGRAM, "info", SAMPLES / "left.png"], preexec_fn=as_nobody(), capture_output=True, check=True)
        except (OSError, subprocess.SubprocessError):
            self.skipTest("another user may not run the program where it lies")

    def assert_told(self, result, code):
        """It failed with this code and one line, warnings aside."""
        lines = [line for line in result.stderr.split(b"\n") if line and not line.startswith(b"hexrelief: warning: ")]
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertTrue(lines[0].startswith(b"hexrelief: "), result.stderr)
        self.assertNotIn(b"internal error", lines[0])
        return lines[0]

    def assert_done(self, result):
        self.assertEqual(result.returncode, 0, result.stderr)

    def assert_all_or_none(self, result, *codes):
        """It wrote all files, which are then removed, or told an error with one of these codes and left nothing."""
        if result.returncode == 0:
            self.assert_set_is_whole(self.folder)
            shutil.rmtree(self.folder)
            self.folder.mkdir()
        elif result.returncode != 127:  # not even its libraries
            self.assertIn(result.returncode, codes)
            self.assert_told(result, result.returncode)
            self.assertEqual(os.listdir(self.folder), [])

    def assert_set_is_whole(self, folder):
        """The report names the files with their sums."""
        found = sums(folder)
        report = json.loads((Path(folder) / "r.json").read_text())
        self.assertEqual({Path(file["path"]).name: file["sha256"] for file in report["outputs"]},
                         {name: value for name, value in found.items() if name != "r.json"})
