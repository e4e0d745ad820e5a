"""The window as a person meets it: opened on a desktop, played with the mouse, its keys pressed, its picture looked at."""
import json
import os
import signal
import struct
import unittest

from display import Desktop
from laboratory import LaboratoryTest
from program import wait_until

BETWEEN_SERVES_S = "600"  # so that only the space bar serves


def dark(red, green, blue):
    """The back of the bat."""
    return max(red, green, blue) < 70


def orange(red, green, blue):
    """The ball."""
    return red > 170 and 60 < green < 190 and blue < 90 and red - blue > 110


def amber(red, green, blue):
    """The ground of warnings."""
    return red > 215 and 140 < green < 215 and blue < 110


def black(red, green, blue):
    return max(red, green, blue) < 3


def blue(red, green, blue):
    """The table."""
    return blue > 110 and blue - red > 60


def white(red, green, blue):
    return min(red, green, blue) > 225


class Window(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.desktop = Desktop()
        self.addCleanup(self.desktop.close)
        self.sound = self.path("sound.wav")
        settings = self.write("sound.conf", f"[general]\ndrivers = wave\n[wave]\nfile = {self.sound}\n")
        self.environment.update(DISPLAY=self.desktop.name, ALSOFT_CONF=settings, ALSOFT_DRIVERS="wave")
        self.environment.pop("WAYLAND_DISPLAY", None)

    def start_playing(self, *options):
        # A head that keeps still, so that a place in the picture stays one in the world.
        self.runs("world", "new", "calm.toml")
        text = self.read("calm.toml").decode()
        calm = text.replace("turn_peak_deg_s = 50.0", "turn_peak_deg_s = 0.0").replace("shake_deg = 0.4", "shake_deg = 0.0")
        self.assertNotEqual(text, calm)
        self.write("calm.toml", calm)
        self.start_world("--world", "calm.toml")
        self.physics = self.start_physics("--serve-pause-s", BETWEEN_SERVES_S)
        self.graphics = self.start_graphics("--window", "--mouse", "--json", "graphics.json", *options)
        self.sees(lambda: self.desktop.window("Palpate") is not None, "the window opens")
        self.window = self.desktop.window("Palpate")
        self.desktop.resize(self.window, 960, 720)
        self.sees(lambda: self.look().share((0, 0, 960, 720), black) < 0.2, "the window shows the camera's picture")

    def look(self):
        return self.desktop.picture(self.window)

    def sees(self, condition, what):
        try:
            wait_until(lambda: self.graphics.ended() or condition(), what)
        except AssertionError:
            if "KEEP_PICTURES" in os.environ:
                self.desktop.picture().write(os.path.join(os.environ["KEEP_PICTURES"], "missed.png"))
            raise
        self.assertFalse(self.graphics.ended(), f"{what}: {self.graphics.lines()}")
        if "KEEP_PICTURES" in os.environ:
            self.desktop.picture().write(os.path.join(os.environ["KEEP_PICTURES"], what.replace(" ", "-").replace("'", "") + ".png"))

    def bat_is_at(self, x, y):
        return self.look().share((x - 30, y - 20, 60, 40), dark) > 0.9

    def quits_in_order(self, *keys):
        self.desktop.press(*keys)
        done = self.graphics.ends()
        self.assertEqual(done.code, 0, done)
        return json.loads(self.read("graphics.json"))

    def test_a_person_takes_the_bat_plays_reads_the_help_and_quits(self):
        self.start_playing("--player")
        whole, upper = (0, 0, 960, 720), (100, 100, 760, 200)
        # The mouse moves the bat.
        here, there = (330, 470), (480, 400)
        for place in (here, there, here):
            self.desktop.point(*place)
            self.sees(lambda: self.bat_is_at(*place), f"the bat goes to {place[0]}")
            other = there if place == here else here
            self.assertFalse(self.bat_is_at(other[0], other[1]))
        # `?` lists the keys; again takes the list away.
        table, middle = (690, 440, 90, 90), (330, 260, 300, 200)
        self.assertGreater(self.look().share(table, blue), 0.7)
        self.desktop.press("Shift_L", "question")
        self.sees(lambda: self.look().share(table, blue) < 0.1, "the keys are listed")
        self.desktop.press("Shift_L", "question")
        self.sees(lambda: self.look().share(table, blue) > 0.7, "the list goes")
        # The first ball has been played and is gone; then the space bar serves, and the ball is heard.
        self.sees(lambda: self.look().share(whole, orange) < 2e-4, "no ball is there")
        self.desktop.press("space")
        self.sees(lambda: self.look().share(whole, orange, 1) > 4e-4, "a ball is served")
        self.desktop.press("p")
        self.sees(lambda: self.look().share(middle, white, 1) > 0.01, "the pause is shown")
        self.desktop.press("p")
        self.sees(lambda: self.look().share(middle, white, 1) < 0.01, "the game goes on")
        # Warnings come and go with their cause.
        self.sees(lambda: self.look().share(upper, amber) < 0.01, "no warning stands")
        self.physics.send(signal.SIGSTOP)
        self.sees(lambda: self.look().share(upper, amber) > 0.03, "the silence of the physics server is told")
        self.physics.send(signal.SIGCONT)
        self.sees(lambda: self.look().share(upper, amber) < 0.01, "the warning goes")
        # A window of another shape: bars beside the picture, which keeps its proportions.
        self.desktop.resize(self.window, 1200, 600)
        self.sees(lambda: self.look().share((20, 250, 160, 200), black) > 0.99 and
                  self.look().share((1020, 250, 160, 200), black) > 0.99 and
                  self.look().share((220, 20, 760, 560), black) < 0.2, "the wide window has bars at its sides")
        self.desktop.press("F11")
        self.sees(lambda: self.desktop.box(self.window)[2:] == (1280, 900), "the window fills the screen")
        self.desktop.press("F11")
        self.sees(lambda: self.desktop.box(self.window)[2:] == (1200, 600), "the window is a window again")
        figures = self.quits_in_order("q")
        self.assertTrue(figures["window"]["played_by_mouse"])
        self.assertGreaterEqual(figures["window"]["bounces_heard"], 1)
        with open(self.sound, "rb") as file:
            content = file.read()[44:]
        loudest = max(abs(sample) for (sample,) in struct.iter_unpack("<h", content[:len(content) // 2 * 2]))
        self.assertGreater(loudest, 300)


class NoWindow(LaboratoryTest):
    def test_without_a_display_it_says_so(self):
        self.environment.pop("DISPLAY", None)
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--window"), 1, "DISPLAY is not set", "without a window")
        self.environment["DISPLAY"] = ":54321"
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--window"), 1, ":54321 cannot be opened")

    def test_without_opengl_it_says_so_at_once_and_all_others_go_on(self):
        world, physics = self.start_world(), self.start_physics()
        nothing_draws = dict(self.environment, __EGL_VENDOR_LIBRARY_DIRS=self.path("nowhere"))
        self.environment, before = nothing_draws, self.environment
        self.says_no(self.run_program("graphics", "--rig", self.rig), 1, "OpenGL 3.3", "libegl-mesa0")
        findings = json.loads(self.run_program("doctor", "--json", "-").out)["findings"]
        self.assertEqual([f["verdict"] for f in findings if f["area"] == "graphics"], ["in the way"], findings)
        # A laboratory that cannot draw what its camera sees still has an arm.
        blind = self.start("world", "run", "--name", "blind")
        self.assertTrue(blind.says("arm and tracker go on without pictures"), blind.lines())
        self.environment = before
        graphics = self.start_graphics()
        self.assertFalse(blind.ended())
        self.assertEqual(self.stop_in_order(graphics, physics, blind, world)[:2], [[], []])

    def test_doctor_says_whether_a_window_can_be_had(self):
        def window():
            done = self.run_program("doctor", "--json", "-")
            self.assertLessEqual(len(done.lines), 1, "no library speaks for itself")
            findings = json.loads(done.out)["findings"]
            self.assertTrue(any((f["area"], f["name"]) == ("desktop", "sound") for f in findings))
            return next(f for f in findings if (f["area"], f["name"]) == ("desktop", "window"))
        self.environment.pop("DISPLAY", None)
        self.environment.pop("WAYLAND_DISPLAY", None)
        self.assertEqual(window()["verdict"], "worth knowing")
        self.assertIn("DISPLAY is not set", window()["value"])
        self.assertIn("without a window", window()["remedy"])
        desktop = Desktop()
        self.addCleanup(desktop.close)
        self.environment["DISPLAY"] = desktop.name
        self.assertEqual(window()["verdict"], "ok", window())
        self.assertIn(desktop.name, window()["value"])

    def test_the_mouse_needs_a_window(self):
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--mouse"), 2, "--mouse", "--window")


if __name__ == "__main__":
    unittest.main()
