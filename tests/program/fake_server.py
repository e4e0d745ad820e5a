"""A physics server of the tests' own: honest until it is told what to say instead, for the tests of those who believe servers."""
import contextlib
import math
import os
import random
import socket
import struct
import threading
import time

import zmq

from laboratory import LaboratoryTest
from program import wait_until

LARGEST_SHAPE = 40000  # vertices


def frame(flags, body):
    """As ZMTP has it: one or eight bytes of length."""
    return bytes((flags, len(body))) + body if len(body) < 256 else bytes((flags | 2,)) + struct.pack("!Q", len(body)) + body


def insist(listen):
    """Whoever listened there before may not have closed yet."""
    made = []

    def tries():
        with contextlib.suppress(OSError, zmq.ZMQError):
            made.append(listen())
        return made
    wait_until(tries, "the address is free")
    return made[0]


class FakeServer:
    """Answers at a unix socket, in a thread. `attack`: called with (self, what was said, the message) for all that comes and, with None, some hundred
    times a second; what it returns is sent, a list of messages that are bytes, protobuf or lists of frames; None: the honest answer."""

    def __init__(self, wire, path, scene, state):
        self.wire, self.path, self.scene, self.state = wire, path, scene, state
        self.attack, self.random = None, random.Random(1)
        self.session, self.role, self.frames, self.late, self.heard = 7, wire.ROLE_OPERATOR, 0, 0, {}
        self.trouble, self.over, self.thread, self.peer = None, None, None, None

    def reply(self, **body):
        return self.wire.ToGraphics(protocol=2, **body)

    def welcome(self, scene=None, session=None, states=""):
        return self.reply(welcome=self.wire.Welcome(session=session or self.session, role=self.role, scene=scene or self.scene, states=states))

    def state_reply(self, number, asked_ns, state=None, **more):
        return self.reply(state_reply=self.wire.StateReply(number=number, asked_time_ns=asked_ns, kind=self.wire.ANSWER_EXACT,
                                                           state=state or self.state_at(asked_ns), **more))

    def state_at(self, time_ns):
        state = self.wire.WorldState()
        state.CopyFrom(self.state)
        state.time_ns = time_ns
        return state

    def honest(self, said, message):
        if said == "hello":
            return [self.welcome()]
        if said == "state_request":
            return [self.state_reply(message.state_request.number, message.state_request.time_ns)]
        if said == "sync_request":
            now = time.monotonic_ns()
            return [self.reply(sync_reply=self.wire.SyncReply(number=message.sync_request.number, received_ns=now, sent_ns=now))]
        if said == "control_call":
            return [self.reply(control_reply=self.wire.ControlReply(number=message.control_call.number))]
        if said == "status_request":
            return [self.reply(status_reply=self.wire.StatusReply(number=message.status_request.number, uptime_s=time.monotonic(), application="touch",
                                                                  controls=self.heard.get("control_call", 0)))]
        return []

    def start(self, address=None):
        # Made here, so that whoever connects at once finds it.
        router = zmq.Context.instance().socket(zmq.ROUTER)
        router.linger, router.sndhwm = 0, 256
        insist(lambda: router.bind(address or f"ipc://{self.path}"))
        self.over, self.peer = threading.Event(), None
        self.thread = threading.Thread(target=self._serve, args=(router,), daemon=True)
        self.thread.start()
        return self

    def stop(self):
        if self.thread:
            self.over.set()
            self.thread.join()
            self.thread = None

    def _serve(self, router):
        try:
            while not self.over.is_set():
                said, message = None, None
                if router.poll(2):
                    self.peer, body = router.recv_multipart()[:2]
                    message = self.wire.ToPhysics.FromString(body)
                    said = message.WhichOneof("body")
                    self._note(said, message)
                if self.peer is None:
                    continue
                attack = self.attack  # may change meanwhile
                answers = attack(self, said, message) if attack else None
                if answers is None:
                    answers = self.honest(said, message)
                for one in answers:
                    self._send(router, one)
        except Exception as trouble:  # the test says so
            self.trouble = trouble
        finally:
            router.close()
            if os.path.exists(self.path):
                os.unlink(self.path)

    def _send(self, router, one):
        frames = one if isinstance(one, list) else [one]
        frames = [part if isinstance(part, bytes) else part.SerializeToString() for part in frames]
        try:
            router.send_multipart([self.peer, *frames], zmq.DONTWAIT)
        except zmq.ZMQError:  # gone, or full
            pass

    def _note(self, said, message):
        self.heard[said] = self.heard.get(said, 0) + 1
        if said == "hello" and message.hello.HasField("figures"):
            self.frames, self.late = message.hello.figures.frames, message.hello.figures.late


