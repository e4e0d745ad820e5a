#!/usr/bin/env python3
"""palpate console: a running session as a page and as common viewers see it, and what strangers may not."""
import base64
import contextlib
import json
import os
import re
import shutil
import signal
import socket
import stat
import struct
import subprocess
import threading
import unittest

import zmq

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

import browser as browser_module
from laboratory import LaboratoryTest
from program import wait_until
from web_socket import Refused, WebSocket, get

PAGE = "palpate.console.v1"


class ConsoleTest(LaboratoryTest):
    def start_console(self, *options):
        """The program, its port, its token."""
        console = self.start("console", "--listen", "0", *options)
        self.assertTrue(console.says("the console is at"), console.lines())
        found = re.search(r"http://[^/]+:(\d+)/(?:#token=(\w+))?", "\n".join(console.lines()))
        return console, int(found.group(1)), found.group(2)

    def hears(self, peer, wanted, what, most=4000):
        """The first message that is as wanted."""
        for _ in range(most):
            text = peer.receive()
            self.assertIsNotNone(text, f"the connection has ended before {what}")
            message = json.loads(text) if isinstance(text, str) else text
            if isinstance(message, dict) and wanted(message):
                return message
        self.fail(f"not heard: {what}")

    def lights(self, peer, **wanted):
        return self.hears(peer, lambda m: m["op"] == "status" and all(
            any(one["name"] == name and one["level"] == level for one in m["lights"]) for name, level in wanted.items()), wanted)

    def ends_in_order(self, console):
        console.send(signal.SIGINT)
        done = console.ends()
        self.assertEqual(done.code, 0, done)
        return done


class Page(ConsoleTest):
    def test_it_lives_without_a_server_and_shows_one_that_comes_goes_and_returns(self):
        console, port, token = self.start_console("--json", "figures.json")
        self.assertIsNone(token)
        with WebSocket(port, PAGE, origin=f"http://127.0.0.1:{port}") as page:
            self.lights(page, servers="fault", forces="off")
            world, physics = self.start_world(), self.start_physics("--record", "session.mcap")
            scene = self.hears(page, lambda m: m["op"] == "scene", "the scene")
            self.assertEqual(scene["application"], "pingpong")
            self.assertIn("table", [one["name"] for one in scene["surfaces"]])
            self.assertEqual([len(one["corners"]) for one in scene["surfaces"]], [4] * len(scene["surfaces"]))
            status = self.lights(page, servers="good", arm="good", tracker="off", recording="good")
            self.assertGreater(status["status"]["loops"][0]["limits_n"]["peak"], 1.0)
            first = self.hears(page, lambda m: m["op"] == "states", "states")
            for _ in range(20):
                second = self.hears(page, lambda m: m["op"] == "states", "more states")
            self.assertGreater(int(second["t_ns"]), int(first["t_ns"]))
            self.assertEqual(len(second["force"]), len(second["dt_ms"]))
            self.assertEqual(len(second["bodies"]), len(scene["bodies"]))
            graphics = self.start_graphics()
            self.lights(page, servers="good", tracker="good", camera="good", clocks="good")
            # An outage and its end.
            world.send(signal.SIGSTOP)
            told = self.hears(page, lambda m: any("forces off" in e["words"] for e in m.get("events", ())), "an outage")
            self.assertTrue(any("arm" in e["words"] for e in told["events"]), told["events"])
            world.send(signal.SIGCONT)
            self.hears(page, lambda m: any("forces are back" in e["words"] for e in m.get("events", ())), "its end")
            physics.send(signal.SIGINT)
            physics.ends()
            self.lights(page, servers="fault", recording="off")
            physics = self.start_physics()
            self.lights(page, servers="good", recording="off")
            page.send(json.dumps({"op": "control", "control": "reset"}))
            no = self.hears(page, lambda m: m["op"] == "refusal", "a refusal")
            self.assertIn("only shows", no["words"])
            self.stop_in_order(graphics, physics, world)
        self.ends_in_order(console)
        figures = json.loads(self.read("figures.json"))
        self.assertEqual(figures["peers"], 1)
        self.assertEqual(figures["controls"], 0)

    def test_whoever_has_the_token_may_reset_and_nobody_else(self):
        world, physics = self.start_world(), self.start_physics()
        console, port, token = self.start_console("--controls")
        with WebSocket(port, PAGE) as page:
            self.assertTrue(self.lights(page, servers="good")["console"]["controls"])

            def asks(**wish):
                page.send(json.dumps({"op": "control", **wish}))
            for wish, words in (({"control": "reset"}, "token"), ({"control": "reset", "token": "0" * 32}, "token"),
                                ({"control": "reset", "token": 7}, "token"), ({"control": "begin", "token": token}, "expected")):
                asks(**wish)
                self.assertIn(words, self.hears(page, lambda m: m["op"] == "refusal", wish)["words"])
            before = json.loads(self.runs("status", "--json", "-").out)["service"]["controls"]
            asks(control="pause", token=token)
            asks(control="resume", token=token)
            asks(control="reset", token=token)
            wait_until(lambda: json.loads(self.runs("status", "--json", "-").out)["service"]["controls"] == before + 3, "three wishes carried out")
        self.ends_in_order(console)
        self.stop_in_order(physics, world)

    def test_a_private_one_shows_nothing_without_the_token_which_is_in_a_file_of_this_users(self):
        console, port, token = self.start_console("--private")
        with WebSocket(port, PAGE) as page:
            self.assertIsNone(page.receive())
        with WebSocket(port, PAGE, path=f"/?token={token}") as page:
            self.lights(page, servers="fault")
        with WebSocket(port, "foxglove.websocket.v1", path="/?token=" + "0" * 32) as viewer:
            self.assertIsNone(viewer.receive())
        self.ends_in_order(console)
        files = [os.path.join(folder, name) for folder, _, names in os.walk(self.meeting) for name in names if name == "console_token"]
        self.assertEqual(len(files), 1)
        self.assertEqual(stat.S_IMODE(os.stat(files[0]).st_mode), 0o600)

    def test_wrong_uses_are_told(self):
        self.refuses(["console", "--listen", "*:0"], 2, "--exposed")
        self.refuses(["console", "--listen", "nowhere"], 2, "HOST:PORT")
        self.refuses(["console", "--connect", "http://x"], 2, "ipc://")
        with socket.create_server(("127.0.0.1", 0)) as taken:
            self.refuses(["console", "--connect", f"ipc://{self.root}/nobody.sock", "--listen", taken.getsockname()[1]], 1, "check what listens there")

    def test_beyond_this_machine_it_asks_everybody_for_the_token(self):
        console = self.start("console", "--listen", "*:0", "--exposed")
        self.assertTrue(console.says("the console is at"), console.lines())
        self.assertTrue(any("SSH tunnel" in line for line in console.lines()), console.lines())
        port, token = re.search(r"http://localhost:(\d+)/#token=(\w+)", "\n".join(console.lines())).groups()
        self.assertEqual(get(int(port), host="192.168.1.7:1")[0], 200)  # a number is no name that was pointed here
        self.assertEqual(get(int(port), host="evil.example")[0], 421)
        with WebSocket(int(port), PAGE) as page:
            self.assertIsNone(page.receive())
        with WebSocket(int(port), PAGE, path=f"/?token={token}") as page:
            self.lights(page, servers="fault")
        self.ends_in_order(console)


