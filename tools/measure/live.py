"""The pace of a live run with its page open."""
import http.client
import json
import re
import shutil
import signal
import subprocess
import threading
import time

import numpy as np

from .registry import MeasureError, markdown, table
from .runs import words_of

counts = (2500, 5000)  # particles; each row is measured from .8 to 1.2 of its own
columns = "particles | real time | pictures a second | between two, median and 95 of 100, ms | CPU, ms a frame"


class Viewer(threading.Thread):
    """Takes the pictures as a page does: when each came, and of which frame."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port, self.pictures = port, []

    def run(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.port)
        connection.request("GET", "/stream")
        stream, head = connection.getresponse(), {}
        while line := stream.readline():
            name, colon, value = line.decode().strip().partition(":")
            if colon:
                head[name] = value.strip()
            elif head:
                stream.read(int(head["Content-Length"]) + 2)
                if not self.pictures or self.pictures[-1][1] != int(head["X-Frame"]):
                    self.pictures.append((time.monotonic(), int(head["X-Frame"])))
                head = {}


def cpu_seconds(process):
    with open(f"/proc/{process.pid}/stat", encoding="utf-8") as stat:
        return sum(map(int, stat.read().rpartition(")")[2].split()[11:13])) / 100


def states(port, process):
    """(wall time, CPU seconds, state), ten times a second, until there are enough particles."""
    rows, connection, began = [], http.client.HTTPConnection("127.0.0.1", port), time.monotonic()
    while time.monotonic() - began < 240:
        connection.request("GET", "/state")
        rows.append((time.monotonic(), cpu_seconds(process), json.loads(connection.getresponse().read())))
        if rows[-1][2]["particles"] > 1.2 * counts[-1]:
            return rows
        time.sleep(0.1)
    raise MeasureError("the live run did not come to its last particles within 240 s")


def row_of(count, rows, pictures):
    near = [row for row in rows if 0.8 * count <= row[2]["particles"] <= 1.2 * count]
    (began, cpu, first), (ended, cpu_after, last) = near[0], near[-1]
    came = np.array([at for at, _ in pictures if began <= at <= ended])
    gaps, frames = 1e3 * np.diff(came), last["frame"] - first["frame"]
    return [count, f"{(last['time'] - first['time']) / (ended - began):.2f}", f"{len(came) / (ended - began):.1f}",
            f"{np.median(gaps):.0f}, {np.percentile(gaps, 95):.0f}", f"{1e3 * (cpu_after - cpu) / frames:.0f}"]


@table("live", "pace of a live run of honey_coil with its page open", "1 min")
def live(m):
    folder, browser = m.out / "live", shutil.which("chromium") or shutil.which("google-chrome")
    command = [m.program, "live", "honey_coil", "--port", "0", "--quiet", "--out", folder, *m.sets(["emitter[0].stop=9", "time.end=9"])]
    m.say(words_of(command))
    if m.dry:
        return markdown(columns, [[count] for count in counts])
    shutil.rmtree(folder, ignore_errors=True)
    program, page = subprocess.Popen(command, stdout=subprocess.PIPE, text=True), None
    try:
        address = program.stdout.readline().strip()
        found = re.search(r":(\d+)/", address)
        if not found:
            raise MeasureError("whorl live gave no address")
        port = int(found[1])
        if browser:
            page = subprocess.Popen([browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1280,900",
                                     f"--user-data-dir={m.out / 'live_browser'}", address], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        else:
            m.say("no chromium: only a viewer of its own takes the pictures")
        viewer = Viewer(port)
        viewer.start()
        rows = states(port, program)
    finally:
        for process in filter(None, (page, program)):
            process.send_signal(signal.SIGINT)
        program.wait(30)
        if page:
            page.terminate(), page.wait(30)
    return markdown(columns, [row_of(count, rows, viewer.pictures) for count in counts])
