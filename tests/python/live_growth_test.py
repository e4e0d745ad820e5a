#!/usr/bin/env python3
"""Hundreds of connections, one after the other, and minutes of states leave no memory, thread or descriptor behind."""
import os
import unittest

import palpate
from growth_test import resident_kib
from live_test import PATIENCE_S, LiveTest, threads

WARM_UP, CONNECTIONS, BLOCKS = 30, 300, 300
MOST_KIB = 4096


def descriptors():
    return len(os.listdir("/proc/self/fd"))


class LiveGrowth(LiveTest):
    def settled(self, call, warm_up, count):
        for _ in range(warm_up):
            call()
        before = resident_kib()
        for _ in range(count):
            call()
        self.assertLess(resident_kib() - before, MOST_KIB)

    def test_of_many_connections(self):
        self.begin()
        before, open_before = threads(), descriptors()

        def connect():
            with palpate.Client(self.address, patience=PATIENCE_S) as client:
                client.state()
                next(client.states(every=0.001))
                next(client.watch(1000))
        self.settled(connect, WARM_UP, CONNECTIONS)
        self.leaves(before)
        self.assertEqual(descriptors(), open_before)

    def test_of_many_blocks(self):
        self.begin()
        with self.client() as client:
            states = client.states(every=0.05)
            self.settled(lambda: next(states), BLOCKS, BLOCKS)

    def test_of_a_block_that_nobody_takes(self):
        """What a reader leaves is bounded: beyond 16 s of states the server's history has to do."""
        self.begin()
        with self.client() as client:
            states = client.states(every=3600.0)
            self.assertLessEqual(len(next(states)), 16_384 + 64)


if __name__ == "__main__":
    unittest.main()
