#!/usr/bin/env python3
"""What can go wrong around a run: full disks, limits, signals, closed streams, odd names. Usage:

    faults_test.py build/hexrelief [--long] [-v] [NAME...]

A run leaves all of its files or none, the old ones or the new ones, and tells an error in one line. --long tries 50 random
moments instead of 4. What the system does not allow (other users, mounts, a compiler) is skipped aloud.
"""

import argparse
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

import fault
from fault import Fault, MAP, PAIR, SAMPLES, as_nobody, batch_arguments, limits, sums
from processes import Signals, Streams  # noqa: F401, for unittest to find


def mounted(test, options, script):
    """Runs a shell script with a tmpfs mounted at the test's folder, in a mount namespace of its own."""
    command = f"mount -t tmpfs -o {options} none '{test.folder}' || exit 99; {script}"
    try:
        result = subprocess.run(["unshare", "-m", "sh", "-c", command], capture_output=True, text=True, timeout=120)
    except FileNotFoundError:
        test.skipTest("no unshare")
    if result.returncode == 99 or "unshare:" in result.stderr:
        test.skipTest("file systems cannot be mounted: " + result.stderr.strip())
    return result


def compiled(test, name, source):
    """A library to be preloaded, in C."""
    if shutil.which("cc") is None:
        test.skipTest("no compiler")
    path, library = test.outer / f"{name}.c", test.outer / f"{name}.so"
    path.write_text(source)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, path], check=True)
    return library


class Disks(Fault):
    def test_full_disk_leaves_the_old_files(self):
        words = " ".join(self.outputs("--quiet"))
        result = mounted(self, "size=300k", f"cd '{self.folder}'; echo old > a.glb; echo old > r.json; '{fault.PROGRAM}' {words}; "
                         "echo $?; ls -A; cat a.glb r.json")
        self.assertEqual(result.stdout, "4\na.glb\nr.json\nold\nold\n", result.stderr)
        self.assertIn("No space left on device", result.stderr)

    def test_leftovers_make_room_on_a_full_disk(self):
        words = " ".join(["run", *MAP, "-o", f"{self.folder}/a.drc", "--quiet"])
        result = mounted(self, "size=300k", f"cd '{self.folder}'; cat /dev/zero > .hexrelief-1-0.tmp; '{fault.PROGRAM}' {words}; "
                         "echo $?; ls -A")
        self.assertEqual(result.stdout, "0\na.drc\n", result.stderr)

    def test_a_batch_goes_on_where_a_row_has_no_room(self):
        batch_arguments(self.outer, [[*MAP, "-o", "a.drc"], [*PAIR, "-o", "b.glb", "-o", "b.obj"], [*MAP, "-o", "c.drc"]])
        result = mounted(self, "size=300k", f"cd '{self.folder}'; '{fault.PROGRAM}' batch ../jobs.txt --log text; "
                         "echo code $?; ls -A")
        self.assertTrue(result.stdout.endswith("code 4\na.drc\nc.drc\n"), result.stdout)
        self.assertIn("jobs.txt:2: ", result.stderr)
        self.assertIn("No space left on device", result.stderr)

    def test_read_only_file_system(self):
        words = " ".join(self.outputs("--quiet"))
        result = mounted(self, "ro", f"'{fault.PROGRAM}' {words}; echo $?")
        self.assertEqual(result.stdout, "4\n", result.stderr)

    def test_read_only_folder_and_file(self):
        self.require_other_user()
        self.folder.chmod(0o555)
        self.assert_told(self.run_program(self.outputs(), preexec_fn=as_nobody()), 4)
        self.folder.chmod(0o777)
        (self.folder / "a.mtl").write_text("old")
        (self.folder / "a.mtl").chmod(0o444)
        self.assert_told(self.run_program(self.outputs(), preexec_fn=as_nobody()), 4)
        self.assertEqual(os.listdir(self.folder), ["a.mtl"])


