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


def yellow(red, green, blue):
    """The pyramid of what the player's camera sees, in a view from the side."""
    return red > 130 and abs(red - green) < 45 and min(red, green) - blue > 75


def bat(red, green, blue):
    """Either side of it."""
    return dark(red, green, blue) or (red > 90 and green < 60 and blue < 60)


class Window(LaboratoryTest):
    DESKTOP = 1280, 900

    def setUp(self):
        super().setUp()
        self.desktop = Desktop(*self.DESKTOP)
        self.addCleanup(self.desktop.close)
        self.sound = self.path("sound.wav")
        settings = self.write("sound.conf", f"[general]\ndrivers = wave\n[wave]\nfile = {self.sound}\n")
        self.environment.update(DISPLAY=self.desktop.name, ALSOFT_CONF=settings, ALSOFT_DRIVERS="wave")
        self.environment.pop("WAYLAND_DISPLAY", None)

    def start_playing(self, *options, size=(960, 720)):
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
        self.desktop.resize(self.window, *size)
        self.sees(lambda: self.look().share((0, 0, *size), black) < 0.2, "the window shows the camera's picture")
        self.desktop.press("l")  # from strings to a blade, which fills the places that are looked at

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
        # Strings, as it had at first: the table is seen through them.
        self.desktop.press("l")
        self.sees(lambda: self.look().share((here[0] - 30, here[1] - 20, 60, 40), blue) > 0.5, "the bat has strings")
        self.desktop.press("l")
        self.sees(lambda: self.bat_is_at(*here), "the bat has a blade again")
        # `A` gives the bat back to the program, which goes on from there without frightening the arm; and takes it again.
        self.desktop.press("a")
        self.sees(lambda: not self.bat_is_at(*here), "the program has the bat")
        self.desktop.press("a")
        self.sees(lambda: self.bat_is_at(*here), "the bat is taken back")
        # A busy machine has warnings of its own; of too fast a hand the physics server would have spoken.
        self.assertFalse([line for line in self.physics.lines() if "overspeed" in line])
        # `?` lists the keys; again takes the list away.
        table, middle = (690, 440, 90, 90), (330, 260, 300, 200)
        self.sees(lambda: self.look().share(table, blue) > 0.7, "the table is there")
        self.desktop.press("Shift_L", "question")
        self.sees(lambda: self.look().share(table, blue) < 0.1, "the keys are listed")
        self.desktop.press("Shift_L", "question")
        self.sees(lambda: self.look().share(table, blue) > 0.7, "the list goes")
        # The first ball has been played and is gone; then the space bar serves, and the ball is heard.
        self.sees(lambda: self.look().share(whole, orange) < 2e-4, "no ball is there")

        def ball_is_served():  # again and again: on a busy machine a ball is gone before the picture is looked at
            self.desktop.press("space")
            return self.look().share(whole, orange, 1) > 4e-4
        self.sees(ball_is_served, "a ball is served")
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


