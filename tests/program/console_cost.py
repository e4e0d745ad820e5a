"""What the console costs who is looked at, and how soon its page shows a force: on this machine, in real time.

Rounds of four: nobody looks; a viewer that never reads; eight pages; one page in a browser. Printed: of each the pictures a
second, ticks of the loops that were missed, the console's share of a core, and how old a state was when the page had drawn it."""
import json
import os
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time

import browser
from laboratory import calibrate
from web_socket import WebSocket

PROGRAM = os.environ["PALPATE"]
SECONDS, ROUNDS = float(os.environ.get("SECONDS_EACH", 12)), int(os.environ.get("ROUNDS", 4))
KINDS = ("nobody", "one that never reads", "eight pages", "a browser")


def processor_s(process):
    fields = open(f"/proc/{process.pid}/stat", encoding="ascii").read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Readers:
    """So many pages that take what comes."""
    def __init__(self, port, count):
        self.pages = [WebSocket(port, "palpate.console.v1") for _ in range(count)]
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.read)
        self.thread.start()

    def read(self):
        while not self.over.is_set():
            for link in select.select([page.link for page in self.pages], [], [], 0.1)[0]:
                link.recv(1 << 20)

    def close(self):
        self.over.set()
        self.thread.join()
        for page in self.pages:
            page.close()


def look(kind, port, folder):
    if kind == "one that never reads":
        deaf = WebSocket(port, "foxglove.websocket.v1")
        deaf.link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": i, "channelId": 1} for i in range(250)]}))
        return deaf
    if kind == "eight pages":
        return Readers(port, 8)
    page = browser.Browser(os.path.join(folder, "browser"))
    page.open(f"http://127.0.0.1:{port}/")
    return page


def one_round(kind, run, start, folder):
    console = looker = None
    if kind != "nobody":
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        console = start("console", "--listen", str(port), "--json", "console.json")
        time.sleep(1.5)
        looker = look(kind, port, folder)
        time.sleep(1.5)
    before, began, used = json.loads(run("status", "--json", "-")), time.monotonic(), processor_s(console) if console else 0
    time.sleep(SECONDS)
    after, passed = json.loads(run("status", "--json", "-")), time.monotonic() - began
    used = processor_s(console) - used if console else 0
    drawn = [next(c["frames"] for c in status["clients"] if c["frames"]) for status in (before, after)]
    missed = ", ".join(f"{b['name']} {b['missed'] - a['missed']}" for a, b in zip(before["loops"], after["loops"]))
    shown = ""
    if looker:
        looker.close()
        console.terminate()
        console.wait()
        ms = json.load(open(os.path.join(folder, "console.json"), encoding="ascii"))["shown_after_ms"]
        if ms["count"]:
            shown = f"; shown after {ms['p50']:.1f} ms (median of {ms['count']}; 99 of 100 within {ms['p99']:.0f} ms)"
    shutil.rmtree(os.path.join(folder, "browser"), ignore_errors=True)
    print(f"{kind:>21}: {(drawn[1] - drawn[0]) / passed:.1f} pictures/s; ticks missed: {missed}; console {100 * used / passed:.1f} % of a core{shown}", flush=True)


def main():
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "XDG_RUNTIME_DIR": folder}

        def run(*arguments):
            return subprocess.run([PROGRAM, *map(str, arguments)], cwd=folder, env=environment, check=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True).stdout

        def start(*arguments):
            return subprocess.Popen([PROGRAM, *arguments], cwd=folder, env=environment, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        os.chmod(folder, 0o700)
        calibrate(run)
        servers = []
        for command in (["world", "run"], ["physics", "--rig", "rig.toml"], ["graphics", "--rig", "rig.toml", "--player"]):
            servers.append(start(*command))
            time.sleep(2)
        try:
            for _ in range(ROUNDS):
                for kind in KINDS:
                    if kind != "a browser" or browser.CHROMIUM:
                        one_round(kind, run, start, folder)
        finally:
            for server in servers[::-1]:
                server.terminate()
                server.wait()


if __name__ == "__main__":
    sys.exit(main())
