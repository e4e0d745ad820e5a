#!/usr/bin/env python3
"""Hundreds of connections to the physics server, of strangers, of one key, of one process: whoever else has something to say gets in."""
import json
import os
import resource
import sys
import time
import unittest

from guarded import GuardedServerTest
from program import wait_until

SOON_S = 3.0  # an operator is in after a tenth of a second; before, not after any time
LIMIT = 256   # descriptors of the server
MANY = 300


class Crowds(GuardedServerTest):
    def start_small_server(self):
        physics = self.start_server()
        resource.prlimit(physics.process.pid, resource.RLIMIT_NOFILE, (LIMIT, LIMIT))
        return physics

    def comes_in_ten_times(self, physics, what):
        slowest, most = 0.0, 0
        for _ in range(10):
            begun = time.monotonic()
            operator = self.peer(self.chief, self.port)
            self.number += 1
            answered = None
            while answered is None:
                self.assertLess(time.monotonic() - begun, SOON_S, f"an operator comes in beside {what}")
                operator.say(status_request=self.wire.StatusRequest(number=self.number))
                answered = operator.hears(0.2)
            slowest = max(slowest, time.monotonic() - begun)
            most = max(most, len(os.listdir(f"/proc/{physics.process.pid}/fd")))
            operator.socket.close()
        print(f"{what}: an operator is in after {slowest:.2f} s at the latest, {most} descriptors", file=sys.stderr)
        self.assertLess(most, LIMIT)

    def test_an_operator_comes_in_whoever_holds_connections(self):
        physics = self.start_small_server()
        self.admit("observer", self.guest, "guest")
        self.comes_in(self.guest).socket.close()
        service, states = (f"tcp://127.0.0.1:{port}" for port in (self.port, self.port + 1))
        crowds = []
        for what, address, keys in (("strangers", service, []), ("strangers", states, []),
                                    ("silent", service, self.with_keys(self.guest)), ("talking", service, self.with_keys(self.guest))):
            leave = self.crowd(what, MANY, address, *keys)
            self.comes_in_ten_times(physics, f"{what} at {address}")
            crowds.append(leave) if what == "talking" else leave()
        # A key that is taken out has nothing any more, however many connections it has.
        self.runs("keys", "revoke", "guest", "--keys", self.keys)
        wait_until(lambda: not self.loops_clients(), "the guest's clients have gone")
        self.comes_in_ten_times(physics, "a crowd whose key was taken out")
        crowds[0]()
        self.assertFalse(physics.ended(), physics.lines())
        self.stop_in_order(physics)

    def loops_clients(self):
        """Names of the clients that the server counts."""
        operator = self.peer(self.chief, self.port)
        clients = self.status(operator).clients
        operator.socket.close()
        return [client.name for client in clients]

    def test_over_the_private_socket_one_process_has_its_share_and_others_get_in(self):
        physics = self.start_physics("--arm", "openhaptics")
        place = "ipc://" + os.path.join(self.meeting, "palpate", "physics.sock")
        self.crowd("talking", 200, place)

        def clients():
            return [client["name"] for client in json.loads(self.runs("status", "--json", "-").out)["clients"]]
        wait_until(lambda: clients().count("crowd") >= 30, "the crowd has its share")
        for _ in range(5):
            self.assertLessEqual(clients().count("crowd"), 32)
        self.stop_in_order(physics)


if __name__ == "__main__":
    unittest.main()