class RawServer:
    """One that greets as a ROUTER does and then hands the bare connection to `attack`, connection after connection."""

    def __init__(self, port, attack):
        self.attack, self.over, self.connections = attack, threading.Event(), 0
        self.listener = insist(lambda: socket.create_server(("127.0.0.1", port)))
        self.listener.settimeout(0.05)
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def stop(self):
        self.over.set()
        self.thread.join()
        self.listener.close()

    def _serve(self):
        while not self.over.is_set():
            try:
                connection = self.listener.accept()[0]
            except TimeoutError:
                continue
            with connection:
                connection.settimeout(1.0)
                try:
                    self.greet(connection)
                    self.connections += 1
                    self.attack(self, connection)
                except OSError:  # it has had enough
                    pass

    def greet(self, connection):
        connection.sendall(b"\xff" + bytes(8) + b"\x7f\x03\x01" + b"NULL".ljust(20, b"\0") + bytes(32))
        greeting = b""
        while len(greeting) < 64:
            if not (part := connection.recv(64 - len(greeting))):
                raise OSError("gone")
            greeting += part
        ready = b"\x05READY\x0bSocket-Type" + struct.pack("!I", 6) + b"ROUTER"
        connection.sendall(frame(4, ready))
        connection.recv(4096)


class FakeServerTest(LaboratoryTest):
    """Knows what a true server says of its scene, and says that."""

    def setUp(self):
        super().setUp()
        self.wire = self.wire_messages()

    def learn(self, *options):
        """Scene and a state of a true physics server."""
        physics = self.start_physics(*options)
        asking = zmq.Context.instance().socket(zmq.DEALER)
        asking.linger, asking.rcvtimeo = 0, 10000
        asking.connect("ipc://" + os.path.join(self.meeting, "palpate", "physics.sock"))

        def ask(**body):
            asking.send(self.wire.ToPhysics(protocol=2, **body).SerializeToString())
            return self.wire.ToGraphics.FromString(asking.recv())
        scene = ask(hello=self.wire.Hello(client=1, name="learns")).welcome.scene
        state = None
        while state is None or not state.bodies:
            state = ask(state_request=self.wire.StateRequest(number=1, time_ns=time.monotonic_ns() - 10_000_000)).state_reply.state
        asking.close()
        physics.remove()
        return scene, state

    def fake(self, scene, state):
        server = FakeServer(self.wire, os.path.join(self.root, "fake.sock"), scene, state)
        self.addCleanup(server.stop)
        return server


# ---------------------------------------------------------------------------------------------------- what it may say instead

EXTREME = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1e-308, 1e30, 3e38, 1e155)
MOMENTS = (0, 1, -1, 2**63 - 1, -2**63, 2**62 - 1, 1 - 2**62, 2**60 - 1, 1 - 2**60, 10**18)
ODD_TEXTS = ("\x1b[2J\x1b]0;x\x07", "\u202egnp.exe", "a\nb\rc", "\u009b31m", "x" * 512, "x" * 60000, "\0", "%s%n{}{0}")


def nothing(server, said, message):
    return []


def noise(server, said, message):
    return [server.random.randbytes(server.random.choice((0, 1, 7, 100, 5000))) for _ in range(10)] if said else []


def cut_off(server, said, message):
    """Each honest answer, but not all of it; and all of it with a bit turned."""
    answers = []
    for one in server.honest(said, message):
        whole = bytearray(one.SerializeToString())
        answers.append(bytes(whole[:server.random.randrange(len(whole))]))
        whole[server.random.randrange(len(whole))] ^= 1 << server.random.randrange(8)
        answers.append(bytes(whole))
    return answers


def huge(server, said, message):
    return [bytes(64 << 20)] if said == "hello" else []


def many_frames(server, said, message):
    if said != "state_request":
        return None
    answer = server.state_reply(message.state_request.number, message.state_request.time_ns)
    return [[answer, *[b"x" * 100] * 3000], [answer, *[b""] * 3000]]


def unasked(server, said, message):
    """Replies by the hundred to questions that nobody has asked."""
    number = server.random.choice((0, 1, 5, 10**6, 2**63, 2**64 - 1))
    return [server.state_reply(number, time.monotonic_ns()), server.reply(control_reply=server.wire.ControlReply(number=number, refusal="no")),
            server.reply(status_reply=server.wire.StatusReply(number=number, uptime_s=server.random.random())),
            server.reply(sync_reply=server.wire.SyncReply(number=number, received_ns=number % 2**62, sent_ns=number % 2**62))] * 50


