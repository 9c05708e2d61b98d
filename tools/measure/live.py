"""Pace of a live run with its page open, and delay until an image shows a change."""
import collections
import http.client
import json
import os
import random
import re
import shutil
import signal
import subprocess
import threading
import time
from dataclasses import dataclass

import numpy as np

from .registry import MeasureError, markdown, table
from .runs import words_of

counts = (2500, 5000)  # particles; a row is measured while the run has 0.8 to 1.2 times its count
columns = ("particles | real time | images per second | interval, ms | 95th percentile, ms | CPU of simulation, ms per second | of images | "
           "of the browser")
changes = {"look.exposure": (1.3, 1.0), "fluid.viscosity": (1200, 1000)}  # alternately
tries = 24  # per key of `changes`
change_columns = "change | delay to the image, ms | 95th percentile, ms"


@dataclass
class Picture:
    came: float
    time: float  # simulated
    revision: dict  # "fluid", "look"


class Viewer(threading.Thread):
    """Receives the images of a live run as its page does."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port, self.pictures, self.leaving, self.interrupted = port, [], False, []

    def run(self):
        while not self.leaving:  # a stream that the server ends is opened again, as browsers do
            try:
                self.receive()
                self.interrupted.append("the stream ended")
            except (OSError, http.client.HTTPException) as error:
                self.interrupted.append(repr(error))
            time.sleep(0.05)

    def receive(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.request("GET", "/stream?once=1")
        stream, head = connection.getresponse(), {}
        if stream.status != 200:
            raise http.client.HTTPException(f"status {stream.status}: {stream.read().decode()}")
        while line := stream.readline():
            name, colon, value = line.decode().strip().partition(":")
            if colon:
                head[name] = value.strip()
            elif head:
                stream.read(int(head["Content-Length"]) + 2)
                self.pictures.append(Picture(time.monotonic(), float(head["X-Time"]), {"fluid": int(head["X-Revision"]), "look": int(head["X-Look-Revision"])}))
                head = {}


def ask(port, path, body=None):
    connection = http.client.HTTPConnection("127.0.0.1", port)
    connection.request("POST" if body else "GET", path, body and json.dumps(body))
    return json.loads(connection.getresponse().read())


def process_cpu(process):
    """CPU seconds used by a process and its children."""
    children, own, total, left = collections.defaultdict(list), {}, 0, [process.pid]
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat", encoding="utf-8", errors="replace") as stat:
                values = stat.read().rpartition(")")[2].split()
        except OSError:  # the process ended
            continue
        children[int(values[1])].append(int(name))
        own[int(name)] = sum(map(int, values[11:13])) / os.sysconf("SC_CLK_TCK")
    while left:
        pid = left.pop()
        total += own.get(pid, 0)
        left += children[pid]
    return total


def thread_cpu(process):
    """CPU seconds used by the threads that simulate, and by those that make and send images."""
    simulation = pictures = 0
    for task in os.listdir(f"/proc/{process.pid}/task"):
        try:
            with open(f"/proc/{process.pid}/task/{task}/comm", encoding="utf-8") as comm, open(f"/proc/{process.pid}/task/{task}/schedstat", encoding="utf-8") as times:
                name, seconds = comm.read().strip(), int(times.read().split()[0]) / 1e9
        except OSError:
            continue
        if name.startswith(("draw", "llvmpipe", "server")):
            pictures += seconds
        else:
            simulation += seconds
    return simulation, pictures


class Session:
    """A live run of thick_coil with its page open in a browser, if there is one."""

    def __init__(self, m, command):
        self.browser = shutil.which("chromium") or shutil.which("google-chrome")
        self.program, self.page = subprocess.Popen(command, stdout=subprocess.PIPE, text=True), None
        address = self.program.stdout.readline().strip()
        found = re.search(r":(\d+)/", address)
        if not found:
            raise MeasureError("whorl live gave no address")
        self.port = int(found[1])
        if self.browser:
            self.page = subprocess.Popen([self.browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1280,900",
                                          f"--user-data-dir={m.out / 'live_browser'}", address], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        else:
            m.say("no chromium: only the script's viewer receives the images")
        # The run waits for its first viewer. If the script were the first, the browser would start during the measurement.
        began = time.monotonic()
        while self.page and ask(self.port, "/state")["time"] == 0 and time.monotonic() - began < 30:
            time.sleep(0.1)
        self.viewer = Viewer(self.port)
        self.viewer.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.viewer.leaving = True
        for process in filter(None, (self.page, self.program)):
            process.send_signal(signal.SIGINT)
        self.program.wait(30)
        if self.page:
            self.page.terminate(), self.page.wait(30)

    def cpu(self):
        return np.array([*thread_cpu(self.program), process_cpu(self.page) if self.page else 0])

    def states(self, particles):
        """(wall time, CPU seconds, state), five times a second, until there are `particles` particles."""
        rows, began = [], time.monotonic()
        while time.monotonic() - began < 240:
            rows.append((time.monotonic(), self.cpu(), ask(self.port, "/state")))
            if rows[-1][2]["particles"] > particles:
                return rows
            time.sleep(0.2)
        raise MeasureError(f"the live run did not reach {particles:.0f} particles within 240 s")

    def seconds_until_seen(self, key, value):
        kind = "look" if key.startswith(("look.", "camera.")) else "fluid"
        began = time.monotonic()
        revision = ask(self.port, "/set", {key: value})["revision"]
        while time.monotonic() - began < 10:
            for picture in self.viewer.pictures[-50:]:
                if picture.revision[kind] >= revision:
                    return picture.came - began
            time.sleep(0.002)
        raise MeasureError(f"no image showed {key} = {value} within 10 s")


def row_of(count, rows, viewer):
    low, high = 0.8 * count, 1.2 * count
    near = [row for row in rows if low <= row[2]["particles"] <= high]
    if len(near) < 2:
        raise MeasureError(f"the run reported {len(near)} states with {low:.0f} to {high:.0f} particles; two are needed. Run it again on an idle machine")
    (began, cpu, first), (ended, cpu_after, last) = near[0], near[-1]
    seen = [p for p in viewer.pictures if began <= p.came <= ended]
    if len(seen) < 2:
        came = ", ".join(f"{p.came - rows[0][0]:.1f}" for p in viewer.pictures[-3:]) or "never"
        raise MeasureError(f"{len(seen)} images came from {began - rows[0][0]:.1f} to {ended - rows[0][0]:.1f} s, while the run had {low:.0f} to "
                           f"{high:.0f} particles; two are needed. Of {len(viewer.pictures)} images the last came at {came} s; "
                           f"{'; '.join(viewer.interrupted) or 'the stream was not interrupted'}. Run it again on an idle machine")
    gaps, wall = 1e3 * np.diff([p.came for p in seen]), ended - began
    return [count, f"{(last['time'] - first['time']) / wall:.2f}", f"{len(seen) / wall:.1f}",
            f"{np.median(gaps):.0f}", f"{np.percentile(gaps, 95):.0f}", *(f"{1e3 * c / wall:.0f}" for c in cpu_after - cpu)]


def changes_of(session):
    """Rows of the second table: changes at times independent of the images."""
    moments, rows = random.Random(1), []
    for key, values in changes.items():
        taken = []
        for k in range(tries):
            time.sleep(moments.uniform(0.25, 0.5))
            taken.append(1e3 * session.seconds_until_seen(key, values[k % 2]))
        rows.append([key, f"{np.median(taken):.0f}", f"{np.percentile(taken, 95):.0f}"])
    return rows


@table("live", "pace of a live run of thick_coil with its page open, and the delay until an image shows a change", "2 min")
def live(m):
    folder = m.out / "live"
    start = [m.program, "live", "thick_coil", "--port", "0", "--quiet", "--out", folder]
    growing, changing = ([*start, *m.sets([f"emitter[0].stop={stop}", f"time.end={end}"])] for stop, end in ((9, 9), (2, 99)))
    for command in (growing, changing):
        m.say(words_of(command))
    if m.dry:
        return markdown(columns, [[count] for count in counts])
    shutil.rmtree(folder, ignore_errors=True)
    with Session(m, growing) as session:
        rows = session.states(1.2 * counts[-1])
        m.say(f"pace reported at the end: {rows[-1][2].get('pace') or 'none'}")
    pace = markdown(columns, [row_of(count, rows, session.viewer) for count in counts])
    shutil.rmtree(folder, ignore_errors=True)
    with Session(m, changing) as session:
        session.states(0.95 * counts[0])
        seen = changes_of(session)
    return f"{pace}\n\nWith {counts[0]} particles:\n\n{markdown(change_columns, seen)}"
