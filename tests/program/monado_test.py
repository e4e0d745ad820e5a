#!/usr/bin/env python3
"""Pictures in a headset through Monado: what its window shows of them. Not tried where Monado is not installed (docs/guides/headset.md)."""
import math
import signal
import unittest

from laboratory import LaboratoryTest
from monado import EYE_PX, Dots, Head, MonadoTest, run_alone
from program import wait_until

ALLOWED_PX = 0.4  # of the 480 across an eye


def centroid(picture, eye, channel):
    """Of a colour in an eye's half, from its upper left corner; pixel centres have halves."""
    weight = across = down = 0
    for row in range(EYE_PX[1]):
        begin = 4 * (row * picture.width + eye * EYE_PX[0])
        line = picture.data[begin + 2 - channel:begin + 4 * EYE_PX[0]:4]
        if max(line) < 4:
            continue
        weight += sum(line)
        across += sum((column + 0.5) * value for column, value in enumerate(line) if value)
        down += (row + 0.5) * sum(line)
    return (across / weight, down / weight) if weight else None


class Monado(MonadoTest):
    """With dots, greys and nothing else."""

    def setUp(self):
        super().setUp()
        self.dots = Dots(self)

    def frames_pass(self, count):
        before = self.dots("facts")["frames"]
        wait_until(lambda: self.dots("facts")["frames"] >= before + count, "frames pass")
        return True

    def worst(self, places, taken, seen):
        """px, across or down, by which a dot is off that was seen from `taken` and is looked at from `seen`."""
        picture, worst = self.steady_picture(), 0.0
        for eye in (0, 1):
            for channel in range(3):
                found = centroid(picture, eye, channel)
                self.assertIsNotNone(found, f"eye {eye} sees no dot {channel}")
                true = seen.pixel(taken.room(places[eye][channel]), eye)
                worst = max(worst, *(abs(a - b) for a, b in zip(found, true)))
        return worst

    def test_a_picture_stays_where_it_was_taken_when_the_head_moves(self):
        taken = Head()
        places = self.dots("dots")["places"]
        measured = {"drawn for where the head is": self.worst(places, taken, taken)}
        for name, seen in (("turned 5 deg", Head(left_deg=5)), ("turned 10 deg right, 4 deg up", Head(left_deg=-10, up_deg=4)),
                           ("5 cm to the right", Head(at=(0.05, 1.6, 0.0))), ("5 cm up and nearer", Head(at=(0.0, 1.64, -0.03)))):
            self.put_head(seen)
            measured[name] = self.worst(places, taken, seen)
        # The instrument can fail: a picture that is said to be taken from where the head is now is off by the head's way.
        self.put_head(Head(left_deg=5))
        self.steady_picture()
        self.dots("dots")
        wrong = self.worst(places, taken, Head(left_deg=5))
        print("px of 480:", {name: round(px, 3) for name, px in measured.items()}, "and with the display's pose", round(wrong, 1))
        self.assertLess(max(measured.values()), ALLOWED_PX, measured)
        self.assertGreater(wrong, EYE_PX[0] / 85 * 5 * 0.7)

    def test_bytes_are_shown_as_they_were_handed_over(self):
        places = self.dots("greys")["places"]
        picture, head, worst = self.steady_picture(), Head(), 0
        for eye in (0, 1):
            for level, place in enumerate(places[eye]):
                x, y = head.pixel(head.room(place), eye)
                shown = picture.at(eye * EYE_PX[0] + math.floor(x), math.floor(y))
                worst = max(worst, *(abs(a - b) for a, b in zip(shown, (level, 255 - level, level ^ 0x55))))
        print("bytes differ by at most", worst)
        self.assertEqual(worst, 0)

    def test_frames_go_on_while_nobody_hands_anything_over(self):
        self.dots("dots")
        before = self.dots("facts")
        self.frames_pass(120)
        after = self.dots("facts")
        self.assertEqual(after["pictures"], 1)
        self.assertEqual(after["with_picture"] - before["with_picture"], after["frames"] - before["frames"])
        self.assertEqual(after["unplaced"], 0)


class Program(MonadoTest, LaboratoryTest):
    def frames_pass(self, count):
        return True

    def test_the_runtime_goes_returns_hangs_and_nobody_waits_for_it(self):
        world, physics = self.start_world(), self.start_physics()
        graphics = self.start_graphics("--player", "--headset")
        self.assertTrue(graphics.says("shows pictures in the headset Monado: Remote HMD (Monado"), graphics.lines())
        wait_until(self.shows_something, "the display shows the camera's picture")
        self.stop_monado()
        self.assertTrue(graphics.says("XR_ERROR_INSTANCE_LOST"), graphics.lines())
        self.start_monado()
        self.assertTrue(graphics.says("Remote HMD shows pictures again"), graphics.lines())
        wait_until(self.shows_something, "the display shows pictures again")
        self.monado.send_signal(signal.SIGSTOP)
        self.assertTrue(graphics.says("no longer answers: what it shows stands still"), graphics.lines())
        lines = self.stop_in_order(graphics, physics, world)[0]
        self.assertTrue(any("the runtime does not return; it is left to itself" in line for line in lines), lines)


if __name__ == "__main__":
    run_alone()
    unittest.main(verbosity=2)  # why it was not tried, too