class Limits(Fault):
    def test_file_size(self):
        (self.folder / "a.glb").write_text("old")
        line = self.assert_told(self.run_program(self.outputs(), preexec_fn=limits(FSIZE=20000)), 4)
        self.assertIn(b"File too large", line)
        self.assertEqual(os.listdir(self.folder), ["a.glb"])
        self.assertEqual((self.folder / "a.glb").read_text(), "old")

    def test_descriptors(self):
        for most in (8, 9, 10, 11, 12, 14, 16, 20, 64):
            self.assert_all_or_none(self.run_program(self.outputs(inputs=MAP), preexec_fn=limits(NOFILE=most)), 3, 4)

    def test_descriptors_of_a_batch(self):
        for most in (4, 5, 6, 8):
            arguments = batch_arguments(self.outer, [self.outputs(inputs=MAP)[1:]])
            result = self.run_program(arguments, preexec_fn=limits(NOFILE=most))
            self.assertNotEqual(result.returncode, 1, result.stderr)  # no bug

    def test_address_space(self):
        for mebibytes in (40, 80, 120, 160, 200, 250, 300):
            result = self.run_program(self.outputs("--threads", "4", "--backend", "cpu"), preexec_fn=limits(AS=mebibytes << 20))
            self.assert_all_or_none(result, 6)

    def test_memory_that_ends_for_good(self):
        """Neither the message nor what is undone can allocate more than the smallest blocks."""
        library = compiled(self, "memory", """
#define _GNU_SOURCE
#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>
void* __libc_malloc(size_t);
void* __libc_memalign(size_t, size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
static atomic_long left = 1 << 30;
__attribute__((constructor)) static void begin(void) { left = atol(getenv("ALLOCATIONS")); }
enum { kJsonNode = 48 };  // without room for one nlohmann-json 3.11.2 destroys a null pointer
static int ends(size_t bytes) {
    return atomic_fetch_sub(&left, 1) > 0 || bytes <= kJsonNode ? 0 : (errno = ENOMEM);
}
void* malloc(size_t bytes) { return ends(bytes) ? 0 : __libc_malloc(bytes); }
void* calloc(size_t count, size_t bytes) { return ends(count * bytes) ? 0 : __libc_calloc(count, bytes); }
void* realloc(void* block, size_t bytes) { return ends(bytes) ? 0 : __libc_realloc(block, bytes); }
void* aligned_alloc(size_t alignment, size_t bytes) {
    return ends(bytes) ? 0 : __libc_memalign(alignment, bytes);
}
int posix_memalign(void** block, size_t alignment, size_t bytes) {
    return ends(bytes) || !(*block = __libc_memalign(alignment, bytes)) ? ENOMEM : 0;
}
""")
        ended = 0
        for allocations in range(3000, 60000, 2000):
            surroundings = {"LD_PRELOAD": str(library), "ALLOCATIONS": str(allocations)}
            result = self.run_program(self.outputs("--threads", "4", "--backend", "cpu"), env=surroundings)
            if result.returncode == 0:
                break
            self.assert_told(result, 6)
            self.assertEqual(os.listdir(self.folder), [])
            ended += 1
        self.assertGreater(ended, 4)

    def test_threads(self):
        self.require_other_user()
        expected = None
        for most in (1, 2, 4, 100):
            result = self.run_program(self.outputs("--threads", "6"), preexec_fn=as_nobody(limits(NPROC=most)))
            self.assert_done(result)
            found = {name: value for name, value in sums(self.folder).items() if name != "r.json"}
            expected = expected or found
            self.assertEqual(found, expected)

    def test_no_thread_for_the_signals(self):
        """The handler then does it."""
        self.require_other_user()
        long_job = self.outputs("--set", "mesh.spacing_px=2", "--set", "mesh.t_max=100000")
        process = self.start(long_job, preexec_fn=as_nobody(limits(NPROC=1)))
        self.wait_until(lambda: self.catches(process, signal.SIGTERM))
        time.sleep(0.5)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(20), 130)
        self.assertEqual(os.listdir(self.folder), [])