class Monitor(Window):
    DESKTOP = 1620, 900
    test_a_person_takes_the_bat_plays_reads_the_help_and_quits = None  # of the class above

    def share(self, window, wanted, box=None):
        picture = self.desktop.picture(window)
        return picture.share(box or (0, 0, picture.width, picture.height), wanted)

    def test_those_who_look_on_have_a_window_of_their_own_and_v_turns_each(self):
        self.start_playing("--player", "--monitor", "outside")
        self.sees(lambda: self.desktop.window("Palpate monitor") is not None, "a second window opens")
        monitor = self.desktop.window("Palpate monitor")
        self.desktop.resize(monitor, 640, 480, x=970)
        self.assertEqual(self.desktop.display.get_input_focus().focus, self.window, "it does not take the keys away")
        pyramid, none = 8e-4, 2e-4  # of the picture
        self.sees(lambda: self.share(monitor, yellow) > pyramid, "the play is seen from the side")
        self.sees(lambda: self.share(self.window, yellow) < none, "the player does not see it so")
        # The mouse leads the bat in the picture that is seen.
        self.desktop.point(330, 470)
        self.sees(lambda: self.bat_is_at(330, 470), "the bat goes to the pointer")
        self.desktop.press("v")
        self.sees(lambda: self.share(self.window, yellow) > pyramid, "the player sees it from the side, too")
        here, there = (477, 300), (445, 215)
        for place in (here, there, here):
            self.desktop.point(*place)
            at, other = ((x - 6, y - 6, 12, 12) for x, y in (place, there if place == here else here))
            self.sees(lambda: self.share(self.window, bat, at) > 0.95 and self.share(self.window, bat, other) < 0.3,
                      f"the bat goes to {place[0]} from the side")
        self.desktop.press("v")
        self.sees(lambda: self.share(self.window, yellow) < none, "the player sees with their own eyes again")
        # A copy, with the warnings and without the keys.
        self.desktop.focus(monitor)
        self.desktop.press("v")
        self.sees(lambda: self.share(monitor, yellow) < none and self.share(monitor, blue) > 0.1, "the second window is a copy")
        self.desktop.focus(self.window)
        self.desktop.press("Shift_L", "question")
        self.sees(lambda: self.share(self.window, blue, (690, 440, 90, 90)) < 0.1, "the keys are listed for the player")
        self.sees(lambda: self.share(monitor, blue, (460, 293, 60, 60)) > 0.7, "those who look on see the table")
        self.desktop.press("Shift_L", "question")
        self.physics.send(signal.SIGSTOP)
        for window, upper in ((self.window, (100, 100, 760, 200)), (monitor, (67, 67, 507, 133))):
            self.sees(lambda: self.share(window, amber, upper) > 0.03, "the warning stands in each")
        self.physics.send(signal.SIGCONT)
        # Closing it is no end of play.
        self.desktop.focus(monitor)
        self.desktop.press("q")
        self.assertTrue(self.graphics.says("the monitor window is closed"), self.graphics.lines())
        self.sees(lambda: self.desktop.window("Palpate monitor") is None, "the second window goes")
        self.desktop.focus(self.window)
        here = (400, 430)
        self.desktop.point(*here)
        self.sees(lambda: self.bat_is_at(*here), "the play goes on")
        figures = self.quits_in_order("q")
        # At least what was seen there above; how many more depends on the machine.
        self.assertGreaterEqual(figures["window"]["monitor"]["pictures"], 4)

    def test_one_cameras_picture_stands_before_both_eyes(self):
        self.start_playing("--biocular", size=(1280, 480))

        def alike():
            # Apart from the pixels in which two halves that are scaled alike may round otherwise.
            picture = self.look()
            rows = range(100, 380, 20)
            return sum(picture.at(x, y) == picture.at(x + 640, y) for y in rows for x in range(0, 640, 20)) / (len(rows) * 32)
        self.sees(lambda: alike() > 0.99, "both halves are alike")
        self.sees(lambda: self.look().share((150, 300, 300, 100), blue) > 0.3, "the table is there")
        # The bat under the pointer, in either half, is in both: 960x720's (330, 470) is (220, 313) here.
        for eye, (x, y) in ((0, (220, 313)), (1, (320, 267))):
            self.desktop.point(x + 640 * eye, y)
            for half in (0, 640):
                self.sees(lambda: self.look().share((x + half - 20, y - 13, 40, 26), dark) > 0.9, f"the bat goes to {x + half}")
        # Each eye reads the keys.
        self.desktop.press("Shift_L", "question")
        self.sees(lambda: all(self.look().share((half + 440, 290, 60, 60), blue) < 0.1 for half in (0, 640)), "each eye reads the keys")
        self.quits_in_order("q")


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

    def test_what_stands_in_a_window_needs_one(self):
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--mouse"), 2, "--mouse", "--window")
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--monitor", "copy"), 2, "--monitor", "--window")
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--biocular"), 2, "--biocular", "--window")
        self.says_no(self.run_program("demo", "--headless", "--monitor", "copy"), 2, "--monitor", "--headless", "leave one of them out")
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--window", "--monitor", "inside"), 2, "--monitor", "'inside'",
                     "copy or outside")

    def test_two_cameras_need_no_biocular_view(self):
        text = self.read("rig.toml").decode()

        def part(name):
            begin = text.index(f"[{name}]")
            end = text.find("\n[", begin + 1)
            return text[begin:end if end > 0 else len(text)].replace(f"[{name}", f"[right_{name}")
        self.write("two.toml", text + "\n" + part("camera") + "\n" + part("hand_eye") + "\n")
        self.says_no(self.run_program("graphics", "--rig", "two.toml", "--window", "--biocular"), 2, "--biocular", "two cameras",
                     "leave it out")


if __name__ == "__main__":
    unittest.main()
