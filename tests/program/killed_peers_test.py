#!/usr/bin/env python3
"""Each of the three processes killed in turn: the others notice, say so in one line, and a restart finds nothing in its way."""
import os
import signal
import time
import unittest

from laboratory import BACK, GONE, READY, LaboratoryTest, told


class KilledPeers(LaboratoryTest):
    def test_without_their_laboratory_both_servers_end_and_all_can_start_again(self):
        world, physics, graphics = self.start_all()
        world.remove()
        for server, name in ((physics, "physics"), (graphics, "graphics")):
            done = server.ends()
            self.assertEqual((done.code, done.out), (1, ""), done)
            lines = told(done)
            self.assertEqual(len(lines), 1, done)
            for words in (f"palpate: {name}: ", "laboratory 'lab' has been silent", f"process {world.process.pid} has died", "palpate world run"):
                self.assertIn(words, lines[0])
        self.assertNotIn("physics.sock", self.left_behind())
        self.says_no(self.run_program("physics", "--rig", self.rig), 1, "laboratory 'lab' has been silent", "palpate world run")
        world, physics, graphics = self.start_all()
        self.assertEqual(self.stop_in_order(graphics, physics, world), [[], [], []])
        self.assertEqual(self.left_behind(), [])

    def test_servers_end_with_the_program_that_started_them_however_it_ended(self):
        """A parent listens at a pipe (palpate/core/child_report.h), and is gone."""
        heard, told_to = os.pipe()
        child = {"pass_fds": (told_to,), "env": {**self.environment, "PALPATE_REPORT_FD": str(told_to)}}
        world = self.start("world", "run", **child)
        self.assertTrue(world.says(READY["world"]), world.lines())
        physics = self.start("physics", "--rig", self.rig, **child)
        self.assertTrue(physics.says(READY["physics"]), physics.lines())
        os.close(told_to)
        self.assertFalse(world.ended() or physics.ended())
        os.close(heard)
        self.assertEqual(world.ends().code, 0)
        self.assertIn(physics.ends().code, (0, 1))  # 1: it saw the laboratory end first

    def test_a_laboratory_that_closes_is_noticed_too(self):
        world, physics, graphics = self.start_all()
        self.assertEqual(self.stop_in_order(world), [[]])
        for server in (physics, graphics):
            done = server.ends()
            self.assertEqual(done.code, 1, done)
            lines = [line for line in told(done) if "forces tripped (arm lost" not in line]  # where a tick saw it first
            self.assertEqual(len(lines), 1, done)
            self.assertIn("has been closed", done.lines[-1])
        self.assertEqual(self.left_behind(), [])

    def test_without_its_physics_server_graphics_goes_on_and_takes_the_next(self):
        world, physics, graphics = self.start_all()
        measured = self.start_graphics("--seconds", "4")
        physics.remove()
        self.assertTrue(graphics.says(GONE), graphics.lines())
        self.assertTrue(world.says("whoever commands the arm is silent"), world.lines())
        done = measured.ends()  # its figures would be those of something else
        self.assertEqual((done.code, done.out), (1, ""), done)
        self.assertIn(GONE, done.lines[-1])
        self.assertIn("start `palpate physics` again", done.lines[-1])
        self.assertIn("physics.sock", self.left_behind())  # which blocks nobody:
        physics = self.start_physics()
        self.assertTrue(graphics.says(BACK), graphics.lines())
        self.assertEqual(self.stop_in_order(graphics, physics), [[], []])
        self.assertTrue(world.says("the arm is commanded again"), world.lines())
        self.assertEqual(len(self.stop_in_order(world)[0]), 2)
        self.assertEqual(self.left_behind(), [])

    def test_graphics_says_that_another_application_has_come_and_draws_on_when_the_first_is_back(self):
        world, physics, graphics = self.start_all()
        measured = self.start_graphics("--seconds", "6")
        physics.remove()
        self.assertTrue(graphics.says(GONE), graphics.lines())
        physics = self.start_physics("--app", "touch")
        words = "the physics server now plays touch, not pingpong; start `palpate graphics` again"
        self.assertTrue(graphics.says(words), graphics.lines())
        done = measured.ends()
        self.assertEqual((done.code, done.out), (1, ""), done)
        self.assertIn(words, done.lines[-1])
        self.stop_in_order(physics)
        physics = self.start_physics()
        self.assertTrue(graphics.says("plays again what is drawn"), graphics.lines())
        self.stop_in_order(graphics, physics, world)

    def test_a_pause_of_the_whole_machine_is_nobodys_death(self):
        servers = world, physics, graphics = self.start_all()
        for number in (signal.SIGSTOP, signal.SIGCONT):
            for server in servers:
                server.send(number)
            time.sleep(1.5)  # longer than the silence that means death; and then long enough to notice one
        self.assertEqual(self.stop_in_order(graphics, physics, world), [[], [], []])

    def test_a_laboratory_that_stands_still_for_two_seconds_ends_neither_server(self):
        servers = world, physics, graphics = self.start_all()
        world.send(signal.SIGSTOP)
        self.assertTrue(physics.says("laboratory 'lab' stands still"), physics.lines())
        time.sleep(1.2)  # two seconds and more in all
        world.send(signal.SIGCONT)
        self.assertTrue(physics.says("laboratory 'lab' goes on"), physics.lines())
        time.sleep(0.5)
        for server in servers:
            self.assertIsNone(server.process.poll(), server.lines())
        for process in (graphics, physics, world):
            process.send(signal.SIGTERM)
            self.assertEqual(process.ends().code, 0)

    def test_without_graphics_the_others_go_on_and_serve_the_next(self):
        world, physics, graphics = self.start_all()
        graphics.remove()
        graphics = self.start_graphics()
        self.assertEqual(self.stop_in_order(graphics, physics, world), [[], [], []])
        self.assertEqual(self.left_behind(), [])


if __name__ == "__main__":
    unittest.main()