class Strangers(ConsoleTest):
    def test_the_page_is_whole_and_asks_no_other_host(self):
        console, port, _ = self.start_console()
        status, headers, page = get(port)
        self.assertEqual(status, 200)
        self.assertIn("default-src 'self'", headers["content-security-policy"])
        page = page.decode()
        self.assertNotRegex(page, r"(?:src|href)=\"(?:https?:)?//")
        self.assertNotIn("<script>", page)  # none but files
        to_see = set(re.findall(r"(?:src|href)=\"([^\"]+)\"", page))
        seen = set()
        while to_see - seen:
            name = (to_see - seen).pop()
            seen.add(name)
            status, headers, content = get(port, "/" + name)
            self.assertEqual(status, 200, name)
            if name.endswith(".js"):
                self.assertTrue(headers["content-type"].startswith("text/javascript"), name)
                to_see |= set(re.findall(r"^import .* from '\./([^']+)'", content.decode(), re.M))
        self.assertLessEqual({"console.js", "world_view.js", "uPlot.iife.min.js", "console.css"}, seen)
        self.assertEqual(get(port, "/../../etc/passwd")[0], 404)
        self.ends_in_order(console)

    def test_foreign_hosts_and_origins_large_frames_and_many_connections_are_refused(self):
        world, physics = self.start_world(), self.start_physics()
        console, port, _ = self.start_console("--allow-origin", "https://app.foxglove.dev", "--json", "figures.json")
        for host, origin, code in (("evil.example", None, 421), ("evil.example", "http://evil.example", 421), (None, "http://evil.example", 403),
                                   (None, "null", 403), (None, f"http://127.0.0.1:{port + 1}", 403), ("", None, 421)):
            for protocol in (PAGE, "foxglove.websocket.v1"):
                with self.assertRaises(Refused, msg=(host, origin)) as refusal:
                    WebSocket(port, protocol, host=host, origin=origin)
                self.assertIn(refusal.exception.args[0], (code, 400))
        for protocol in (None, "chat"):
            with self.assertRaises(Refused):
                WebSocket(port, protocol)
        WebSocket(port, "foxglove.sdk.v1", origin="https://app.foxglove.dev").close()
        with WebSocket(port, PAGE) as quiet:
            self.lights(quiet, servers="good")
            # A frame of a megabyte.
            with WebSocket(port, PAGE) as large:
                try:
                    large.send(b"x" * (1 << 20))
                    while large.receive() is not None:
                        pass
                except ConnectionError:
                    pass
            # Nonsense in every form.
            with WebSocket(port, PAGE) as odd:
                for text in ("", "{", "[]", "7", '{"op":7}', '{"op":"seen"}', '{"op":"seen","t_ns":"x"}', '{"op":"seen","t_ns":"9999999999999999999999"}',
                             '{"op":"control"}', "\0", '{"a":' * 5000):
                    odd.send(text)
                odd.send(b"\xff\xfe", 2)
                self.lights(odd, servers="good")
                odd.send(b"\xff\xfe", 1)  # text that is none
                while odd.receive() is not None:
                    pass
            # A thousand that say nothing.
            links = []
            for _ in range(1000):
                try:
                    links.append(socket.create_connection(("127.0.0.1", port), timeout=5))
                except OSError:
                    break
            self.lights(quiet, servers="good")
            for link in links:
                link.close()
            self.lights(quiet, servers="good")
        wait_until(lambda: self.answers(port), "it answers again")
        loops = json.loads(self.runs("status", "--json", "-").out)["loops"]
        self.assertGreater(loops[0]["ticks"], 0)
        self.ends_in_order(console)
        figures = json.loads(self.read("figures.json"))
        self.assertGreater(figures["refused"], 900)
        self.stop_in_order(physics, world)

    def answers(self, port):
        try:
            return get(port)[0] == 200
        except OSError:
            return False

    def test_one_that_never_reads_loses_messages_alone(self):
        world, physics = self.start_world(), self.start_physics()
        console, port, _ = self.start_console("--json", "figures.json")
        with WebSocket(port, "foxglove.websocket.v1") as deaf, WebSocket(port, PAGE) as page:
            # As often as one may subscribe: some 250 times 60 messages a second.
            deaf.link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            deaf.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": i, "channelId": 1} for i in range(250)]}))
            for _ in range(100):
                message = self.hears(page, lambda m: m["op"] == "states", "states meanwhile")
            self.lights(page, servers="good")
            self.assertGreater(int(message["t_ns"]), 0)
            self.assertEqual(self.lights(page, servers="good")["console"]["page_dropped"], 0)
            wait_until(lambda: self.lights(page, servers="good")["console"]["viewers"] == 1, "the deaf one is cut off")
        self.ends_in_order(console)
        figures = json.loads(self.read("figures.json"))
        self.assertGreater(figures["dropped"], 0)
        self.assertEqual(figures["cut_off"], 1)
        self.stop_in_order(physics, world)


