"""Faults of processes: signals, others at work on the same files, closed and full streams."""

import json
import os
import random
import shutil
import signal
import subprocess
import threading
import time
from pathlib import Path

import fault
from fault import Fault, MAP, batch_arguments, sums


class Signals(Fault):
    def setUp(self):
        super().setUp()
        self.fresh = self.outer / "fresh"
        self.assert_done(self.run_program(self.outputs("--set", "mesh.spacing_px=12")))
        self.old = sums(self.folder)
        begun = time.monotonic()
        self.assert_done(self.run_program(self.outputs(folder=self.fresh)))
        self.seconds = time.monotonic() - begun
        self.new = sums(self.fresh)
        self.random = random.Random(22)

    def without_report(self, found):
        return {name: value for name, value in found.items() if name != "r.json"}

    def interrupt(self, arguments, number):
        """Its exit code, once a batch's workers are gone as well."""
        process = self.start(arguments, start_new_session=True)
        time.sleep(self.random.uniform(0, 1.3 * self.seconds))
        process.send_signal(number)
        code = process.wait(30)
        deadline = time.monotonic() + 30
        while True:
            try:
                os.killpg(process.pid, 0)
            except ProcessLookupError:
                return code
            self.assertLess(time.monotonic(), deadline, "a worker goes on without its batch")
            time.sleep(0.005)

    def check_old_or_new(self, number, folder):
        found = self.without_report(sums(folder))
        old, new = self.without_report(self.old), self.without_report(self.new)
        if number != signal.SIGKILL:
            self.assertIn(found, (old, new))
            return
        found = {name: value for name, value in found.items() if not name.startswith(".hexrelief-")}
        for name, value in found.items():
            self.assertIn(value, (old[name], new[name]), name)
        if sums(folder)["r.json"] != self.old["r.json"]:  # the report comes last
            self.assert_set_is_whole_but_for_leftovers(folder)

    def assert_set_is_whole_but_for_leftovers(self, folder):
        for path in Path(folder).glob(".hexrelief-*"):
            path.unlink()
        self.assert_set_is_whole(folder)

    def restore(self):
        for path in self.folder.iterdir():
            if path.name not in self.old:
                self.assertTrue(path.name.startswith(".hexrelief-"), path)
        shutil.rmtree(self.folder)
        self.folder.mkdir()
        self.assert_done(self.run_program(self.outputs("--set", "mesh.spacing_px=12")))
        self.old = sums(self.folder)

    def test_a_run_over_old_files(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            for moment in range(fault.MOMENTS):
                with self.subTest(signal=number, moment=moment):
                    code = self.interrupt(self.outputs(), number)
                    self.assertIn(code, (0, 130, -number))
                    self.check_old_or_new(number, self.folder)
                    if self.without_report(sums(self.folder)) != self.without_report(self.old):
                        self.restore()

    def test_a_batch_over_old_files(self):
        folders = [self.outer / str(i) for i in range(3)]
        for folder in folders:
            shutil.copytree(self.folder, folder)
        rows = [self.outputs(folder=folder)[1:] for folder in folders]
        batch = batch_arguments(self.outer, rows)
        self.seconds *= len(folders)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            for moment in range(fault.MOMENTS):
                with self.subTest(signal=number, moment=moment):
                    self.assertIn(self.interrupt(batch, number), (0, 130, -number))
                    for folder in folders:
                        self.check_old_or_new(number, folder)
        self.assert_done(self.run_program(batch))
        for folder in folders:  # also: no leftovers
            self.assertEqual(self.without_report(sums(folder)), self.without_report(self.new))
            self.assert_set_is_whole(folder)

    def test_leftovers_of_the_killed_go_and_those_of_the_living_stay(self):
        """A pipe that nobody reads holds two runs when all else is written."""
        os.mkfifo(self.folder / "pipe.ply")
        held = ["run", *MAP, "-o", f"{self.folder}/held.glb", "-o", f"{self.folder}/pipe.ply"]
        killed, living = self.start(held), self.start(held)
        self.wait_until(lambda: len(list(self.folder.glob(".hexrelief-*"))) == 2)
        killed.kill()
        killed.wait()
        self.assert_done(self.run_program(self.outputs(inputs=MAP)))
        left = [path.name for path in self.folder.glob(".hexrelief-*")]
        self.assertEqual(len(left), 1, left)
        self.assertTrue(left[0].startswith(f".hexrelief-{living.pid}-"), left)
        self.assertTrue((self.folder / "pipe.ply").read_bytes().startswith(b"ply"))
        self.assertEqual(living.wait(30), 0)
        self.assertEqual(list(self.folder.glob(".hexrelief-*")), [])
        self.assertTrue((self.folder / "held.glb").exists())

    def test_a_run_that_waits_for_a_pipe_is_interrupted(self):
        os.mkfifo(self.folder / "pipe.ply")
        before = sums(self.folder)
        process = self.start(["run", *MAP, "-o", f"{self.folder}/held.glb", "-o", f"{self.folder}/pipe.ply"])
        self.wait_until(lambda: list(self.folder.glob(".hexrelief-*")))
        process.terminate()
        self.assertEqual(process.wait(10), 130)
        os.unlink(self.folder / "pipe.ply")
        self.assertEqual(sums(self.folder), before)

    def test_two_runs_onto_the_same_outputs(self):
        for _ in range(max(2, fault.MOMENTS // 2)):
            runs = [self.start(self.outputs("--seed", seed)) for seed in ("1", "2")]
            self.assertEqual([run.wait(60) for run in runs], [0, 0])
            self.assert_set_is_whole(self.folder)

    def test_two_batches_onto_the_same_outputs(self):
        """Each has a seed of its own; of every row one of them wins whole."""
        folders = [self.outer / name for name in ("x", "y")]
        batches = []
        for seed in ("1", "2"):
            (self.outer / seed).mkdir()
            rows = [self.outputs("--seed", seed, folder=folder)[1:] for folder in folders]
            batches.append(batch_arguments(self.outer / seed, rows))
        for _ in range(max(1, fault.MOMENTS // 10)):
            runs = [self.start([*batch, "--force"]) for batch in batches]
            self.assertEqual([run.wait(60) for run in runs], [0, 0])
            for folder in folders:
                self.assert_set_is_whole(folder)


class Streams(Fault):
    def closed(self, *descriptors):
        def close():
            for descriptor in descriptors:
                os.close(descriptor)
        return close

    def test_closed_streams_never_become_a_file(self):
        expected = None
        for closed in ((0,), (1,), (2,), (0, 1), (0, 1, 2)):
            # Without --quiet: warnings and the summary must not go into the outputs.
            code = subprocess.run([fault.PROGRAM, *self.outputs(inputs=MAP)], preexec_fn=self.closed(*closed),
                                  stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode
            self.assertEqual(code, 0, closed)  # the summary is told nowhere, but the files are there
            self.assert_set_is_whole(self.folder)
            found = {name: value for name, value in sums(self.folder).items() if name != "r.json"}
            expected = expected or found
            self.assertEqual(found, expected)

    def test_a_full_standard_output_loses_the_summary_alone(self):
        for arguments in (self.outputs(inputs=MAP), [*self.outputs(inputs=MAP), "--update"],
                          [*batch_arguments(self.outer, [self.outputs(inputs=MAP)[1:]]), "--force"]):
            with open("/dev/full", "wb") as full:
                result = self.run_program(arguments, stdout=full)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn(b"the files are written", result.stderr)
            self.assert_set_is_whole(self.folder)
        with open("/dev/full", "wb") as full:  # here the words are all there is
            self.assert_told(self.run_program(["info", *MAP[1:2]], stdout=full), 4)

    def test_a_closed_standard_output_takes_no_mesh(self):
        result = self.run_program(["run", *MAP, "-o", "-", "--report", f"{self.folder}/r.json"], stdout=None,
                                  preexec_fn=self.closed(1))
        self.assert_told(result, 4)
        self.assertEqual(os.listdir(self.folder), [])

    def test_a_full_standard_output_takes_no_mesh(self):
        with open("/dev/full", "wb") as full:
            result = self.run_program(["run", *MAP, "-o", "-", "--report", f"{self.folder}/r.json"], stdout=full)
        self.assert_told(result, 4)
        self.assertEqual(os.listdir(self.folder), [])

    def test_a_reader_that_goes_away(self):
        process = subprocess.Popen([fault.PROGRAM, "run", *MAP, "-o", "-", "--report", f"{self.folder}/r.json", "--quiet"],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        process.stdout.close()
        self.assertIn(b"Broken pipe", process.stderr.read())
        process.stderr.close()
        self.assertEqual(process.wait(30), 4)
        self.assertEqual(os.listdir(self.folder), [])

    def test_pipe_and_device_as_outputs(self):
        pipe = self.folder / "pipe.glb"
        os.mkfifo(pipe)
        os.symlink("/dev/null", self.folder / "null.glb")
        received = []
        reader = threading.Thread(target=lambda: received.append(pipe.read_bytes()))
        reader.start()
        result = self.run_program(["run", *MAP, "-o", str(pipe), "-o", f"{self.folder}/null.glb", "-o", f"{self.folder}/a.glb",
                                   "--report", f"{self.folder}/r.json"])
        reader.join()
        self.assert_done(result)
        self.assertEqual(received[0], (self.folder / "a.glb").read_bytes())
        report = json.loads((self.folder / "r.json").read_text())
        self.assertEqual(len({file["sha256"] for file in report["outputs"]}), 1)
