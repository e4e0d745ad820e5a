#!/usr/bin/env python3
"""The client of a running session, with the simulated laboratory and a physics server beside it."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
import types

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "program"))

from laboratory import READY, LaboratoryTest  # noqa: E402
from program import PATIENCE_S, free_port, unittest, wait_until  # noqa: E402

import palpate  # noqa: E402


def threads():
    return len(os.listdir("/proc/self/task"))


class LiveTest(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.address = f"ipc://{self.meeting}/palpate/physics.sock"

    def client(self, **named):
        client = palpate.Client(self.address, **{"patience": PATIENCE_S, **named})
        self.addCleanup(client.close)
        return client

    def leaves(self, before):
        """As many threads; one that has been joined is listed for a moment more."""
        wait_until(lambda: threads() == before, f"there are {before} threads again, not {threads()}")

    def begin(self, *options):
        return self.start_world(), self.start_physics(*options)

    def refuses(self, words, call, *arguments, code=None, kind=palpate.Refused, **named):
        with self.assertRaises(kind) as caught:
            call(*arguments, **named)
        for word in words:
            self.assertIn(word, str(caught.exception))
        if code is not None:
            self.assertEqual(caught.exception.code, code)


    def new_key(self, folder):
        """The public one; not like an option of a command."""
        while True:
            self.runs("keys", "new", "--force", "--keys", folder)
            if not (key := json.loads(self.runs("keys", "show", "--json", "-", "--keys", folder).out)["public_key"]).startswith("-"):
                return key


class Told:
    """Blocks of these ticks, in place of a server's."""

    def __init__(self, *blocks):
        self.blocks = list(blocks)

    def begin_steps(self):
        return None

    def end_steps(self, steps):
        pass

    def closed(self):
        return not self.blocks

    def next_block(self, _steps, _every, _patience):
        if not self.blocks:
            return None
        ticks, restarted = self.blocks.pop(0)
        return {"tick": np.array(ticks, dtype=np.uint64), "time_ns": np.array(ticks, dtype=np.int64)}, restarted


class Gaps(unittest.TestCase):
    def test_what_is_missed_is_counted_where_it_is(self):
        core = Told(([7, 8, 9], False), ([10, 12, 13, 20], False), ([24], False), ([3, 4, 6], True), ([7], False))
        states = palpate.States(types.SimpleNamespace(_patience=1.0), core, 0.1)
        blocks = list(states)
        self.assertEqual([block.missed for block in blocks], [0, 1 + 6, 3, 1, 0])
        self.assertEqual([block.restarted for block in blocks], [False, False, False, True, False])
        self.assertEqual(states.missed, 11)


