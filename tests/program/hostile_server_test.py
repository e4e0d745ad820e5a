#!/usr/bin/env python3
"""A physics server that means ill, against the graphics server that believes it. It goes on with the next honest word, in the memory and
the lines that it had, and ends when it is told to."""
import unittest

from believing import MOST_GROWTH_MIB, BelievingTest
from fake_server import ON_A_LINK
from program import resident_mib


class HostileServer(BelievingTest):
    def test_a_graphics_server_goes_on_whatever_its_physics_server_says(self):
        self.start_world()
        graphics, server = self.begins("--picture-time", "predicted")
        before = resident_mib(graphics.process.pid)
        for name, attack in ON_A_LINK.items():
            server.attack = attack
            self.goes_on(graphics, server)
            self.assertLess(resident_mib(graphics.process.pid), before + MOST_GROWTH_MIB, name)
            self.recovers(graphics, server, name)
        self.ends_at_once(graphics)


if __name__ == "__main__":
    unittest.main()
