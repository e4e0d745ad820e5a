#!/usr/bin/env python3
"""A physics server that has no descriptor left, or a few: what observers do then, and a key taken out, does not end it."""
import contextlib
import os
import resource
import unittest

import zmq

from guarded import GuardedServerTest
from program import wait_until

SOON_S = 2.0  # until observers are served again once there are descriptors; a new connection takes a tenth of it


class Descriptors(GuardedServerTest):
    def does_not_notice(self, physics, harm):
        """For each number of descriptors around those in use: harm(observer of a guest) and what it did to the others."""
        asking, staying = self.peer(self.chief, self.port), self.comes_in(self.screen)
        self.loops(asking)  # who has said nothing for long loses the connection, and another may find no descriptor
        process = physics.process.pid
        before = resource.prlimit(process, resource.RLIMIT_NOFILE)
        for more in range(-3, 4):
            few = f"with {more:+d} descriptors beside those in use"
            self.admit("observer", self.guest, "guest")
            guest = self.comes_in(self.guest)
            used = len(os.listdir(f"/proc/{process}/fd"))
            resource.prlimit(process, resource.RLIMIT_NOFILE, (used + more, before[1]))
            harm(guest)
            self.assertFalse(physics.ended(), f"{few}: {physics.lines()}")
            ticks, condition = self.loops(asking)
            wait_until(lambda: all(b > a + 100 for a, b in zip(ticks, self.loops(asking)[0])), f"the loops go on {few}")
            self.assertIn(condition.split(":")[0], ("ready", "running", "degraded"), few)
            self.assertTrue(self.serves(staying, SOON_S), few)
            resource.prlimit(process, resource.RLIMIT_NOFILE, before)
            coming = self.observer(self.screen)
            self.assertTrue(self.serves(coming, SOON_S), f"a new observer is served after a limit {few}")
            guest.socket.close()
            coming.socket.close()

    def test_a_server_that_has_too_few_says_so_and_ends(self):
        refused = 0
        for few in range(6, 60):
            done = self.run_program("physics", "--rig", self.rig, "--arm", "openhaptics", "--seconds", "0.01",
                                    before=lambda few=few: resource.setrlimit(resource.RLIMIT_NOFILE, (few, few)))
            if done.code:
                self.says_no(done, 1, "raise the limit")
            refused += done.code == 1
        self.assertEqual(done.code, 0, done)
        self.assertGreater(refused, 0)

    def test_a_key_that_is_taken_out_loses_its_states_and_nobody_else_does(self):
        physics = self.start_server()

        def revoke(guest):
            self.runs("keys", "revoke", "guest", "--keys", self.keys)
            wait_until(lambda: not self.serves(guest, 0.5), "the guest gets no more states")
        self.does_not_notice(physics, revoke)
        self.stop_in_order(physics)

    def test_an_observer_that_floods_the_server_does_not_end_it(self):
        physics = self.start_server()

        def flood(guest):
            for i in range(3000):
                try:
                    guest.socket.send(b"x" * (i % 400), zmq.DONTWAIT)
                    guest.say(subscribe=self.wire.Subscribe(rate_hz=i % 1100))
                except zmq.Again:
                    guest.hears(0.01)
            with contextlib.suppress(zmq.Again):  # a flood has cost it its connection
                guest.socket.send(b"x" * 60000)
            topics = zmq.Context.instance().socket(zmq.SUB)  # as observers of earlier releases did
            topics.linger, topics.curve_serverkey = 0, self.server_key
            topics.curve_publickey, topics.curve_secretkey = self.guest
            for i in range(100):
                topics.subscribe(b"%d" % i + b"x" * 2000)
            topics.connect(f"tcp://127.0.0.1:{self.port + 1}")
            topics.poll(300)
            topics.close()
        self.does_not_notice(physics, flood)
        self.stop_in_order(physics)


if __name__ == "__main__":
    unittest.main()