class Viewers(ConsoleTest):
    def test_every_channel_comes_and_is_read_by_the_schema_that_was_sent(self):
        world, physics = self.start_world(), self.start_physics()
        graphics = self.start_graphics()
        console, port, _ = self.start_console()
        for protocol in ("foxglove.websocket.v1", "foxglove.sdk.v1"):
            with WebSocket(port, "unheard.of.v9, " + protocol) as viewer:
                self.assertEqual(viewer.protocol, protocol)
                self.assertEqual(self.hears(viewer, lambda m: True, "a greeting")["op"], "serverInfo")
                channels = {c["id"]: c for c in self.hears(viewer, lambda m: m["op"] == "advertise", "channels")["channels"]}
                viewer.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 100 + i, "channelId": i} for i in channels]}))
                got, stopped = {}, False
                while set(got) != set(channels):
                    data = viewer.receive()
                    self.assertIsNotNone(data)
                    if isinstance(data, str):
                        self.fail(data)
                    opcode, subscription, time_ns = struct.unpack_from("<BIQ", data)
                    self.assertEqual(opcode, 1)
                    self.assertGreater(time_ns, 1_700_000_000_000_000_000)
                    got[subscription - 100] = data[13:]
                    if not stopped and {channels[i]["topic"] for i in set(channels) - set(got)} == {"/log"}:  # something for it
                        stopped = True
                        world.send(signal.SIGSTOP)
                world.send(signal.SIGCONT)
                for number, channel in channels.items():
                    self.assertTrue(str(self.read_by(channel, got[number])), channel["topic"])
                viewer.send(json.dumps({"op": "publish"}))
                self.assertIn("not served", self.hears(viewer, lambda m: True, "a complaint")["message"])
        self.ends_in_order(console)
        self.stop_in_order(graphics, physics, world)

    def read_by(self, channel, data):
        files = descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(channel["schema"]))
        pool = descriptor_pool.DescriptorPool()
        for file in files.file:
            pool.Add(file)
        kind = message_factory.MessageFactory(pool).GetPrototype(pool.FindMessageTypeByName(channel["schemaName"]))
        return kind.FromString(data)


