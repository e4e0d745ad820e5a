#!/usr/bin/env python3
"""Sweeps: the same table by any number of workers, one killed on the way; interrupted, refused and resumed ones."""
import contextlib
import io
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import palpate

TABLE = palpate.grid(noise=[0.1, 0.3], poses=[12, 20, 30])
SEEDS = range(1, 8)


def pivot(seed, noise, poses, folder="", fatal=False, stop_at=0):
    """A simulated calibration; leaves a file for each call in the folder. fatal: the first one of seed 4 kills its worker."""
    from simulated import simulated_pivot
    if folder:
        mark = pathlib.Path(folder) / f"{seed}_{noise}_{poses}"
        first = not mark.exists()
        with mark.open("a", encoding="ascii") as calls:
            calls.write("called\n")
        if fatal and seed == 4 and poses == 20 and first:
            os.kill(os.getpid(), signal.SIGKILL)
        if stop_at and seed == stop_at and first:
            raise KeyboardInterrupt
    result = palpate.calibrate_pivot(simulated_pivot(np.random.default_rng(seed), count=poses, noise=1e-3 * noise)[0])
    return {"tip_x": result.tip[0], "rms": result.rms, "warnings": len(result.warnings), "method": "pivot"}


def line(seed, count):
    """A straight line has no pose of its own: refused; a triangle has."""
    points = np.outer(np.arange(3.0 + count), [0.1, 0.2, 0.0])
    points[-1, 2] += 0.05 * (seed % 2)
    return {"rms": palpate.absolute_orientation(points, points).rms}


