#!/usr/bin/env python3
"""A demo stopped at different stages: it ends soon, says so, and leaves only whole files and no process. One that is quick and long at once, to
its end."""
import json
import os
import signal
import unittest

import raw_files
from program import PROGRAM, ProgramTest, wait_until, without_phases


class DemoStopped(ProgramTest):
    def start_demo_until(self, what):
        demo = self.start("demo", "--quick", "--seconds", "1", "--out", "report")
        wait_until(lambda: demo.ended() or os.path.exists(self.path("report", what)), f"report/{what} is there; so far {demo.lines()}")
        self.assertFalse(demo.ended(), demo.lines())
        return demo

    def children(self, demo):
        """Processes that the demo started, by their command line."""
        found = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/cmdline", encoding="utf-8") as file:
                    words = file.read().split("\0")
                if words[0] == os.path.realpath(PROGRAM) and f"demo-{demo.process.pid}" in words:
                    found.append(int(pid))
            except (OSError, UnicodeDecodeError):
                pass  # it has ended meanwhile
        return found

    def stopped(self, demo):
        self.says_no(without_phases(demo.ends()), 1, "demo: stopped before its end", "report", "start it again")
        names = set(self.files())
        self.assertFalse({"report/summary.json", "report/report.json", "report/report.html"} & names)
        for name in names:
            self.assertFalse(".part-" in name or "unfinished" in name, name)
            if name.endswith(".json"):
                json.loads(self.read(name))
            if name.endswith((".csv", ".toml")):
                self.assertTrue(self.read(name).endswith(b"\n"), name)
        return names

    def test_a_folder_of_others_stays_as_it_is(self):
        os.mkdir(self.path("own"))
        self.write("own/rig.toml", "mine")
        self.says_no(self.run_program("demo", "--headless", "--quick", "--out", "own"), 2, "--out own: holds 'rig.toml'", "a new folder is expected")
        self.assertEqual((os.listdir(self.path("own")), self.read("own", "rig.toml")), (["rig.toml"], b"mine"))

    def test_a_rig_that_was_calibrated_further_is_kept(self):
        for folder in ("raw", "pictures"):
            os.makedirs(self.path("report", folder))
        self.write("report/rig.toml", "# as the demo left it\n")
        self.write("report/summary.json", "{}")
        for ended, kept in ((2e9, []), (1e9, ["rig-before-1.toml"])):
            os.utime(self.path("report", "summary.json"), (ended, ended))
            demo = self.start("demo", "--quick", "--seconds", "1", "--out", "report")
            self.assertTrue(demo.says("calibrates everything"), demo.lines())
            demo.send(signal.SIGINT)
            self.assertEqual(demo.ends().code, 1)
            self.assertEqual([name for name in os.listdir(self.path("report")) if name.startswith("rig-")], kept)
            self.assertEqual(any("has been changed since its demo; it is rig-before-1.toml now" in line for line in demo.lines()), bool(kept))
            if not kept:
                self.write("report/rig.toml", "# calibrated further since\n")
                self.write("report/summary.json", "{}")
        self.assertEqual(self.read("report/rig-before-1.toml"), b"# calibrated further since\n")

    def test_while_it_calibrates(self):
        # What `palpate report` would make an earlier run's report of.
        for folder in ("raw", "pictures"):
            os.makedirs(self.path("report", folder))
        self.write("report/report.json", "{}")
        demo = self.start_demo_until("rig.toml")
        demo.send(signal.SIGINT)
        self.stopped(demo)
        self.runs("rig", "show", "report/rig.toml")

    def test_while_it_plays(self):
        demo = self.start_demo_until(".video.unfinished.mp4")
        demo.send(signal.SIGTERM)
        self.assertNotIn("report/video.mp4", self.stopped(demo))

    def test_while_three_processes_play_and_ctrl_c_reaches_them_all(self):
        demo = self.start_demo_until("raw/realtime_graphics.log")
        for pid in [demo.process.pid, *self.children(demo)]:
            os.kill(pid, signal.SIGINT)
        self.stopped(demo)
        self.assertEqual(self.children(demo), [])
        place = os.path.join(self.meeting, "palpate")
        self.assertEqual([name for name in os.listdir(place) if not name.endswith(".lock")], [])

    def test_a_whole_one_says_what_it_does_what_made_it_and_what_each_of_its_files_holds(self):
        for folder in ("raw", "pictures"):
            os.makedirs(self.path("report", folder))
        for name in ("frames_right.csv", "headset_head.csv", "mine.txt"):
            self.write(os.path.join("report", "raw", name), "time_s\n1\n")
        done = self.runs("demo", "--headless", "--quick", "--seconds", "8", "--out", "report")
        # What an earlier one has left is gone, what is not a demo's stays.
        self.assertFalse({"frames_right.csv", "headset_head.csv"} & set(os.listdir(self.path("report", "raw"))))
        os.remove(self.path("report", "raw", "mine.txt"))
        raw_files.check(self, self.path("report"))
        # Without a terminal it says what it does.
        phases = [line.removeprefix("palpate: demo: ") for line in done.lines if line.startswith("palpate: demo: ")]
        self.assertEqual(phases, ["calibrates everything", "plays 8 s in lock-step", "plays 3 s in real time", "writes the report"])
        summary = json.loads(self.read("report", "summary.json"))
        # Quick ones that an application makes long by itself draw 160; players see by them, and play worse.
        self.assertGreater(summary["exchange"]["frames"], 8 * 30 - 3)
        self.assertIn(f"palpate {summary['made']['version']} (", self.runs("--version").out)
        self.assertEqual(summary["made"]["cores"], len(os.sched_getaffinity(0)))
        self.assertIsNotNone(summary["made"]["renderer"])

    def test_the_files_of_other_applications_are_described_as_well(self):
        for application in ("touch", "palpation"):
            self.runs("demo", "--headless", "--quick", "--seconds", "1", "--app", application, "--out", application)
            raw_files.check(self, self.path(application))


if __name__ == "__main__":
    unittest.main()