@unittest.skipUnless(browser_module.CHROMIUM, "no Chromium here")
class Browser(ConsoleTest):
    @contextlib.contextmanager
    def named(self, name):
        """A client of this name, as long as it says that it is there."""
        hello = self.wire_messages().ToPhysics(protocol=2)
        hello.hello.client, hello.hello.name = 77, name
        over = threading.Event()

        def greet():
            peer = zmq.Context.instance().socket(zmq.DEALER)
            peer.linger = 0
            peer.connect(f"ipc://{self.meeting}/palpate/physics.sock")
            while not over.wait(0.2):
                peer.send(hello.SerializeToString())
            peer.close()
        greeting = threading.Thread(target=greet)
        greeting.start()
        try:
            yield
        finally:
            over.set()
            greeting.join()

    def test_a_browser_draws_it_soon_and_takes_names_as_text(self):
        self.runs("world", "sample", "landmarks", "--out", "dots")
        self.runs("calibrate", "landmarks", "--points", "dots/landmarks.csv", "--rig", "rig.toml")
        world, physics = self.start_world(), self.start_physics()
        graphics = self.start_graphics()
        console, port, _ = self.start_console("--json", "figures.json")
        browser = browser_module.Browser(f"{self.root}/browser")
        self.addCleanup(browser.close)
        with self.named("<script>document.title='taken'</script>"):
            browser.open(f"http://127.0.0.1:{port}/")
            for wanted in ("document.querySelectorAll('#lights .good').length >= 5", "document.body.textContent.includes('<script>document.title')",
                           "document.body.textContent.includes('graphics (operator)')", "document.getElementById('picture').naturalWidth > 0",
                           "/Shown \\d+ ms after/.test(document.getElementById('foot').textContent)"):
                self.assertTrue(browser.waits_for(wanted), f"{wanted}; told {browser.told}; {browser.value('document.body.innerText')}")
            self.assertTrue(browser.waits_for("document.querySelectorAll('#marks circle:not(.rejected)').length >= 4"), "rings round the landmarks")
            dom = browser.value("document.documentElement.outerHTML")
            for width in (1400, 400):
                browser.do("Emulation.setDeviceMetricsOverride", width=width, height=1000, deviceScaleFactor=1, mobile=False)
                self.assertTrue(browser.waits_for(f"document.documentElement.scrollWidth <= {width}"), f"at {width} px nothing is beyond the page")
                browser.picture(self.path(f"console_{width}.png"))
            # What is drawn is no empty frame: where the world and the plot are, pixels differ.
            for canvas in ("#force-plot canvas", "#scene canvas"):
                self.assertGreater(browser.value(f"(() => {{ const c = document.querySelector('{canvas}'); return new Set(new Uint32Array("
                                                 "c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer)).size; })()"), 10, canvas)
            self.assertTrue(browser.waits_for("/force.*\\d\\.\\d\\d N/.test(document.querySelector('#force-plot .u-legend').textContent)"),
                            "the legend tells the newest value, wherever the pointer is")
            # Up is up, and the user's side is in front (docs/conventions.md).
            browser.value("import('./world_view.js').then((m) => { const v = new m.WorldView(document.createElement('div')); v.view = v.axes(); "
                          "const [o, y, z] = [[0, 0, 0], [0, 0.1, 0], [0, 0, 0.1]].map((p) => v.place(p)); "
                          "window.upright = y.y < o.y && Math.abs(y.x - o.x) < 1e-6 && z.depth < o.depth; }) && true")
            self.assertTrue(browser.waits_for("window.upright"))
        self.assertEqual(browser.told, [])
        if (kept := os.environ.get("CONSOLE_PICTURES")):
            for width in (1400, 400):
                shutil.copy(self.path(f"console_{width}.png"), kept)
        self.assertIn("<title>pingpong: Palpate console</title>", dom)
        for name in ("servers", "arm", "forces", "tracker", "camera", "clocks", "recording"):
            self.assertRegex(dom, rf'<li class="(?:good|notice|warning|fault|off)"><b>{name}</b>')
        self.assertIn("&lt;script&gt;document.title", dom)
        self.assertNotIn("<script>document.title", dom)
        self.assertIn("graphics (operator)", dom)
        self.assertRegex(dom, r"Limits: \d+\.\d N at most")
        self.assertGreaterEqual(dom.count("<canvas"), 2)  # the plot and the world
        self.ends_in_order(console)
        shown = json.loads(self.read("figures.json"))["shown_after_ms"]
        self.assertGreater(shown["count"], 10)
        self.assertLess(shown["p50"], 1000.0)  # how soon on a quiet machine: docs/performance.md
        self.stop_in_order(graphics, physics, world)


if __name__ == "__main__":
    unittest.main()
