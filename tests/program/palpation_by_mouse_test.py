#!/usr/bin/env python3
"""Somebody at a desk searches the organ with the mouse, and feels with the eyes: the length of the force bar in the window's
pixels is all that is read. Where on the screen the organ lies is known, as the camera stands. What was found is judged
by the program's own record.

TRIES=N: so many (10). FIRST=N: the first one's seed. KEEP_PICTURES=FOLDER: the screen at each step. ORGAN_CACHE=FOLDER: of prepared organs.
"""
import json
import math
import os
import statistics
import time
import unittest

from Xlib import error

from desk import DeskTest
from program import wait_until

WIDTH, HEIGHT = 960, 720
FIRST = int(os.environ.get("FIRST", "1"))  # seed
TRIES = int(os.environ.get("TRIES", "10"))
WANTED_SHARE = 0.8
LOW = 0.85  # of the typical bar: what is shorter is pressed once more
RIM = 0.7  # of the median bar: what is shorter lies at the rim
BARELY = 0.02  # of the bar: shorter, and nothing was pressed
# One nodule of 16 mm, its top 5 mm deep, ten times stiffer; a minute.
SETTINGS = """[palpation]
nodules = [1, 1]
nodule_mm = [16.0, 16.0]
nodule_depth_mm = [5.0, 5.0]
nodule_ratio = [10.0, 10.0]
trial_s = 60.0
dwell_s = 2.0
"""
BAR = 17, HEIGHT - 22, 240, 3  # where the force bar lies in a window of this size
# The pointer's way to the next place; down until the bar is looked at, and at most until it stands still: so many looks in a
# row, within so much of it.
GO_S, PRESS_S, LONGEST_S, STILL, MOVES = 0.12, 0.65, 0.6, 14, 0.006
MARK_S, AWAY_S = 3.0, 2.0
# The organ's upper side on the screen: its middle, and where a millimetre to the right and one towards the person lead; px.
# Places are named by millimetres from the middle; so far from there it is searched.
MIDDLE, RIGHT, NEAR = (560.0, 342.0), (1.70, -0.29), (0.22, 1.20)
REACH_MM = 47.0, 34.0
COARSE_MM, FINE_MM, SAME_MM = 16.0, 8.0, 15.0
READY_S = 90.0
SCREEN = 0, 100, WIDTH, 560


def amber(red, green, blue):
    """The ground of warnings."""
    return red > 215 and 140 < green < 215 and blue < 110


def liver(red, green, blue):
    return red > 90 and red - green > 50 and red - blue > 50


def lit(red, green, blue):
    return max(red, green, blue) - min(red, green, blue) > 70


def around(middle, rings, spacing):
    """Places of a hexagonal grid, row by row; mm."""
    return [(middle[0] + spacing * (column + 0.5 * (row % 2)), middle[1] + spacing * 0.866 * row)
            for row in range(-rings, rings + 1) for column in range(-rings, rings + 1)]


def in_reach(place):
    return sum((a / r) ** 2 for a, r in zip(place, REACH_MM)) <= 1.0


class Person:
    """Points, presses and reads the bar."""

    def __init__(self, play, desktop, window):
        self.play, self.desktop, self.window = play, desktop, window

    def bar(self):
        """Share of the force bar that is lit."""
        try:
            picture = self.desktop.picture(self.window, BAR)
        except error.BadDrawable as gone:
            raise AssertionError(f"the window has gone: {self.play.lines()}") from gone
        return sum(lit(*picture.at(x, 1)) for x in range(picture.width)) / picture.width

    def go(self, place):
        self.desktop.point(*(m + place[0] * r + place[1] * n for m, r, n in zip(MIDDLE, RIGHT, NEAR)))
        time.sleep(GO_S)

    def press(self, place):
        """The bar while the place is pressed."""
        self.go(place)
        self.desktop.button(1, True)
        time.sleep(PRESS_S)
        until, felt = time.monotonic() + LONGEST_S, []
        while len(felt) < STILL or (max(felt[-STILL:]) - min(felt[-STILL:]) > MOVES and time.monotonic() < until):
            felt.append(self.bar())
            time.sleep(0.02)
        self.desktop.button(1, False)
        return min(felt[-STILL:])

    def mark(self, place):
        self.go(place)
        self.desktop.button(1, True)
        time.sleep(MARK_S)
        self.desktop.button(1, False)

    def put_away(self):
        self.desktop.button(3, True)
        time.sleep(AWAY_S)
        self.desktop.button(3, False)


def solved(rows, values):
    """Of a small square system, by elimination with pivots."""
    n = len(values)
    table = [list(row) + [value] for row, value in zip(rows, values)]
    for i in range(n):
        best = max(range(i, n), key=lambda k: abs(table[k][i]))
        table[i], table[best] = table[best], table[i]
        for k in range(i + 1, n):
            factor = table[k][i] / table[i][i]
            table[k] = [a - factor * b for a, b in zip(table[k], table[i])]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (table[i][n] - sum(table[i][k] * x[k] for k in range(i + 1, n))) / table[i][i]
    return x