class Sweep(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.calls = self.folder / "calls"
        self.calls.mkdir()

    def swept(self, name, table=None, **how):
        """The table's bytes."""
        out = self.folder / name
        arrays = palpate.sweep(pivot, table or TABLE, SEEDS, out=out, progress=False, **how)
        self.assertFalse(pathlib.Path(f"{out}.partial").exists())
        header, *rows = out.read_text(encoding="utf-8").splitlines()
        self.assertEqual(header.split(","), list(arrays))
        at = list(arrays).index("tip_x")
        self.assertEqual([float(row.split(",")[at]) for row in rows], list(arrays["tip_x"]))
        return out.read_bytes()

    def called(self):
        return {mark.name: mark.read_text(encoding="ascii").count("called") for mark in self.calls.iterdir()}

    def test_any_number_of_workers_gives_the_same_table(self):
        alone = self.swept("alone.csv", workers=0)
        self.assertEqual(alone.count(b"\n"), 1 + 6 * 7)
        first = palpate.sweep(pivot, TABLE, SEEDS, workers=0, progress=False)
        self.assertEqual(list(first), ["noise", "poses", "seed", "tip_x", "rms", "warnings", "method"])
        self.assertEqual((first["seed"].dtype.kind, first["noise"].dtype.kind, first["method"].dtype.kind), ("i", "f", "U"))
        self.assertEqual(list(first["poses"][:14]), [12] * 7 + [20] * 7)
        for workers in (1, 2, 4):
            with self.subTest(workers=workers):
                self.assertEqual(self.swept(f"{workers}.csv", workers=workers), alone)

    def test_a_worker_that_is_killed_has_its_share_done_again(self):
        fatal = {**TABLE, "folder": [str(self.calls)] * 6, "fatal": [True] * 6}
        swept = self.swept("killed.csv", fatal, workers=2)
        self.assertTrue(all(self.called()[f"4_{noise}_20"] >= 2 for noise in (0.1, 0.3)), "nobody was killed")
        alone = palpate.sweep(pivot, TABLE, SEEDS, workers=0, progress=False)
        rows = [row.split(",") for row in swept.decode().splitlines()]
        at = rows[0].index("tip_x")
        self.assertEqual([float(row[at]) for row in rows[1:]], list(alone["tip_x"]))

    def test_what_was_interrupted_goes_on(self):
        stopped = {**TABLE, "folder": [str(self.calls)] * 6, "stop_at": [5] * 6}
        out = self.folder / "stopped.csv"
        partial = pathlib.Path(f"{out}.partial")
        for _ in range(6):  # in each row of the table once
            with self.assertRaises(KeyboardInterrupt):
                palpate.sweep(pivot, stopped, SEEDS, out=out, workers=0, progress=False)
            self.assertFalse(out.exists())
        with partial.open("ab") as file:
            file.write(b'{"row": 39, "values": {"tip_')  # the power went
        with self.assertRaisesRegex(ValueError, "another sweep"):
            palpate.sweep(pivot, stopped, [1, 2], out=out, workers=0)
        palpate.sweep(pivot, stopped, SEEDS, out=out, workers=0, progress=False)
        self.assertTrue(all(count == (2 if name.startswith("5_") else 1) for name, count in self.called().items()), self.called())
        alone = palpate.sweep(pivot, TABLE, SEEDS, workers=0, progress=False)
        rows = [row.split(",") for row in out.read_text(encoding="utf-8").splitlines()]
        self.assertEqual([float(row[rows[0].index("rms")]) for row in rows[1:]], list(alone["rms"]))
        with self.assertRaisesRegex(FileExistsError, "is there already"):
            palpate.sweep(pivot, stopped, SEEDS, out=out, workers=0)

    def test_a_sweep_that_is_killed_leaves_whole_lines(self):
        script = "import os, palpate, signal, sys\n" \
                 "def study(seed, k):\n" \
                 "    return {'n': seed} if seed < 30 else os.kill(os.getpid(), signal.SIGKILL)\n" \
                 "palpate.sweep(study, {'k': [1]}, range(60), workers=0, out=sys.argv[1])"
        done = subprocess.run([sys.executable, "-c", script, str(self.folder / "killed.csv")], capture_output=True, check=False)
        self.assertEqual(done.returncode, -signal.SIGKILL)
        lines = (self.folder / "killed.csv.partial").read_text(encoding="utf-8").splitlines()
        self.assertEqual([json.loads(line)["row"] for line in lines[1:]], list(range(30)))

    def test_a_script_that_workers_would_begin_again_is_refused(self):
        script = "import palpate\ndef study(seed, k):\n    return {'n': seed + k}\n"
        call = "print(list(palpate.sweep(study, {'k': [1]},\n    [1, 2], workers=1, progress=False)['n']))\n"
        guarded = "if __name__ == '__main__':\n    " + call.replace("\n    ", "\n        ")
        for name, text, words in (("bare.py", call, "line 4: each worker of a sweep imports this file"), ("guarded.py", guarded, "")):
            with self.subTest(name):
                path = self.folder / name
                path.write_text(script + text, encoding="utf-8")
                done = subprocess.run([sys.executable, str(path)], capture_output=True, text=True, timeout=300, check=False)
                self.assertEqual((done.returncode, done.stdout), (1, "") if words else (0, "[2, 3]\n"), done.stderr)
                self.assertIn(words, done.stderr)

    def test_what_is_refused_stands_in_its_row_and_the_rest_goes_on(self):
        table = palpate.sweep(line, {"count": [1, 2]}, [1, 2], workers=0, progress=False)
        self.assertEqual([bool(words) for words in table["refused"]], [False, True, False, True])
        self.assertIn("line", table["refused"][1])
        np.testing.assert_array_equal(np.isnan(table["rms"]), [False, True, False, True])

    def test_a_mistake_ends_the_sweep_and_names_the_row(self):
        for workers in (0, 1):
            with self.assertRaises(TypeError) as caught:
                palpate.sweep(pivot, {"noise": [0.1], "poses": ["many"]}, [1], workers=workers, progress=False)
            self.assertIn("'poses': 'many'", "".join(getattr(caught.exception, "__notes__", [])))

    def test_a_session_is_swept(self):
        session = palpate.Session("touch", seconds=1.5)
        table = palpate.sweep(session, {"touch.stiffness_n_m": [200.0, 600.0], "force_delay": [0.0, 0.04]}, [5, 6], workers=2, progress=False)
        for i in range(4):
            alone = session.but(settings={"touch.stiffness_n_m": [200.0, 600.0][i // 2]}, force_delay=[0.0, 0.04][i // 2]).run(5 + i % 2, states=False)
            self.assertEqual(table["force.peak_n"][i], alone.figures["force"]["peak_n"])
            self.assertEqual(table["touch.touches"][i], alone.figures["touch"]["touches"])
        with self.assertRaisesRegex(ValueError, "delay_of_force"):
            palpate.sweep(session, {"delay_of_force": [1]}, [1], workers=0, progress=False)

    def test_a_scheduler_beyond_this_machine_is_reached_by_tls_alone(self):
        for address in ("tcp://192.0.2.1:8786", "192.0.2.1:8786", "tcp://lab.example:8786", "tcp://[2001:db8::1]:8786"):
            with self.subTest(address), self.assertRaisesRegex(ValueError, "beyond this machine and not encrypted"):
                palpate.sweep(pivot, TABLE, SEEDS, scheduler=address)
        with self.assertRaisesRegex(ValueError, "TLS needs keys"):
            palpate.sweep(pivot, TABLE, SEEDS, scheduler="tls://192.0.2.1:8786")
        for address in ("ws://127.0.0.1:8786", "tcp://127.0.0.1", "inproc://1"):
            with self.subTest(address), self.assertRaisesRegex(ValueError, "such as tls://"):
                palpate.sweep(pivot, TABLE, SEEDS, scheduler=address)

    def test_a_scheduler_of_this_machine_is_joined(self):
        from distributed import LocalCluster
        with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as theirs:
            self.assertEqual(self.swept("theirs.csv", scheduler=theirs.scheduler_address), self.swept("alone.csv", workers=0))

    def test_progress_is_a_line_for_each_tenth_where_there_is_no_terminal(self):
        with contextlib.redirect_stderr(io.StringIO()) as told:
            palpate.sweep(pivot, TABLE, SEEDS, workers=0)
        lines = told.getvalue().splitlines()
        self.assertEqual(len(lines), 10)
        self.assertRegex(lines[4], r"^sweep: 50 % \(21 of 42\), \S+( \S+)? left$")

    def test_wrong_tables_in_words(self):
        for words, table, seeds in (
                ("a has 1, b has 2", {"a": [1], "b": [1, 2]}, [1]), ("no row", {"a": []}, [1]), ("no row", {"a": [1]}, []),
                ("the same keys", [{"a": 1}, {"b": 1}], [1]), ("sweep's own", {"seed": [1]}, [1]), ("seed is -1", {"a": [1]}, [-1])):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                palpate.sweep(pivot, table, seeds, workers=0)
        with self.assertRaisesRegex(TypeError, "a is ndarray"):
            palpate.sweep(pivot, {"a": [np.zeros(2)]}, [1], workers=0)
        with self.assertRaisesRegex(ValueError, "the same keys each time"):
            palpate.sweep(lambda seed, a: {f"x{seed}": a}, {"a": [1]}, [1, 2], workers=0, progress=False)
        with self.assertRaisesRegex(ValueError, "as a parameter is called"):
            palpate.sweep(lambda seed, a: {"a": a}, {"a": [1]}, [1], workers=0, progress=False)


if __name__ == "__main__":
    unittest.main()