class Live(LiveTest):
    def test_what_plays_and_how_the_world_is(self):
        self.begin()
        with self.client() as client:
            self.assertEqual((client.application, client.role, client.alive), ("pingpong", "operator", True))
            self.assertIn("Ball", [body.name for body in client.bodies])
            self.assertEqual([surface.name for surface in client.surfaces], ["table", "wall"])
            self.assertEqual(client.surfaces[0].corners.shape, (4, 3))
            self.assertEqual((client.gravity.shape, client.carried_offset.shape), ((3,), (3,)))
            self.assertIn("pingpong", repr(client))
            json.loads(client.settings)

            newest = client.state()
            self.assertEqual((newest.kind, newest.extrapolated_by), ("exact", 0.0))
            bodies = len(newest.positions)
            self.assertGreaterEqual(bodies, 2)
            self.assertEqual([newest.velocities.shape, newest.orientations("wxyz").shape, newest.force.shape, newest.counters.shape],
                             [(bodies, 3), (bodies, 4), (3,), (16,)])
            np.testing.assert_allclose(np.linalg.norm(newest.orientations("wxyz"), axis=1), 1.0, atol=1e-9)
            np.testing.assert_array_equal(np.roll(newest.orientations("xyzw"), 1, axis=1), newest.orientations("wxyz"))
            with self.assertRaises(ValueError):
                newest.positions[0] = 0

            # Of a step's own time it is that step; of one between, it is between.
            again = client.state(at=newest.time_ns / 1e9)
            self.assertEqual((again.kind, again.tick), ("exact", newest.tick))
            np.testing.assert_array_equal(again.positions, newest.positions)
            between = client.state(at=newest.time - 0.0005)
            self.assertEqual(between.kind, "interpolated")
            self.assertLess(between.tick, newest.tick)
            self.assertEqual(client.state(at=newest.time + 3600).kind, "too_new")
            self.assertEqual(client.state(at=newest.time - 3600).kind, "too_old")
            self.refuses(["nanoseconds?"], client.state, at=float(newest.time_ns) * 1e9, kind=ValueError)

    def test_every_step_of_the_world_equals_what_the_server_records(self):
        recording = self.path("physics.mcap")
        world, physics = self.begin("--record", recording)
        blocks, answers = [], []
        with self.client() as client:
            states = client.states(every=0.25)
            for block in states:
                blocks.append(block)
                if len(blocks) == 2:
                    client.control("begin")
                # What the server's own history says of each gap: between its two sides there is no step.
                for i in np.flatnonzero(np.diff(block.tick) > 1):
                    answers.append((int(block.tick[i]), client.state(at=(int(block.time_ns[i + 1]) - 1000) / 1e9)))
                if sum(map(len, blocks)) > 4000:
                    break
            missed = states.missed
        self.stop_in_order(physics, world)
        ticks, times = (np.concatenate([getattr(block, name) for block in blocks]) for name in ("tick", "time_ns"))
        self.assertEqual(sum(block.missed for block in blocks), missed)
        self.assertEqual(int(ticks[-1] - ticks[0]) + 1 - len(ticks), missed)
        self.assertTrue((np.diff(ticks) > 0).all() and (np.diff(times) > 0).all())
        self.assertFalse(any(block.restarted for block in blocks))
        for tick, answer in answers:
            self.assertEqual((answer.tick, answer.kind), (tick, "interpolated"))

        written = palpate.Recording(recording)["/physics/state"]
        rows = np.searchsorted(written["tick"], ticks)
        np.testing.assert_array_equal(written["tick"][rows], ticks)
        np.testing.assert_array_equal(written["time_ns"][rows], times)
        for body in range(blocks[0].positions.shape[1]):
            for ours, name in (("positions", "position_m"), ("velocities", "velocity_m_per_s")):
                np.testing.assert_array_equal(np.concatenate([getattr(block, ours)[:, body] for block in blocks]),
                                              written[f"bodies.{body}.{name}"][rows])
            np.testing.assert_array_equal(np.concatenate([block.orientations("wxyz")[:, body] for block in blocks]),
                                          written[f"bodies.{body}.orientation_wxyz"][rows])
        np.testing.assert_array_equal(np.concatenate([block.continuous_force for block in blocks]), written["continuous_force_n"][rows])

    def test_a_loop_that_is_slow_misses_nothing(self):
        self.begin()
        with self.client() as client:
            states = client.states(every=0.1)
            first = next(states)
            time.sleep(3.0)
            rows = [next(states) for _ in range(25)]
            self.assertGreater(rows[-1].time[-1] - first.time[0], 2.0)
            gaps = int(rows[-1].tick[-1] - first.tick[0]) + 1 - len(first) - sum(map(len, rows))
            self.assertEqual(gaps, states.missed)
            # A server that records how its loop stood has a few; a reader that lost what came meanwhile, thousands.
            self.assertLess(gaps, 1000)

    def test_states_at_a_rate(self):
        self.begin()
        with self.client() as client:
            watch = client.watch(50)
            states = [next(watch) for _ in range(20)]
            times = [state.time for state in states]
            self.assertEqual(times, sorted(set(times)))
            self.assertTrue(all(state.kind in ("exact", "interpolated") for state in states))
            self.assertGreaterEqual(watch.skipped + watch.missed, 0)
            for rate in (0, 1001, 2.5, True):
                self.refuses(["rate", "1 to 1000"], client.watch, rate, kind=ValueError)

    def test_the_clock_of_the_same_machine_is_ours(self):
        self.begin()
        with self.client() as client:
            clock = client.clock()
            wait_until(lambda: client.clock().settled, "the clocks are known")
            clock = client.clock()
            self.assertLessEqual(abs(clock.offset), clock.uncertainty)
            self.assertGreater(clock.round_trip, 0)
            self.assertAlmostEqual(clock.local_time(clock.server_time(clock.local + 5)), clock.local + 5, 9)
            before = clock.server_time(time.monotonic())
            self.assertGreater(client.state(at=before - 0.1).time, before - 0.2)

    def test_wishes_by_role(self):
        self.begin()
        with self.client() as operator, self.client(role="graphics") as graphics, self.client(role="observer") as observer:
            self.assertEqual([operator.role, graphics.role, observer.role], ["operator", "graphics", "observer"])
            for wish in ("begin", "pause", "resume", "reset"):
                operator.control(wish)
            graphics.control("begin")
            for client, wish, needed in ((graphics, "pause", "operator"), (observer, "begin", "graphics"),
                                         (observer, "reset", "operator")):
                self.refuses([repr(wish), f"the role {client.role}", f"make it with role='{needed}'"], client.control, wish)
            self.refuses(["wish is 'serve'", "begin, reset, pause, resume"], observer.control, "serve", kind=ValueError)
            told = json.loads(self.runs("status", "--json", "-").out)
            self.assertEqual(told["service"]["controls"], 5)
            self.assertEqual([client["name"] for client in told["clients"] if client["name"] == "python"], ["python"] * 3)

    def test_over_tcp_the_key_says_what_a_client_may(self):
        self.start_world()
        place = f"tcp://127.0.0.1:{free_port()}"
        server, client, stranger = (self.path(name) for name in ("server", "client", "stranger"))
        public = {folder: self.new_key(folder) for folder in (server, client, stranger)}
        self.runs("keys", "authorize", public[client], "--role", "observer", "--name", "watcher", "--keys", server)
        physics = self.start("physics", "--rig", self.rig, "--listen", place, "--keys", server)
        self.assertTrue(physics.says(READY["physics"]), physics.lines())
        named = {"keys": client, "server_key": public[server], "patience": PATIENCE_S}
        with palpate.Client(place, **named) as watcher:
            self.assertEqual(watcher.role, "observer")
            self.assertGreater(len(next(watcher.states())), 0)
            self.refuses(["'pause'", "the role observer", "palpate keys authorize KEY --role operator"], watcher.control, "pause")
        self.refuses(["observer, not as operator", "palpate keys authorize"], palpate.Client, place, role="operator", **named)
        self.refuses(["does not admit the key", "palpate keys"], palpate.Client, place, keys=stranger, server_key=public[server], patience=3.0)
        self.refuses(["palpate keys trust"], palpate.Client, place, keys=client)

    def test_nobody_there_and_no_address(self):
        place = f"ipc://{self.meeting}/nobody.sock"
        before = threads()
        self.refuses([f"no physics server answers at {place} after 0.5 s", "start `palpate physics` first"], palpate.Client, place,
                     patience=0.5, code="timed_out")
        self.leaves(before)
        self.refuses(["nowhere", "ipc://"], palpate.Client, "nowhere", kind=ValueError)
        self.refuses(["role is 'king'", "observer, graphics, operator"], palpate.Client, place, role="king", kind=ValueError)
        self.refuses(["patience is 0"], palpate.Client, place, patience=0, kind=ValueError)

    def test_a_server_that_goes_and_returns(self):
        _, physics = self.begin()
        with self.client() as client:
            states, watch = client.states(every=0.1), client.watch(100)
            last, session = next(states), client.session
            next(watch)
            physics.send(signal.SIGKILL)
            physics.ends()
            wait_until(lambda: not client.alive, "its end is noticed")
            self.start_physics()
            wait_until(lambda: client.alive and client.session != session, "it is back")
            block = next(states)
            while not block.restarted:
                block, last = next(states), block
            self.assertEqual(block.missed, int(block.tick[-1] - block.tick[0]) + 1 - len(block))
            self.assertGreater(block.time[0], last.time[-1])
            self.assertFalse(next(states).restarted)
            self.assertGreater(next(watch).time, last.time[-1])
            client.control("begin")

    def test_a_server_that_stays_away_ends_the_wait_in_words(self):
        _, physics = self.begin()
        with self.client(patience=1.0) as client:
            states, watch = client.states(), client.watch(100)
            next(states), next(watch)
            physics.send(signal.SIGKILL)
            physics.ends()
            words = ["no physics server answers", "palpate physics"]
            for call in (client.state, lambda: [*states], lambda: [*watch]):
                self.refuses(words, call, code="timed_out")
            self.refuses(["'pause'", "has not taken it within 2 s"], client.control, "pause", code="timed_out")

    def test_closed_by_another_thread_again_and_again(self):
        self.begin()
        before = threads()
        client = self.client()
        states, watch = client.states(), client.watch(100)
        next(states), next(watch)
        seen, failed = [], []

        def loop(what):
            try:
                seen.append(sum(1 for _ in what))
            except BaseException as error:  # pylint: disable=broad-except
                failed.append(error)
        loops = [threading.Thread(target=loop, args=(what,)) for what in (states, watch)]
        for one in loops:
            one.start()
        time.sleep(0.3)
        closers = [threading.Thread(target=client.close) for _ in range(3)]
        for one in closers:
            one.start()
        for one in loops + closers:
            one.join(PATIENCE_S)
            self.assertFalse(one.is_alive())
        self.assertEqual((len(seen), failed), (2, []))
        client.close()
        self.assertTrue(client.closed)
        self.leaves(before)
        for call in (client.state, client.states, lambda: client.watch(10), lambda: client.control("pause"), client.clock,
                     lambda: client.application, lambda: client.bodies):
            self.refuses(["this client is closed", "palpate.Client(...)"], call, kind=ValueError)
        self.assertIn("closed", repr(client))
        self.assertRaises(StopIteration, next, states)

    def test_other_threads_run_while_one_waits(self):
        self.begin()
        with self.client() as client:
            interval = sys.getswitchinterval()
            sys.setswitchinterval(5.0)  # until then nobody is made to give the lock away
            self.addCleanup(sys.setswitchinterval, interval)
            counted, done = [0], threading.Event()

            def count():
                while not done.is_set():
                    counted[0] += 1
                    time.sleep(0)
            thread = threading.Thread(target=count, daemon=True)
            states = client.states(every=0.2)
            thread.start()
            before = counted[0]
            next(states)
            during = counted[0] - before
            done.set()
            thread.join()
            self.assertGreater(during, 100)

    def test_ctrl_c_ends_a_wait(self):
        self.begin()
        script = ("import palpate, sys\nwith palpate.Client(sys.argv[1]) as client:\n print('watches', flush=True)\n"
                  " for block in client.states(every=3600): pass\n")
        running = subprocess.Popen([sys.executable, "-c", script, self.address], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(running.kill)
        self.assertEqual(running.stdout.readline(), "watches\n")
        running.send_signal(signal.SIGINT)
        _, said = running.communicate(timeout=PATIENCE_S)
        self.assertIn("KeyboardInterrupt", said)
        self.assertEqual(running.returncode, -signal.SIGINT)

    def test_a_program_that_forgets_to_close_ends(self):
        self.begin()
        script = "import palpate, sys\nclient = palpate.Client(sys.argv[1])\nstates = client.states()\nprint(len(next(states)) > 0)\n"
        done = subprocess.run([sys.executable, "-c", script, self.address], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "True\n", ""))

    def test_beside_pythons_own_protobuf(self):
        """In one process: the messages as Python has compiled them, before or after; and every extension module of the package."""
        self.begin()
        self.wire_messages()
        modules = sorted(path.name.split(".")[0] for path in pathlib.Path(palpate.__file__).parent.glob("_*.so"))
        self.assertIn("_live", modules)
        ours = ("import importlib, palpate\n" + "".join(f"importlib.import_module('palpate.{name}')\n" for name in modules)
                + f"with palpate.Client({self.address!r}) as client: assert client.state().tick > 0\n")
        theirs = ("import palpate_pb2\nhello = palpate_pb2.ToPhysics(protocol=2, hello=palpate_pb2.Hello(client=7, name='x'))\n"
                  "assert palpate_pb2.ToPhysics.FromString(hello.SerializeToString()).hello.client == 7\n")
        for script in (ours + theirs, theirs + ours, theirs + ours + theirs):
            done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PATIENCE_S, check=False,
                                  env={**os.environ, "PYTHONPATH": f"{os.environ['PYTHONPATH']}:{self.root}"})
            self.assertEqual((done.returncode, done.stderr), (0, ""), script)


if __name__ == "__main__":
    unittest.main()