def twice_and_late(server, said, message):
    if said != "state_request":
        return None
    asked = message.state_request
    return [server.state_reply(n, asked.time_ns) for n in (asked.number, asked.number, asked.number + 1, max(1, asked.number - 3), asked.number + 64)]


def odd_states(server, said, message):
    """Each number of a state in turn is none, infinite, too large."""
    if said != "state_request":
        return None
    state, pick = server.state_at(message.state_request.time_ns), server.random
    for _ in range(pick.choice((1, 1, 5))):
        what, value = pick.randrange(9), pick.choice(EXTREME)
        body = state.bodies[pick.randrange(len(state.bodies))]
        if what < 4:
            field = (body.position_m, body.orientation_wxyz, body.velocity_m_per_s, body.angular_velocity_rad_per_s)[what]
            field[pick.randrange(len(field))] = value
        elif what == 4:
            field = pick.choice((state.impact_force_n, state.impact_point_m, state.continuous_force_n, state.touching_point_m))
            field[pick.randrange(len(field))] = value
        elif what == 5:
            state.impact_share = value
        elif what == 6:
            state.time_ns = pick.choice(MOMENTS)
        elif what == 7:
            state.counters.extend([pick.choice((2**31 - 1, -2**31))] * pick.choice((1, 20)))
        else:
            state.bodies.extend([body] * pick.choice((1, 9)))
    return [server.state_reply(message.state_request.number, message.state_request.time_ns, state, extrapolated_ns=pick.choice((0, *MOMENTS)))]


def far_states(server, said, message):
    """As large as may pass, all of them."""
    if said != "state_request":
        return None
    state, far = server.state_at(message.state_request.time_ns), server.random.choice((1e308, -1e308, 1e30, 1e12, 1e-308))
    for body in state.bodies:
        body.visible = True
        for field in (body.position_m, body.velocity_m_per_s, body.angular_velocity_rad_per_s):
            field[:] = [far] * 3
    for field in (state.impact_force_n, state.impact_point_m, state.continuous_force_n, state.touching_point_m):
        field[:] = [far] * 3
    state.touching, state.impact_share = True, 1.0
    del state.counters[:]
    state.counters.extend([server.random.choice((2**31 - 1, -2**31))] * 16)
    return [server.state_reply(message.state_request.number, message.state_request.time_ns, state)]


def old_states(server, said, message):
    """Of another century: what a picture ahead of its time is to be reckoned from."""
    if said != "state_request":
        return None
    state = server.state_at(server.random.choice(MOMENTS))
    state.tick, state.impact_share = 5, 0.0
    for number, body in enumerate(state.bodies):  # a ball that falls past everything
        body.visible = True
        body.position_m[:], body.velocity_m_per_s[:] = [5.0 * (number == 0)] * 3, [0.0] * 3
    return [server.state_reply(message.state_request.number, message.state_request.time_ns, state)]


def new_sessions(server, said, message):
    """A server that is another one each time, with another scene."""
    if said != "hello":
        return None
    scene, pick = server.wire.SceneDescription(), server.random
    scene.CopyFrom(server.scene)
    scene.application = pick.choice(("touch", "pingpong", "jelly", "", *ODD_TEXTS))
    scene.shape_vertices = pick.choice((0, 1, LARGEST_SHAPE, LARGEST_SHAPE + 1, 2**32 - 1))
    if pick.random() < 0.5:
        del scene.surfaces[:]
        for i in range(pick.choice((0, 64, 65))):
            scene.surfaces.add(name=pick.choice(("table", f"s{i}", *ODD_TEXTS)), corners_m=[pick.choice((0.0, 1.0, *EXTREME)) for _ in range(12)])
    scene.gravity_m_per_s2[pick.randrange(3)] = pick.choice((0.0, *EXTREME))
    return [server.welcome(scene, pick.getrandbits(63) + 1, pick.choice(("", "tcp://127.0.0.1:1", *ODD_TEXTS))) for _ in range(20)]


def shape_frames(server, vertices):
    pick = server.random
    kind = pick.randrange(7)
    whole = vertices * 24
    if kind == 0:
        return []
    if kind == 1:
        return [bytes(max(0, whole - 1))]
    if kind == 2:
        return [bytes(whole), bytes(whole)]
    if kind == 3:
        return [b""] * 2000
    value = pick.choice((math.nan, math.inf, 3e38, -3e38, 1e-45, 0.0))
    return [struct.pack("<f", value) * (vertices * 6)]