class Surroundings(Fault):
    def bytes_with(self, **options):
        self.assert_done(self.run_program(self.outputs(), **options))
        return {name: value for name, value in sums(self.folder).items() if name != "r.json"}

    def test_no_home_no_temporary_folder_no_environment(self):
        expected = self.bytes_with()
        self.assertEqual(self.bytes_with(env={}), expected)
        self.assertEqual(self.bytes_with(env={"TMPDIR": "/nonexistent", "HOME": "/nonexistent"}), expected)
        result = self.run_program(["run", *PAIR, "-o", "-"], env={"TMPDIR": "/nonexistent"})
        self.assertEqual(hashlib.sha256(result.stdout).hexdigest(), expected["a.glb"])
        result = self.run_program(["info", f"{self.folder}/a.drc"], env={"TMPDIR": "/nonexistent"})
        self.assert_done(result)

    def test_no_folder_for_temporary_files(self):
        """Nothing can be written to /tmp; the folders there that the test needs were entered before."""
        result = mounted(self, "size=1m", f"""
            cd '{self.folder}' && cp '{SAMPLES}/disparity.pfm' . && exec 9<'{fault.PROGRAM}' &&
                mount -t tmpfs -o ro none /tmp || exit 99
            unset TMPDIR
            /proc/self/fd/9 run --disparity disparity.pfm -o a.glb -o a.drc --report r.json --quiet 2>&1 && ls -A
            /proc/self/fd/9 info a.drc >/dev/null && touch /tmp/x""")
        self.assertEqual(result.stdout, "a.drc\na.glb\ndisparity.pfm\nr.json\n", result.stderr)
        self.assertIn("/tmp/x", result.stderr)  # so it was read-only

    def test_decimal_comma(self):
        locales = self.outer / "locales"
        locales.mkdir()
        made = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", str(locales / "de_DE.UTF-8")], capture_output=True,
                              check=False)
        if made.returncode not in (0, 1) or not (locales / "de_DE.UTF-8").exists():
            self.skipTest("no locale with a decimal comma: Debian's package locales has its source")
        settings = {"LOCPATH": str(locales), "LC_ALL": "de_DE.UTF-8"}
        more = ["--set", "mesh.spacing_px=8.5", "--set", "export.tolerance_px=0.05"]
        found = []
        for environment in ({}, settings):
            self.assert_done(self.run_program(self.outputs(*more), env=environment))
            found.append({name: value for name, value in sums(self.folder).items() if name != "r.json"})
            self.assertEqual(json.loads((self.folder / "r.json").read_text())["config"]["mesh"]["spacing_px"], 8.5)
        self.assertEqual(found[0], found[1])

    def test_clock_that_steps_backwards(self):
        library = compiled(self, "clock", """
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
static long steps;
int clock_gettime(clockid_t clock, struct timespec* now) {
    const int code = (int)syscall(SYS_clock_gettime, clock, now);
    if (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE) now->tv_sec -= 3600 * ++steps;
    return code;
}
int gettimeofday(struct timeval* now, void* zone) {
    struct timespec precise;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &precise);
    now->tv_sec = precise.tv_sec, now->tv_usec = precise.tv_nsec / 1000;
    return 0;
}
time_t time(time_t* now) {
    struct timespec precise;
    clock_gettime(CLOCK_REALTIME, &precise);
    if (now) *now = precise.tv_sec;
    return precise.tv_sec;
}
""")
        expected = self.bytes_with()
        clock = {"LD_PRELOAD": str(library)}
        self.assertEqual(self.bytes_with(env=clock), expected)
        for stage in json.loads((self.folder / "r.json").read_text())["stages"]:
            self.assertGreaterEqual(stage["seconds"], 0)
            self.assertLess(stage["seconds"], 60)
        batch = batch_arguments(self.outer, [self.outputs()[1:]])
        self.assert_done(self.run_program([*batch, "--force"], env=clock))
        result = self.run_program(batch, env=clock)
        self.assert_done(result)
        self.assertIn(b'"up_to_date":1', result.stdout)
        self.assertEqual({name: value for name, value in sums(self.folder).items() if name != "r.json"}, expected)

    def test_an_input_that_changes_while_it_is_read(self):
        source = self.outer / "left.png"
        shutil.copy(SAMPLES / "left.png", source)
        inputs = ["--left", str(source), "--right", str(SAMPLES / "right.png")]
        moment, deadline = 10**18, time.monotonic() + 60
        while time.monotonic() < deadline:  # reading takes a millisecond, in which this process may not come to its turn
            process = subprocess.Popen([fault.PROGRAM, *self.outputs(inputs=inputs)], stdin=subprocess.DEVNULL,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            while process.poll() is None:
                moment += 10**9
                os.utime(source, ns=(moment, moment))
            message = process.stderr.read()
            process.stderr.close()
            if process.returncode != 0:
                break
            shutil.rmtree(self.folder)
            os.mkdir(self.folder)
        self.assertEqual(process.returncode, 3, message)
        self.assertIn(b"left.png' was changed while it was read", message)
        self.assertEqual(os.listdir(self.folder), [])


class Names(Fault):
    def references(self, mesh):
        """The files beside an OBJ or a glTF file are there under the names in it; `info` finds them."""
        folder = Path(os.fsdecode(mesh)).parent
        content = Path(os.fsdecode(mesh)).read_bytes()
        if mesh.endswith(b".obj"):
            line = next(line for line in content.split(b"\n") if line.startswith(b"mtllib "))
            material = os.path.join(os.fsencode(folder), line[len(b"mtllib "):])
            picture = next(line for line in Path(os.fsdecode(material)).read_bytes().split(b"\n")
                           if line.startswith(b"map_Kd "))
            self.assertTrue(os.path.exists(os.path.join(os.fsencode(folder), picture[len(b"map_Kd "):])))
        self.assert_done(self.run_program(["info", mesh]))

    def test_names(self):
        left = os.fsencode(SAMPLES / "left.png")
        long_folder = os.fsencode(self.outer)
        while len(long_folder) < 3900:
            long_folder += b"/" + b"x" * min(200, 3999 - len(long_folder))
        folder = os.fsencode(self.folder)
        for stem in (b"\xff\xfe", b"sp ace#%?&", b"\x1b[31m", b"-", "Ω".encode(), b"'\"$(x)`"):
            for extension in (b".obj", b".gltf", b".glb"):
                source = folder + b"/" + stem + b".png"
                shutil.copy(left, source)
                mesh = folder + b"/" + stem + extension
                result = self.run_program(["run", "--disparity", SAMPLES / "disparity.pfm", "--color", source, "-o", mesh,
                                           "--report", folder + b"/" + stem + b".json"])
                self.assert_done(result)
                self.assertNotIn(b"\x1b", result.stdout + result.stderr)
                self.references(mesh)
                json.loads(Path(os.fsdecode(folder + b"/" + stem + b".json")).read_text())
        for extension in (b".obj", b".gltf", b".glb"):
            mesh = long_folder + b"/a" + extension
            self.assert_done(self.run_program(["run", *MAP, "--color", left, "-o", mesh]))
            self.references(mesh)
        self.assert_told(self.run_program(["run", *MAP, "-o", b"x" * 5000 + b".glb"]), 4)

    def test_line_breaks(self):
        for extension in (".gltf", ".glb", ".drc", ".ply"):
            self.assert_done(self.run_program(["run", *MAP, "-o", f"{self.folder}/a\nb{extension}"]))
            self.references(os.fsencode(f"{self.folder}/a\nb{extension}"))
        self.assert_told(self.run_program(["run", *MAP, "-o", f"{self.folder}/a\nb.obj"]), 2)
        inner = self.folder / "a\nfolder"
        inner.mkdir()
        self.assert_done(self.run_program(["run", *MAP, "--color", str(SAMPLES / "left.png"), "-o", f"{inner}/a.obj"]))
        self.references(os.fsencode(f"{inner}/a.obj"))


class Devices(Fault):
    """What only a machine with a GPU shows. Where the device fails or lacks memory: tests/pipeline/job/runner_test.cpp, injected,
    and tests/cuda/error_test.cpp, lost_device_test.cpp; a driver that is too old: tests/cuda/old_driver.sh."""

    def setUp(self):
        super().setUp()
        devices = self.run_program(["devices"]).stdout.decode()
        if not any(line.startswith("cuda") and "not usable" not in line for line in devices.splitlines()):
            self.skipTest("no CUDA device here")

    def on(self, backend, folder):
        return self.outputs("--backend", backend, folder=self.outer / folder)

    def without_report(self, folder):
        return {name: value for name, value in sums(self.outer / folder).items() if name != "r.json"}

    def test_several_processes_on_one_device(self):
        self.assert_done(self.run_program(self.on("cpu", "cpu")))
        expected = self.without_report("cpu")
        for _ in range(max(2, fault.MOMENTS // 10)):
            runs = [self.start(self.on("cuda", f"cuda{i}")) for i in range(4)]
            self.assertEqual([run.wait(60) for run in runs], [0] * 4)
            for i in range(4):
                self.assertEqual(self.without_report(f"cuda{i}"), expected)

    def test_a_slice_of_a_device(self):
        slices = subprocess.run(["nvidia-smi", "-L"], capture_output=True, text=True).stdout
        if "MIG" not in slices:
            self.skipTest("no device here is divided into MIG slices")
        self.assert_done(self.run_program(self.on("cpu", "cpu")))
        self.assert_done(self.run_program(self.on("cuda", "cuda")))
        self.assertEqual(self.without_report("cuda"), self.without_report("cpu"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--long", action="store_true")
    arguments, rest = parser.parse_known_args()
    fault.PROGRAM = os.path.abspath(arguments.program)
    if arguments.long:
        fault.MOMENTS = 50
    unittest.main(argv=[sys.argv[0], *rest])


if __name__ == "__main__":
    main()
