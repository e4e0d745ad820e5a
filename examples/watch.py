#!/usr/bin/env python3
"""Watches a physics server on this machine: what it shows, one state asked for, then 30 states a second.
    examples/watch.py [ADDRESS [COUNT]]     needs python3-zmq, python3-protobuf, protobuf-compiler; docs/network.md"""
import os, random, subprocess, sys, tempfile, time
import zmq

here, made = os.path.dirname(os.path.abspath(__file__)), tempfile.TemporaryDirectory()
subprocess.run(["protoc", f"-I{here}/../proto", f"--python_out={made.name}", "palpate.proto"], check=True)
sys.path.append(made.name)
import palpate_pb2 as wire

run = f"{os.environ['XDG_RUNTIME_DIR']}/palpate" if "XDG_RUNTIME_DIR" in os.environ else f"/dev/shm/palpate-{os.getuid()}"
address = sys.argv[1] if len(sys.argv) > 1 else f"ipc://{run}/physics.sock"
count = int(sys.argv[2]) if len(sys.argv) > 2 else 150
server = zmq.Context.instance().socket(zmq.DEALER)
server.setsockopt(zmq.RCVTIMEO, 5000)
server.connect(address)


def ask(**body):
    server.send(wire.ToPhysics(protocol=2, **body).SerializeToString())
    reply = wire.ToGraphics.FromString(server.recv())
    return getattr(reply, reply.WhichOneof("body"))


welcome = ask(hello=wire.Hello(client=random.randrange(1, 2**63), name="watch.py"))
print(f"{welcome.scene.application}: {', '.join(s.name for s in welcome.scene.surfaces)}; we are {wire.Role.Name(welcome.role)}")
moment = time.monotonic_ns() - 20_000_000  # the same clock as the server's, on one machine
reply = ask(state_request=wire.StateRequest(number=1, time_ns=moment))
print(f"20 ms ago: tick {reply.state.tick}, {wire.AnswerKind.Name(reply.kind)}")

states = zmq.Context.instance().socket(zmq.DEALER)
states.setsockopt(zmq.RCVTIMEO, 5000)
states.connect(welcome.states)
for i in range(count):
    if i % 30 == 0:  # once a second: a subscription lapses after three
        states.send(wire.ToPhysics(protocol=2, subscribe=wire.Subscribe(rate_hz=30)).SerializeToString())
    state = wire.ToGraphics.FromString(states.recv()).state_reply.state
    print(f"{state.tick:9d}", *(f"({b.position_m[0]:+.3f} {b.position_m[1]:+.3f} {b.position_m[2]:+.3f}) m" for b in state.bodies))
