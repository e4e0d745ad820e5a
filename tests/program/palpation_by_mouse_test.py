#!/usr/bin/env python3
"""Somebody at a desk searches the organ with the mouse, and feels with the eyes: the length of the force bar in the window's
pixels is all that is read. Where on the screen the organ lies is known, as the camera stands. What was found is judged
by the program's own record.

TRIES=N: so many (10). KEEP_PICTURES=FOLDER: the screen at each step. ORGAN_CACHE=FOLDER: of prepared organs.
"""
import json
import math
import os
import time
import unittest

from desk import DeskTest
from program import wait_until

WIDTH, HEIGHT = 960, 720
TRIES = int(os.environ.get("TRIES", "10"))
WANTED_SHARE = 0.8
BARELY = 0.02  # of the bar: shorter, and nothing was pressed
# One nodule of 16 mm, its top 5 mm deep, ten times stiffer; a minute.
SETTINGS = """[palpation]
nodules = [1, 1]
nodule_mm = [16.0, 16.0]
nodule_depth_mm = [5.0, 5.0]
nodule_ratio = [10.0, 10.0]
trial_s = 60.0
"""
BAR = 17, HEIGHT - 22, 240, 3  # where the force bar lies in a window of this size
PRESS_S, READ_S, GO_S = 0.62, 0.10, 0.13  # down until it is read; how long it is read; the pointer's way to the next place
MARK_S, AWAY_S = 1.7, 1.8
# The middle of the organ's upper side on the screen, and how far from there it is searched: px. There a millimetre is
# 1.33 px across and about one px away from the person.
MIDDLE, REACH = (575, 470), (70, 39)
ACROSS, AWAY = 1.33, 1.0
COARSE_MM, FINE_MM, NEAR_MM = 14.0, 8.0, 15.0


def around(middle, rings, spacing_mm):
    """Places of a hexagonal grid, row by row."""
    places = []
    for row in range(-rings, rings + 1):
        for column in range(-rings, rings + 1):
            across, away = column + 0.5 * (row % 2), 0.866 * row
            places.append((round(middle[0] + across * spacing_mm * ACROSS), round(middle[1] + away * spacing_mm * AWAY)))
    return places


def inside(place):
    return sum(((a - m) / r) ** 2 for a, m, r in zip(place, MIDDLE, REACH)) <= 1.0


def apart_mm(a, b):
    return math.hypot((a[0] - b[0]) / ACROSS, (a[1] - b[1]) / AWAY)


def lit(red, green, blue):
    return max(red, green, blue) - min(red, green, blue) > 70


class Person:
    """Points, presses and reads the bar."""

    def __init__(self, desktop, window):
        self.desktop, self.window = desktop, window

    def bar(self):
        """Share of the force bar that is lit."""
        picture = self.desktop.picture(self.window, BAR)
        return sum(lit(*picture.at(x, 1)) for x in range(picture.width)) / picture.width

    def go(self, place):
        self.desktop.point(*place)
        time.sleep(GO_S)

    def press(self, place):
        """The bar while the place is pressed."""
        self.go(place)
        self.desktop.button(1, True)
        time.sleep(PRESS_S)
        until, felt = time.monotonic() + READ_S, []
        while time.monotonic() < until or not felt:
            felt.append(self.bar())
        self.desktop.button(1, False)
        return sorted(felt)[len(felt) // 2]

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
    """By how much the logarithm of each place's bar stands out of a quadratic trend over the picture that few places
    that stand out do not bend."""
    places = list(felt)
    u = [((x - WIDTH / 2) / 100, (y - HEIGHT / 2) / 100) for x, y in places]
    terms = [(1.0, a, b, a * a, a * b, b * b) for a, b in u]
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


class PalpationByMouse(DeskTest):
    def setUp(self):
        super().setUp()
        cache = os.environ.get("ORGAN_CACHE", self.path("cache"))
        self.environment["XDG_CACHE_HOME"] = cache
        self.make_rig()
        self.film("still", "board.toml", "desk.mp4", 40)
        self.settings = self.write("one.toml", SETTINGS)

    def keep(self, name):
        if "KEEP_PICTURES" in os.environ:
            self.desktop.picture().write(os.path.join(os.environ["KEEP_PICTURES"], name + ".png"))

    def opens(self, seed):
        self.open_desktop(WIDTH, HEIGHT)
        play = self.start("play", "--app", "palpation", "--camera", "video:desk.mp4", "--settings", self.settings, "--seed", seed,
                          "--json", f"figures{seed}.json")
        wait_until(lambda: play.ended() or self.desktop.window("Palpate") is not None, "the window opens")
        self.assertFalse(play.ended(), play.lines())
        window = self.desktop.window("Palpate")
        self.desktop.resize(window, WIDTH, HEIGHT)
        time.sleep(2.0)  # to look at it
        return play, window

    def search(self, seed):
        """One try; the program's record of it."""
        play, window = self.opens(seed)
        person = Person(self.desktop, window)
        self.keep(f"{seed}-begin")
        felt = {}
        for place in filter(inside, around(MIDDLE, 4, COARSE_MM)):
            if (bar := person.press(place)) > BARELY:
                felt[place] = bar
        self.keep(f"{seed}-felt")
        out = beyond_trend(felt)
        best = max(out, key=out.get)
        for place in around(best, 1, FINE_MM):
            if (bar := person.press(place)) > BARELY:
                felt[place] = bar
        out = beyond_trend(felt)
        best = max(out, key=out.get)
        # The middle of what is hard.
        hard = {place: value for place, value in out.items() if apart_mm(place, best) < NEAR_MM and value > 0.5 * out[best]}
        person.mark([sum(value * place[k] for place, value in hard.items()) / sum(hard.values()) for k in (0, 1)])
        self.keep(f"{seed}-marked")
        person.put_away()
        time.sleep(1.0)
        self.keep(f"{seed}-end")
        self.desktop.close_window(window)
        self.assertEqual(play.ends().code, 0, play.lines())
        self.desktop.close()
        return json.loads(self.read(f"figures{seed}.json"))["play"]["palpation"]

    def test_a_nodule_is_found_within_a_minute(self):
        found = 0
        for seed in range(1, TRIES + 1):
            record = self.search(seed)
            hit = record["over"] and record["found"] == 1 and record["false_alarms"] == 0
            found += hit
            print(f"seed {seed}: {'found' if hit else 'missed'}", json.dumps(record), flush=True)
        self.assertGreaterEqual(found, WANTED_SHARE * TRIES)


if __name__ == "__main__":
    unittest.main()
