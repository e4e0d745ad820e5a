#!/usr/bin/env python3
"""palpate sample board, and recording export --igs-mha: a head that looks around the calibration board, beside the truth."""
import json
import math
import signal
import time
import unittest

from person_at_devices import Laboratory
from program import ProgramTest
from tables import numbers, rows_of

SEED = "5"
LOOKED_S = 6.0


def read_sequence(content):
    """Fields of each frame, and the pixels, by a reader of its own."""
    header, pixels = content.split(b"ElementDataFile = LOCAL\n", 1)
    fields, frames = {}, {}
    for line in header.decode("ascii").splitlines():
        key, value = line.split(" = ", 1)
        if key.startswith("Seq_Frame"):
            number, name = key[len("Seq_Frame"):].split("_", 1)
            frames.setdefault(int(number), {})[name] = value
        else:
            fields[key] = value
    return fields, [frames[i] for i in sorted(frames)], pixels


def at_time(poses, t):
    """Place between two neighbours, none where they are no neighbours."""
    for (t0, a), (t1, b) in zip(poses, poses[1:]):
        if t0 <= t <= t1:
            s = (t - t0) / (t1 - t0)
            return t1 - t0, [(1 - s) * x + s * y for x, y in zip(a, b)]
    return None, None


class SamplingBoard(ProgramTest):
    def no(self, arguments, code, *words):
        self.says_no(self.run_program(*arguments), code, *words)

    def test_a_head_that_looks_around_the_board(self):
        for kind in ("camera", "hand-eye"):
            self.runs("world", "sample", kind, "--seed", SEED, "--out", kind)
        laboratory = Laboratory(self, "--seed", SEED)
        laboratory.does({"gesture": "look_around_board"})
        board = self.start("sample", "board", "--camera", "lab", "--tracker", "lab", "--board", "9x6", "--square-mm", "25", "--lens",
                           "camera/truth.json", "--out", "live", "--record", "b.mcap", "--pictures", "jpeg", "--json", "live.json")
        self.assertTrue(board.says("sampling"), board.lines())
        time.sleep(LOOKED_S)
        board.send(signal.SIGINT)
        done = board.ends()
        self.assertEqual(done.code, 0, done)
        laboratory.ends()
        with self.subTest("poses"):
            self.poses()
        with self.subTest("sequence"):
            self.sequence()

    def poses(self):
        counts = json.loads(self.read("live.json"))
        self.assertGreater(counts["poses"], 20, counts)
        self.assertLess(counts["rms_px"], 0.5)
        self.runs("sample", "board", "--recording", "b.mcap", "--lens", "camera/truth.json", "--out", "again", "--json", "again.json")
        live, again = ({row["image"]: row for row in rows_of(self.path(folder, "eye.csv"))} for folder in ("live", "again"))
        both = sorted(set(live) & set(again))
        self.assertGreater(len(both), 0.8 * len(live))
        for image in both:  # through a JPEG
            self.assertLess(math.dist(*(numbers(rows[image], "x_mm", "y_mm", "z_mm") for rows in (live, again))), 8.0)
        since = [float(live[image]["time_s"]) - float(again[image]["time_s"]) for image in both]
        self.assertLess(max(since) - min(since), 2e-3)
        truth = json.loads(self.read("hand-eye", "truth.json"))

        def off(*tables):
            self.runs("calibrate", "hand-eye", *tables, "--estimate-delay", "--json", "result.json")
            result = json.loads(self.read("result.json"))
            return math.dist(result["translation_mm"], truth["translation_mm"]), abs(result["delay_s"] - truth["delay_s"])
        made = off("--hand", "hand-eye/hand.csv", "--eye", "hand-eye/eye.csv")
        found = {folder: off("--hand", f"{folder}/hand.csv", "--eye", f"{folder}/eye.csv") for folder in ("live", "again")}
        found["corners"] = off("--hand", "again/hand.csv", "--corners", "again/corners.csv", "--stamps", "again/stamps.csv", "--lens",
                               "camera/truth.json")
        print(f"hand-eye off, mm and s: world sample {made}, {found}")
        for name, (place, delay) in found.items():
            self.assertLess(place, 3.0 * made[0] + 0.5, name)
            self.assertLess(delay, 2e-3, name)
        # No lens: corners alone, which are enough for one.
        part = ("--recording", "b.mcap", "--to", "1")
        done = self.runs("sample", "board", *part, "--out", "corners")
        self.assertIn("no lens", done.err)
        self.assertTrue(self.read("again", "corners.csv").startswith(self.read("corners", "corners.csv")))
        self.no(["sample", "board", *part, "--board", "13x10", "--out", "none"], 1, "board 13x10 was in none of")

    def sequence(self):
        done = self.runs("recording", "export", "b.mcap", "--igs-mha", "s.igs.mha", "--igs-name", "camera_marker=Image")
        self.assertIn("ImageToTracker", done.out)
        fields, frames, pixels = read_sequence(self.read("s.igs.mha"))
        width, height, count = map(int, fields["DimSize"].split())
        self.assertEqual(list(fields)[0], "ObjectType")
        self.assertEqual((fields["ElementType"], fields["ElementNumberOfChannels"]), ("MET_UCHAR", "3"))
        self.assertEqual(len(frames), count)
        self.assertEqual(len(pixels), 3 * width * height * count)
        self.assertGreater(len(set(pixels[3 * width * height * (count // 2):][:3 * width * height])), 20, "a picture, not one grey")
        self.runs("sample", "tools", "--recording", "b.mcap", "--marker", "camera_marker", "--out", "tools")
        poses = [(float(row["time_s"]), numbers(row, "x_mm", "y_mm", "z_mm")) for row in rows_of(self.path("tools", "camera_marker.csv"))]
        stamps = {float(row["time_s"]) for row in rows_of(self.path("again", "stamps.csv"))}
        valid, known = 0, 0
        for frame in frames:
            t = float(frame["Timestamp"])
            known += any(abs(t - stamp) < 1e-6 for stamp in stamps)
            gap, between = at_time(poses, t)
            m = [float(word) for word in frame["ImageToTrackerTransform"].split()]
            self.assertEqual(m[12:], [0, 0, 0, 1])
            if frame["ImageToTrackerTransformStatus"] == "OK":
                valid += 1
                self.assertLess(gap, 0.1)
                self.assertLess(math.dist(between, (m[3], m[7], m[11])), 1e-3)
                for i in range(3):
                    self.assertAlmostEqual(sum(m[4 * i + k] ** 2 for k in range(3)), 1.0, delta=1e-9)
            elif gap is not None:
                self.assertGreater(gap, 1.5 / 120.0, "hidden in between")
        self.assertGreater(valid, 0.7 * count)
        self.assertEqual(known, len(stamps), "each picture with the board is among the frames, at the same time")


if __name__ == "__main__":
    unittest.main()
