#!/usr/bin/python3
"""palpate calibrate all and verify with --window: a person is led in a window, whose keys answer as the terminal's do."""
import os
import tomllib
import unittest

from display import Desktop
from person_at_devices import Laboratory, Session
from program import ProgramTest, wait_until

DEVICES = ("--arm", "lab", "--tracker", "lab", "--camera", "lab", "--rig", "rig.toml", "--poses", "20")
SEED = "5"
SIZE = 1280, 800
PICTURE = 40, 80, 780, 440  # within the camera's picture
PLANS = 880, 60, 390, 730
WORDS = 10, 580, 840, 210


def ground(red, green, blue):
    """Of the page and its boxes, where nothing is drawn."""
    return max(red, green, blue) < 60 and blue >= green >= red


def table(red, green, blue):
    """The table of the laboratory, in the camera's picture."""
    return blue > 110 and blue - red > 60


def white(red, green, blue):
    return min(red, green, blue) > 225


def green(red, green_, blue):
    """A step that is done, a marker that is held still, a result that is fine."""
    return green_ > 190 and red < 130 and blue < 170


def light_blue(red, green_, blue):
    """What the person holds."""
    return red < 130 and green_ > 180 and blue > 230


def amber(red, green_, blue):
    """Where to hold it."""
    return red > 230 and 160 < green_ < 215 and blue < 100


class SessionWindow(ProgramTest):
    _whole = None  # a rig with everything, calibrated once

    def calibrated(self):
        """Its text."""
        if SessionWindow._whole is None:
            self.runs("calibrate", "all", "--seed", SEED, "--rig", "whole.toml", "--poses", "20")
            SessionWindow._whole = self.read("whole.toml").decode()
        return SessionWindow._whole

    def setUp(self):
        super().setUp()
        self.desktop = Desktop(*SIZE)
        self.addCleanup(self.desktop.close)
        self.environment.update(DISPLAY=self.desktop.name, ALSOFT_DRIVERS="null")
        self.environment.pop("WAYLAND_DISPLAY", None)

    def opens(self, session, title):
        self.session, self.place = session, None

        def there():
            self.place = self.desktop.window(title)
            return self.place is not None
        self.sees(there, "the window opens")
        self.desktop.resize(self.place, *SIZE)

    def sees(self, condition, what):
        try:
            wait_until(lambda: self.session.process.poll() is not None or condition(), what)
        finally:
            self.keep(what)
        self.assertIsNone(self.session.process.poll(), f"{what}: {self.session.lines[-5:]}")

    def keep(self, what):
        if "KEEP_PICTURES" in os.environ:
            self.desktop.picture().write(os.path.join(os.environ["KEEP_PICTURES"], what.replace(" ", "-").replace("'", "") + ".png"))

    def share(self, box, wanted):
        return self.desktop.picture(self.place).share(box, wanted)

    def test_a_person_is_led_through_a_step_and_answers_with_the_windows_keys(self):
        self.runs("rig", "new", "rig.toml")
        laboratory = Laboratory(self, "--seed", SEED)
        ended = []
        # Nothing is pressed in the terminal at a step's end.
        session = Session(self, laboratory, *DEVICES, "--window", at_the_end=lambda step, told: ended.append(step) or "")
        self.opens(session, "Palpate calibration")
        self.sees(lambda: self.share(PICTURE, table) > 0.02, "the camera's live picture is shown")
        self.sees(lambda: self.share(PLANS, light_blue) > 1e-4, "the pointer is drawn in the plans")
        self.assertGreater(self.share(WORDS, white), 0.005)  # what to do, in words
        self.sees(lambda: len(ended) == 1, "the first step ends")
        self.sees(lambda: self.share(PICTURE, green) > 0.002, "its result is shown")
        self.desktop.focus(self.place)
        self.desktop.press("r")
        self.sees(lambda: len(ended) == 2, "it is repeated")
        self.assertEqual(ended, ["pointer tip", "pointer tip"])
        self.desktop.press("Return")
        self.sees(lambda: any(told.get("step") == "table and wall" for told in session.shown), "the second step begins")
        self.sees(lambda: len(ended) == 3, "the second step ends")
        self.desktop.press("q")
        self.assertEqual(session.ends(), 1, session.lines[-5:])
        self.assertIn("goes on with the next", session.lines[-1])
        self.assertIn("--- 2 of 8: table and wall", "".join(session.lines))  # the terminal's lines stay
        self.assertIn("pointer_pivot", tomllib.loads(self.read("rig.toml").decode()))

    def test_closing_the_window_stops_the_session_and_keeps_what_is_done(self):
        self.runs("rig", "new", "rig.toml")
        laboratory = Laboratory(self, "--seed", SEED)
        session = Session(self, laboratory, *DEVICES, "--window")
        self.opens(session, "Palpate calibration")
        self.sees(lambda: any(told.get("step") == "table and wall" for told in session.shown), "the second step begins")
        self.desktop.close_window(self.place)
        self.assertEqual(session.ends(), 1, session.lines[-5:])
        self.assertIn("stopped", session.lines[-1])
        self.assertIn("pointer_pivot", tomllib.loads(self.read("rig.toml").decode()))

    def test_a_rig_whose_camera_is_calibrated_has_the_target_drawn_into_the_picture(self):
        parts = self.calibrated().split("\n[")
        self.write("rig.toml", "\n[".join(part for part in parts if not part.startswith(("arm]", "arm."))).encode())
        self.assertNotIn("arm", tomllib.loads(self.read("rig.toml").decode()))
        laboratory = Laboratory(self, "--seed", SEED)
        session = Session(self, laboratory, *DEVICES, "--window")
        self.opens(session, "Palpate calibration")
        self.sees(lambda: any("tip_m" in told for told in session.shown), "a place is shown")
        # The hand is not always in view; the goal is, or an arrow towards it.
        self.sees(lambda: self.share(PICTURE, amber) > 5e-4, "the goal is drawn into the picture")
        self.sees(lambda: self.share(PLANS, amber) > 5e-4, "the goal is drawn into the plans")
        session.process.terminate()
        self.assertEqual(session.ends(), 1, session.lines[-5:])

    def test_verify_leads_in_a_window_too(self):
        self.write("rig.toml", self.calibrated().encode())
        laboratory = Laboratory(self, "--seed", SEED)
        session = Session(self, laboratory, *DEVICES[:-2], "--quick", "--window", command=("verify",))
        self.opens(session, "Palpate verification")
        self.sees(lambda: any(told.get("gesture") == "touch" for told in session.shown), "a touch is asked for")
        self.sees(lambda: self.share(PICTURE, amber) > 5e-4, "the corner is marked in the picture")
        self.desktop.focus(self.place)
        self.desktop.press("q")
        self.assertEqual(session.ends(), 1, session.lines[-5:])

    def test_where_no_window_can_be_had_the_way_out_is_named(self):
        self.runs("rig", "new", "rig.toml")
        del self.environment["DISPLAY"]
        self.says_no(self.run_program("calibrate", "all", *DEVICES, "--window"), 1, "no display", "leave --window away")
        self.refuses(["calibrate", "all", "--rig", "rig.toml", "--window"], 2, "--window", "--arm")
        self.refuses(["verify", "--rig", "rig.toml", "--window"], 2, "--window", "--arm")


if __name__ == "__main__":
    unittest.main()