def beyond_trend(felt):
    """By how much the logarithm of each place's bar stands out of a quadratic trend that the few places
    that stand out do not bend."""
    places = list(felt)
    terms = [(1.0, a, b, a * a, a * b, b * b) for a, b in ((x / REACH_MM[0], y / REACH_MM[1]) for x, y in places)]
    logs = [math.log(felt[p]) for p in places]
    weights = [1.0] * len(places)
    for _ in range(12):
        normal = [[sum(w * t[i] * t[j] for w, t in zip(weights, terms)) + 1e-9 * (i == j) for j in range(6)] for i in range(6)]
        right = [sum(w * t[i] * v for w, t, v in zip(weights, terms, logs)) for i in range(6)]
        c = solved(normal, right)
        off = [v - sum(a * b for a, b in zip(c, t)) for t, v in zip(terms, logs)]
        scale = 1.5 * sorted(map(abs, off))[len(off) // 2] + 1e-3
        weights = [1.0 / (1.0 + (o / scale) ** 2) if o > 0 else 1.0 for o in off]
    return dict(zip(places, off))


def firm(felt):
    """Without places at the rim, which give way to the side."""
    median = sorted(felt.values())[len(felt) // 2]
    return {place: bar for place, bar in felt.items() if bar > RIM * median}


class PalpationByMouse(DeskTest):
    def setUp(self):
        super().setUp()
        cache = os.environ.get("ORGAN_CACHE", self.path("cache"))
        self.environment["XDG_CACHE_HOME"] = cache
        self.make_rig()
        os.mkdir(self.path("desk"))
        self.film("still", "board.toml", "desk", 600)
        self.settings = self.write("one.toml", SETTINGS)

    def keep(self, name):
        if "KEEP_PICTURES" in os.environ:
            self.desktop.picture().write(os.path.join(os.environ["KEEP_PICTURES"], name + ".png"))

    def opens(self, seed):
        self.open_desktop(WIDTH, HEIGHT)
        play = self.start("play", "--app", "palpation", "--camera", "images:desk", "--settings", self.settings, "--seed", seed,
                          "--quality", "low", "--json", f"figures{seed}.json")
        wait_until(lambda: play.ended() or self.desktop.window("Palpate") is not None, "the window opens")
        self.assertFalse(play.ended(), play.lines())
        window = self.desktop.window("Palpate")
        self.desktop.resize(window, WIDTH, HEIGHT)
        # It is looked at until the organ is there and nothing is wrong: on a busy machine forces may have gone off meanwhile.
        until = time.monotonic() + READY_S
        while self.desktop.picture(window).share(SCREEN, amber) > 1e-3 or self.desktop.picture(window).share(SCREEN, liver) < 1e-2:
            self.assertLess(time.monotonic(), until, "the organ is not seen, or a warning stands")
            self.desktop.press("r")
            time.sleep(2.0)
        return play, window

    def search(self, seed):
        """One try; the program's record of it."""
        play, window = self.opens(seed)
        person = Person(play, self.desktop, window)
        self.keep(f"{seed}-begin")
        presses = {}

        def feel(places):
            """Of several presses of a place the middle one counts: a busy window shows one too early, or what disturbed it."""
            for place in list(places):
                if (bar := person.press(place)) > BARELY:
                    presses.setdefault(place, []).append(bar)

        def standing_out():
            return beyond_trend(firm({place: statistics.median_high(bars) for place, bars in presses.items()}))

        def hardest(count):
            out = standing_out()
            return sorted(out, key=out.get, reverse=True)[:count]
        grid = list(filter(in_reach, around((0.0, 0.0), 4, COARSE_MM)))
        feel(grid)
        typical = statistics.median(bars[0] for bars in presses.values())
        feel(place for place in grid if presses.get(place, [0.0])[0] < LOW * typical)
        feel(hardest(3))
        feel(hardest(2))
        self.keep(f"{seed}-felt")
        best = hardest(1)[0]
        feel(place for place in around(best, 1, FINE_MM) if math.dist(place, best) < 1.2 * FINE_MM)
        feel(hardest(2))
        out = standing_out()
        best = max(out, key=out.get)
        # The middle of what is hard.
        hard = {place: value for place, value in out.items() if math.dist(place, best) < SAME_MM and value > 0.5 * out[best]}
        middle = [sum(value * place[k] for place, value in hard.items()) / sum(hard.values()) for k in (0, 1)]
        person.mark(middle)
        if "KEEP_PICTURES" in os.environ:
            told = {"marked_mm": middle, "felt": [[*place, statistics.median_high(bars), out.get(place, 0.0)] for place, bars in presses.items()]}
            with open(os.path.join(os.environ["KEEP_PICTURES"], f"{seed}-felt.json"), "w", encoding="ascii") as file:
                json.dump(told, file)
        self.keep(f"{seed}-marked")
        person.put_away()
        time.sleep(1.0)
        self.keep(f"{seed}-end")
        self.desktop.close_window(window)
        self.assertEqual(play.ends().code, 0, play.lines())
        return json.loads(self.read(f"figures{seed}.json"))["play"]["palpation"]

    def test_a_nodule_is_found_within_a_minute(self):
        found = 0
        for seed in range(FIRST, FIRST + TRIES):
            record = self.search(seed)
            hit = record["over"] and record["found"] == 1
            found += hit
            print(f"seed {seed}: {'found' if hit else 'missed'}", json.dumps(record), flush=True)
        self.assertGreaterEqual(found, WANTED_SHARE * TRIES)


if __name__ == "__main__":
    unittest.main()
