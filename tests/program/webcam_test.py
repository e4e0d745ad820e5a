"""A desk, a webcam, a printed board and a mouse, as a person meets them: from the page to a game in a window."""
import json
import os
import unittest

from desk import DeskTest
from program import wait_until

LENS = {"fx": 610.0, "fy": 611.0, "cx": 322.0, "cy": 236.0}  # of tests/board_film.cpp
NOT_SEEN = "of its 24 corners are seen"


def orange(red, green, blue):
    """The ball."""
    return red > 170 and 60 < green < 170 and blue < 80 and red - blue > 120


def green_line(red, green, blue):
    """The outline of table and wall."""
    return green > 120 and green - red > 40 and green - blue > 30


def grey(red, green, blue):
    """What the camera saw; black would be no picture."""
    return 10 < red < 250 and abs(red - green) < 12 and abs(green - blue) < 12


class Webcam(DeskTest):
    def sees(self, condition, what):
        wait_until(lambda: self.play.ended() or condition(), what)
        self.assertFalse(self.play.ended(), f"{what}: {self.play.lines()}")
        if "KEEP_PICTURES" in os.environ:
            self.desktop.picture().write(os.path.join(os.environ["KEEP_PICTURES"], "webcam-" + what.replace(" ", "-").replace("'", "") + ".png"))

    def test_from_the_printer_to_a_game(self):
        self.make_rig()
        self.assertTrue(DeskTest._pdf.startswith(b"%PDF-1.4") and DeskTest._pdf.endswith(b"%%EOF\n"))
        self.assertIn(b'dictionary = "4x4_50"', DeskTest._board)
        self.assertLess(DeskTest._lens["rms_px"], 0.3)
        for key, truth in LENS.items():  # 1.5 px: what 12 views with 0.05 px of noise leave open, twice
            self.assertLess(abs(DeskTest._lens[key] - truth), max(1.5, 4 * DeskTest._lens["std"][key]), key)
        self.assertIn("complete", self.runs("rig", "check", "desk.rig.toml").out)
        self.film("film", "board.toml", "desk.mp4", 12)
        self.open_desktop()
        self.play = self.start("play", "--camera", "video:desk.mp4", "--player", "--json", "figures.json")
        self.sees(lambda: self.desktop.window("Palpate") is not None, "the window opens")
        window = self.desktop.window("Palpate")
        self.desktop.resize(window, 960, 720)
        whole, below_warnings = (0, 60, 960, 560), (0, 230, 960, 420)

        def share(wanted, box=whole):
            return self.desktop.picture(window).share(box, wanted)
        self.sees(lambda: share(grey) > 0.7 and share(green_line) > 2e-4, "the table stands on the board")
        self.sees(lambda: share(orange, below_warnings) > 5e-5, "a ball flies over the desk")
        self.assertTrue(self.play.says(NOT_SEEN), self.play.lines())
        self.sees(lambda: share(grey) > 0.7 and share(green_line) < 2e-5, "the picture goes on without the board")
        self.assertTrue(self.play.says("board: found again"), self.play.lines())
        self.sees(lambda: share(green_line) > 2e-4, "the table is back")
        self.desktop.press("q")
        done = self.play.ends()
        self.assertEqual(done.code, 0, done)
        self.assertFalse([line for line in done.lines if "tracker" in line], done)
        figures = json.loads(self.read("figures.json"))
        self.assertGreater(figures["exchange"]["frames"], 10)
        self.assertGreaterEqual(figures["graphics"]["conditions"]["board_lost"], 1)
        left = [name for name in os.listdir(os.path.join(self.meeting, "palpate")) if not name.endswith(".lock") and not name.startswith(("trip_", "realtime_trips."))]
        self.assertEqual(left, [])

    def test_another_board_on_the_desk_is_said(self):
        self.make_rig()
        self.film("film", "board.toml", "desk.mp4", 2)
        rig = self.read("desk.rig.toml").decode()
        self.write("desk.rig.toml", rig.replace('"4x4_50"', '"5x5_50"'))
        self.open_desktop()
        self.play = self.start("play", "--camera", "video:desk.mp4")
        self.assertTrue(self.play.says("has markers of dictionary 4x4_50, the rig file's has 5x5_50"), self.play.lines())
        self.sees(lambda: self.desktop.window("Palpate") is not None, "the window opens")
        self.desktop.press("q")
        self.assertEqual(self.play.ends().code, 0)

    def test_what_cannot_be_is_named_with_its_remedy(self):
        self.make_rig()
        self.refuses(["board", "--squares", "seven"], 2, "--squares 'seven'", "7x5")
        self.refuses(["board", "--paper", "a0"], 2, "--paper 'a0'", "a4, a3 or letter")
        self.refuses(["board", "--out", "board.png"], 2, "--out 'board.png'", ".pdf")
        self.refuses(["board", "--out", "board.pdf"], 2, "board.toml: exists already", "--force")
        self.refuses(["board", "--out", "x.pdf", "--square-mm", "50"], 2, "do not fit a4 paper", "at most")
        self.refuses(["board", "--out", "x.pdf", "--dictionary", "4x4_9"], 2, "dictionary '4x4_9'")
        webcam = ["rig", "webcam", "new.toml", "--board"]
        self.refuses([*webcam, "nowhere.toml"], 2, "nowhere.toml")
        self.refuses([*webcam, "board.toml", "--square-mm", "3.5"], 2, "--square-mm 3.5", "34 mm", "divide by 7")
        self.refuses([*webcam, "board.toml", "--table-mm", "wide"], 2, "--table-mm 'wide'", "750x1000")
        self.refuses(["rig", "webcam", "desk.rig.toml", "--board", "board.toml"], 2, "desk.rig.toml: exists already")
        self.write("new.toml", "")
        self.runs("rig", "webcam", "new.toml", "--board", "board.toml", "--force")
        self.environment["DISPLAY"] = ":54321"
        self.refuses(["play", "--rig", "new.toml"], 1, "lacks camera", "calibrate camera --board")
        self.refuses(["play", "--app", "chess"], 2, "--app chess")
        self.refuses(["play", "--camera", "eye"], 2, "'eye'", "v4l2")
        self.refuses(["play"], 1, ":54321")
        graphics = ["graphics", "--rig", "desk.rig.toml"]
        self.refuses(graphics, 2, "--camera", "printed board", "v4l2")
        self.refuses([*graphics, "--camera", "v4l2", "--tracker", "igtl://localhost:18944"], 2, "--tracker", "leave it out")
        self.refuses([*graphics, "--camera", "v4l2", "--picture-time", "predicted"], 2, "--picture-time predicted", "registered")
        self.refuses(["calibrate", "camera", "--board", "board.toml", "--corners", "board.toml"], 2, "goes with --images")


if __name__ == "__main__":
    unittest.main()
