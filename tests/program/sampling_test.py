#!/usr/bin/env python3
"""palpate sample: tables from the simulated laboratory's devices and from the recording made meanwhile, beside the truth."""
import json
import math
import os
import signal
import subprocess
import time
import unittest

from person_at_devices import Laboratory
from program import PROGRAM, ProgramTest, wait_until
from tables import numbers, rows_of

SEED = "5"
POSES = 12


def place(row, prefix=""):
    return numbers(row, *(f"{prefix}{axis}_mm" for axis in "xyz"))


def matrix(row):
    w, x, y, z = numbers(row, "qw", "qx", "qy", "qz")
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]


class Sampling(ProgramTest):
    def no(self, arguments, code, *words):
        self.says_no(self.run_program(*arguments), code, *words)

    def truth(self, kind):
        self.runs("world", "sample", kind, "--seed", SEED, "--out", f"truth-{kind}")
        return json.loads(self.read(f"truth-{kind}", "truth.json"))

    def result(self, *arguments):
        self.runs(*arguments, "--json", "result.json")
        return json.loads(self.read("result.json"))

    def at_the_devices(self, tip):
        """One session: poses held, the pointer swung, four corners touched; when each part was, s since the recording began."""
        laboratory = Laboratory(self, "--seed", SEED)
        arm = self.start("sample", "arm", "--arm", "lab", "--tracker", "lab", "--out", "live", "--record", "s.mcap", "--json", "live.json")
        self.assertTrue(arm.says("sampling"), arm.lines())
        begun = time.monotonic()
        # Beside it, as others may read the tracker, too: the touches with a key for each.
        touches = subprocess.Popen([PROGRAM, "sample", "touches", "--tracker", "lab", "--tip-mm", tip, "--label", "table", "--out", "keys",
                                    "--json", "keys.json"], stdin=subprocess.PIPE, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                   env=self.environment, cwd=self.folder)
        self.addCleanup(touches.kill)
        parts = {}
        for _ in range(POSES):
            laboratory.does({"gesture": "next_pose"})
            time.sleep(0.8)
        parts["poses"] = (0.0, time.monotonic() - begun)
        laboratory.does({"gesture": "swing_pointer"})
        parts["swing"] = (time.monotonic() - begun, time.monotonic() - begun + 6.0)
        time.sleep(6.5)
        parts["touches"] = (time.monotonic() - begun, 1000.0)
        for corner in range(4):
            laboratory.does({"gesture": "touch", "what": "table", "index": corner})
            if corner != 1:  # one that nobody means
                touches.stdin.write("\n")
                touches.stdin.flush()
            time.sleep(1.3)
        for process in (arm.process, touches):
            process.send_signal(signal.SIGINT)
        done = arm.ends()
        self.assertEqual(done.code, 0, done)
        wait_until(lambda: touches.poll() is not None, "the touches end")
        self.assertEqual(touches.returncode, 0, touches.stderr.read())
        for pipe in (touches.stdin, touches.stdout, touches.stderr):
            pipe.close()
        laboratory.ends()
        return parts

    def test_devices_and_their_recording_give_the_same_and_the_truth(self):
        pointer = self.truth("pointer")["tip_mm"]
        tip = ",".join(map(str, pointer))
        parts = self.at_the_devices(tip)
        with self.subTest("arm"):
            self.arm(parts)
        with self.subTest("touches"):
            self.touches(tip, parts)
        with self.subTest("pivot"):
            self.pivot(pointer, parts)
        with self.subTest("tools"):
            self.tools(parts)
        with self.subTest("refusals"):
            self.refusals(tip)

    def arm(self, parts):
        live = rows_of(self.path("live", "arm.csv"))
        self.assertIn(len(live), range(POSES, POSES + 3))  # where the stylus hung before and after are holds, too
        self.runs("sample", "arm", "--recording", "s.mcap", "--out", "again", "--json", "again.json")
        again = rows_of(self.path("again", "arm.csv"))
        self.assertEqual(len(again), len(live))
        since = float(live[0]["time_s"]) - float(again[0]["time_s"])
        for a, b in zip(live, again):
            self.assertAlmostEqual(float(a["time_s"]) - float(b["time_s"]), since, delta=0.1)  # of a few frames more or less
            self.assertLess(math.dist(place(a, "marker_"), place(b, "marker_")), 0.02)
            for joint in ("joint_1_deg", "joint_2_deg", "joint_3_deg"):
                self.assertAlmostEqual(float(a[joint]), float(b[joint]), delta=0.01)
        truth = self.truth("arm")
        self.runs("world", "sample", "arm", "--seed", SEED, "--points", len(live), "--out", "points")
        how = ("--arm", "phantom-premium-1.5")
        sampled = self.result("calibrate", "arm", "--samples", "live/arm.csv", *how)
        made = self.result("calibrate", "arm", "--samples", "points/arm.csv", *how)
        raw = self.result("calibrate", "arm", "--recording", "s.mcap", *how)
        self.assertAlmostEqual(raw["rms_mm"], sampled["rms_mm"], delta=0.02)
        self.runs("sample", "arm", "--recording", "s.mcap", "--continuous", "--to", parts["poses"][1], "--out", "moving")
        moving = rows_of(self.path("moving", "arm.csv"))
        self.assertGreater(len(moving), 20 * parts["poses"][1])
        carried = self.result("calibrate", "arm", "--samples", "moving/arm.csv", *how, "--free", "gains,offsets,tip,delay")

        def off(result):
            return math.dist(result["base"]["translation_mm"], truth["base"]["translation_mm"])
        print(f"base off: sampled {off(sampled):.2f}, world sample {off(made):.2f}, continuous {off(carried):.2f} mm; "
              f"rms {sampled['rms_mm']:.3f}, {made['rms_mm']:.3f}; delay {carried['delay_s']:.4f} of {truth['delay_s']:.4f} s")
        self.assertLess(off(sampled), max(2.0 * off(made), 0.6))
        self.assertLess(off(carried), max(2.0 * off(made), 0.6))
        self.assertLess(sampled["rms_mm"], 1.2 * made["rms_mm"] + 0.02)
        self.assertAlmostEqual(carried["delay_s"], truth["delay_s"], delta=4e-3)

    def touches(self, tip, parts):
        corners = self.truth("surface")["corners_mm"]
        begin = f"{parts['touches'][0]:.3f}"
        done = self.runs("sample", "touches", "--recording", "s.mcap", "--from", begin, "--tip-mm", tip, "--label", "table", "--out", "found")
        self.assertIn("in the air", done.err)
        found = rows_of(self.path("found", "points.csv"))
        self.assertEqual([row["label"] for row in found], ["table_1", "table_2", "table_3", "table_4"])
        for row, corner in zip(found, corners):
            self.assertLess(math.dist(place(row), corner), 2.0)
            self.assertGreater(int(float(row["frames"])), 20)
            self.assertLess(float(row["std_x_mm"]), 1.5)
            self.assertGreater(float(row["cov_xx_mm2"]), 0.0)
        keys = rows_of(self.path("keys", "points.csv"))
        self.assertEqual(len(keys), 3)
        for row, meant in zip(keys, (found[0], found[2], found[3])):
            self.assertLess(math.dist(place(row), place(meant)), 0.1)
        counts = json.loads(self.read("keys.json"))
        self.assertEqual((counts["touches"], counts["keys"]), (3, 3))
        surface = self.result("calibrate", "surface", "--points", "found/points.csv")
        self.assertLess(surface["rms_mm"], 1.0)

    def pivot(self, pointer, parts):
        begin, end = (f"{t:.3f}" for t in parts["swing"])
        part = ("--recording", "s.mcap", "--from", begin, "--to", end)
        self.runs("sample", "pivot", *part, "--marker", "pointer", "--out", "swing", "--json", "swing.json")
        counts = json.loads(self.read("swing.json"))
        self.assertEqual(len(counts["segments"]), 1, counts)
        self.assertGreater(counts["segments"][0]["poses"], 0.9 * counts["rows"])
        found = self.result("calibrate", "pivot", "--poses", "swing/pivot.csv", "--segments", "segment", "--marker", "pointer")
        self.assertLess(math.dist(found["tip_mm"], pointer), 0.6)
        raw = self.result("calibrate", "pivot", *part, "--marker", "pointer")
        self.assertLess(math.dist(raw["tip_mm"], found["tip_mm"]), 0.2)
        # Of the whole session, the poses in which the pointer is carried and touches included.
        self.runs("sample", "pivot", "--recording", "s.mcap", "--marker", "pointer", "--out", "whole", "--json", "whole.json")
        segments = json.loads(self.read("whole.json"))["segments"]
        self.assertEqual(len(segments), 1, segments)
        self.assertLess(segments[0]["from_s"], parts["swing"][0] + 1.0)
        self.assertGreater(segments[0]["to_s"], parts["swing"][1] - 0.5)

    def tools(self, parts):
        part = ("--recording", "s.mcap", "--from", f"{parts['swing'][0]:.3f}", "--to", f"{parts['swing'][1]:.3f}")
        self.runs("sample", "tools", *part, "--marker", "camera_marker=head.csv", "--marker", "pointer", "--out", "tools")
        self.runs("sample", "tools", *part, "--reference", "camera_marker", "--marker", "pointer", "--out", "relative")
        head = {row["time_s"]: row for row in rows_of(self.path("tools", "head.csv"))}
        plain = {row["time_s"]: row for row in rows_of(self.path("tools", "pointer.csv"))}
        relative = rows_of(self.path("relative", "pointer.csv"))
        self.assertGreater(len(relative), 100)
        for row in relative:
            body, marker = head[row["time_s"]], plain[row["time_s"]]
            between = [a - b for a, b in zip(place(marker), place(body))]
            turned = [sum(matrix(body)[k][i] * between[k] for k in range(3)) for i in range(3)]
            self.assertLess(math.dist(turned, place(row)), 1e-5)
            self.assertGreater(float(row["cov_x_x_mm2"]), float(marker["cov_x_x_mm2"]))

    def refusals(self, tip):
        self.no(["sample", "board", "--recording", "s.mcap", "--out", "none"], 1, "no pictures of the left camera", "--pictures")
        self.no(["sample", "arm", "--out", "none"], 2, "--arm is required")
        self.no(["sample", "touches", "--recording", "s.mcap", "--out", "none"], 2, "--tip-mm")
        self.no(["sample", "pivot", "--recording", "s.mcap", "--marker", "stylus", "--out", "none"], 2, "tip_marker, camera_marker or pointer")
        self.no(["sample", "touches", "--recording", "s.mcap", "--to", "1", "--tip-mm", tip, "--out", "none"], 1, "pointer was never seen")
        self.no(["sample", "arm", "--recording", "none.mcap", "--out", "none"], 2, "none.mcap")
        self.no(["sample", "arm", "--recording", "s.mcap", "--arm", "lab", "--out", "none"], 2, "--recording")
        self.assertFalse(os.path.exists(self.path("none")))


if __name__ == "__main__":
    unittest.main()