def odd_shapes(server, said, message):
    if said == "hello":
        scene = server.wire.SceneDescription()
        scene.CopyFrom(server.scene)
        scene.shape_vertices = LARGEST_SHAPE
        return [server.welcome(scene, server.random.getrandbits(63) + 1)]
    if said != "state_request":
        return None
    asked, vertices = message.state_request, server.random.choice((LARGEST_SHAPE, LARGEST_SHAPE, 1, 0, 2**32 - 1))
    note = server.wire.ShapeNote(time_ns=server.random.choice((asked.time_ns, *MOMENTS)), vertices=vertices)
    return [[server.state_reply(asked.number, asked.time_ns, shape=note), *shape_frames(server, min(vertices, LARGEST_SHAPE))]]


def shapes_by_the_hundred(server, said, message):
    """Whole ones, as quickly as they go, asked for or not."""
    if said in ("hello", "sync_request", "status_request"):
        return odd_shapes(server, said, message)
    number = message.state_request.number if said == "state_request" else server.random.getrandbits(40)
    note = server.wire.ShapeNote(time_ns=time.monotonic_ns(), vertices=LARGEST_SHAPE)
    return [[server.state_reply(number, time.monotonic_ns(), shape=note), bytes(24 * LARGEST_SHAPE)]] * 10


def odd_clocks(server, said, message):
    """Years off, back and forth, sent before they were received."""
    if said != "sync_request":
        return None
    received, pick = time.monotonic_ns(), server.random
    other = pick.choice((*MOMENTS, received + 10**9, received - 10**9, received + 10**13))
    sent = pick.choice((other, max(-2**63, other - 1), other + 10**9, 2**63 - 1))
    return [server.reply(sync_reply=server.wire.SyncReply(number=message.sync_request.number, received_ns=other, sent_ns=min(sent, 2**63 - 1)))]


def jumping_clock(server, said, message):
    """Set anew every few exchanges, by a year, and back: each time in agreement with itself."""
    if said != "sync_request":
        return None
    now = time.monotonic_ns() + (message.sync_request.number // 8 % 3 - 1) * 3 * 10**16
    return [server.reply(sync_reply=server.wire.SyncReply(number=message.sync_request.number, received_ns=now, sent_ns=now))]


def refusals(server, said, message):
    return [server.reply(refusal=server.wire.Refusal(reason=f"{server.random.random()} {text}"[:600])) for text in ("no", *ODD_TEXTS)]


def odd_status(server, said, message):
    if said != "status_request":
        return None
    pick, wire = server.random, server.wire
    value = pick.choice(EXTREME)
    loop = wire.LoopStatus(name=pick.choice(("haptic", *ODD_TEXTS)), rate_hz=value, ticks=2**64 - 1, late_p50_us=value, late_p99_us=pick.choice(EXTREME),
                           late_octaves=[pick.choice((0, 1, 2**64 - 1))] * pick.choice((0, 1, 40, 41, 1000)), force_state=pick.randrange(9), force_fault=pick.randrange(20),
                           culprit=pick.choice(("", *ODD_TEXTS)))
    client = wire.ClientStatus(name=pick.choice(("x", *ODD_TEXTS)), role=pick.randrange(5))
    return [server.reply(status_reply=wire.StatusReply(number=message.status_request.number, uptime_s=pick.choice((1.0, pick.random(), value)), application=pick.choice(("a", *ODD_TEXTS)),
                                                       loops=[loop] * pick.choice((1, 8, 9)), clients=[client] * pick.choice((0, 64, 65)), requests=2**64 - 1))]


def odd_words(server, said, message):
    """In turn a status that is in order but for one text, which would steer a terminal, and a refusal in such words."""
    if said != "status_request":
        return None
    times = server.heard[said] - 1
    text = ODD_TEXTS[times // 2 % 4]
    if times % 2:
        return [server.reply(refusal=server.wire.Refusal(reason=text))]
    return [server.reply(status_reply=server.wire.StatusReply(number=message.status_request.number, uptime_s=time.monotonic(), application=text))]


ON_A_LINK = {attack.__name__: attack for attack in (
    nothing, noise, cut_off, huge, many_frames, unasked, twice_and_late, odd_states, far_states, old_states, new_sessions, odd_shapes, shapes_by_the_hundred, odd_clocks,
    jumping_clock, refusals, odd_status)}
