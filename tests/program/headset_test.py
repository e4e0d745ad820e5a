#!/usr/bin/env python3
"""Pictures in a headset: with a runtime for tests in the graphics server's process, which runs by itself, and goes, hangs and returns as a file says."""
import json
import os
import unittest

from desk import DeskTest
from laboratory import LaboratoryTest

RUNTIME = os.environ["TEST_OPENXR_RUNTIME"]
SHOWS = "shows pictures in the headset test headset (Palpate's test runtime 1.2.3)"


class Headset(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.file = self.path("runtime")
        self.tell("")
        self.environment.update(XR_RUNTIME_JSON=RUNTIME, PALPATE_TEST_RUNTIME_FILE=self.file)

    def tell(self, what):
        with open(self.file, "w", encoding="ascii") as file:
            file.write(what)

    def test_pictures_are_shown_as_they_come_and_again_at_the_displays_rate(self):
        world, physics = self.start_world(), self.start_physics()
        figures = json.loads(self.runs("graphics", "--rig", self.rig, "--player", "--headset", "--picture-time", "predicted", "--seconds", "5", "--json", "-").out)
        self.assertEqual(self.stop_in_order(physics, world), [[], []])
        headset = figures["headset"]
        self.assertEqual(headset["device"], "test headset")
        self.assertGreater(headset["pictures_shown"], 0)
        self.assertLessEqual(headset["pictures"], figures["exchange"]["frames"])  # not those without a pose
        self.assertGreater(headset["frames"], headset["pictures_shown"])
        self.assertEqual(headset["losses"], 0)
        # The bat is held half a metre and more before the camera.
        self.assertGreater(headset["distance_m"], 0.3)
        self.assertLess(headset["distance_m"], 1.5)

    def test_a_runtime_that_goes_and_hangs_is_told_and_nobody_waits_for_it(self):
        world, physics = self.start_world(), self.start_physics()
        graphics = self.start_graphics("--headset")
        self.assertTrue(graphics.says(SHOWS), graphics.lines())
        self.tell("vanish")
        self.assertTrue(graphics.says("XR_ERROR_INSTANCE_LOST"), graphics.lines())
        self.tell("")
        self.assertTrue(graphics.says("test headset shows pictures again"), graphics.lines())
        self.tell("hang")
        self.assertTrue(graphics.says("no longer answers: what it shows stands still"), graphics.lines())
        lines = self.stop_in_order(graphics, physics, world)[0]
        self.assertTrue(any("the runtime does not return; it is left to itself" in line for line in lines), lines)

    def test_the_demo_shows_its_real_time_part_in_a_headset_and_reports_it(self):
        done = self.runs("demo", "--quick", "--headless", "--headset", "--out", "report")
        told = json.loads(self.read("report", "summary.json"))["realtime"]["headset"]
        self.assertEqual(told["device"], "test headset")
        self.assertGreater(told["pictures_shown"], 0, done.err)
        self.assertIn(b"Headset, frames with a picture", self.read("report", "report.html"))
        for name in ("headset_head.csv", "headset_camera.csv"):
            self.assertGreater(len(self.read("report", "raw", name).splitlines()), 10, name)

    def test_without_a_runtime_it_is_refused_at_once(self):
        self.environment["XR_RUNTIME_JSON"] = self.path("none.json")
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--headset"), 1, "headset: no OpenXR runtime is there", "XR_RUNTIME_JSON")
        self.says_no(self.run_program("demo", "--headset", "--headless"), 1, "headset: no OpenXR runtime is there")

    def test_options_that_do_not_go_together_are_wrong_use(self):
        self.says_no(self.run_program("demo", "--headset", "--two-hosts"), 2, "--headset", "--two-hosts")
        self.assertEqual(self.run_program("graphics", "--rig", self.rig, "--headset-distance-m", "1").code, 2)

    def test_the_camera_before_the_eyes_is_found_and_kept_in_the_rig(self):
        # A head that moves is what a marker in a tracker is; the camera's poses are those at a board.
        self.runs("world", "sample", "hand-eye", "--seed", "7", "--out", "samples")
        truth = json.loads(self.read("samples", "truth.json"))
        found = json.loads(self.runs("calibrate", "headset", "--head", "samples/hand.csv", "--camera", "samples/eye.csv", "--rig", self.rig, "--json", "-").out)
        for axis in range(3):
            off = abs(found["translation_mm"][axis] - truth["translation_mm"][axis])
            self.assertLess(off, 4.0 * found["std"]["translation_mm"][axis], (found, truth))
        self.assertLess(abs(found["delay_s"] - truth["delay_s"]), 4.0 * found["delay_std_s"])
        self.assertIn(b"[headset]", self.read("rig.toml"))
        self.assertIn("camera before the eyes", self.runs("rig", "show", self.rig).out)
        self.says_no(self.run_program("calibrate", "headset", "--head", "samples/hand.csv", "--camera", "samples/hand.csv"), 2, "holds the same")

    def test_what_the_calibration_needs_is_written_beside_the_figures(self):
        os.mkdir(self.path("out"))
        world, physics = self.start_world(), self.start_physics()
        self.runs("graphics", "--rig", self.rig, "--headset", "--seconds", "3", "--out", "out")
        self.stop_in_order(physics, world)
        for name in ("headset_head.csv", "headset_camera.csv"):
            lines = self.read("out", name).decode().splitlines()
            self.assertEqual(lines[0], "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz")
            self.assertGreater(len(lines), 10, name)

    def test_the_doctor_names_runtime_and_headset(self):
        found = json.loads(self.run_program("doctor", "--json", "-").out)
        text = json.dumps(found)
        self.assertIn("test headset (Palpate's test runtime 1.2.3)", text)


class OnTheDesk(DeskTest):
    def test_a_game_is_shown_in_the_headset_as_well(self):
        self.make_rig()
        self.film("film", "board.toml", "desk.mp4", 12)
        self.open_desktop()
        play = "play", "--camera", "video:desk.mp4", "--player", "--headset", "--seconds", "3", "--json", "-"
        self.environment["XR_RUNTIME_JSON"] = self.path("none.json")
        self.says_no(self.run_program(*play), 1, "headset: no OpenXR runtime is there", "XR_RUNTIME_JSON")
        self.environment["XR_RUNTIME_JSON"] = RUNTIME
        done = self.runs(*play)
        self.assertIn(SHOWS, done.err)
        self.assertGreater(json.loads(done.out)["headset"]["pictures_shown"], 0)


if __name__ == "__main__":
    unittest.main()
