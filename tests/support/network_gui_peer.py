# SPDX-License-Identifier: MIT
#
# A trainer as viewers meet it: it looks for a viewer once per iteration, reads what one call of recv gives, answers one
# request per iteration, and waits without end for a silent viewer. The picture's colour is the number of the iteration.
#   network_gui_peer.py viewer_first|trainer_first PORT_FILE LOG_FILE [ITERATIONS] [SECONDS_BEFORE_ACCEPTING]
# It does not end before a viewer came. At SIGTERM or after its iterations it writes what happened as JSON to LOG_FILE.
import json
import os
import signal
import socket
import struct
import sys
import time

speaks_first = sys.argv[1] == "trainer_first"
iterations = int(sys.argv[4]) if len(sys.argv) > 4 else 10**9
delay = float(sys.argv[5]) if len(sys.argv) > 5 else 0
log = {"iteration": 0, "requests": 0, "accepted": 0, "broken": 0}
viewer = None


def end(*_):
    with open(sys.argv[3], "w") as file:
        json.dump(log, file)
    os._exit(0)


def with_length(text):
    return struct.pack("<I", len(text)) + text.encode("ascii")


def read():
    length = int.from_bytes(viewer.recv(4), "little")
    return json.loads(viewer.recv(length).decode("utf-8"))


def answer(request):
    pixels = request["resolution_x"] * request["resolution_y"]
    if pixels:
        viewer.sendall(struct.pack("<I", log["iteration"])[:3] * pixels)
    viewer.sendall(with_length("/data/garden"))
    if speaks_first:
        request["render_mode"]
        viewer.sendall(with_length(json.dumps({"#": 1234, "loss": 0.25})))


signal.signal(signal.SIGTERM, end)
listener = socket.socket()
listener.bind(("127.0.0.1", 0))
listener.listen()
with open(sys.argv[2] + ".part", "w") as file:
    file.write(str(listener.getsockname()[1]))
os.rename(sys.argv[2] + ".part", sys.argv[2])
time.sleep(delay)
listener.settimeout(0)
while log["iteration"] < iterations or not log["accepted"]:
    log["iteration"] += 1
    time.sleep(0.001)
    if viewer is None:
        try:
            viewer, _ = listener.accept()
            viewer.settimeout(None)
            log["accepted"] += 1
            if speaks_first:
                viewer.sendall(with_length(json.dumps(["RGB", "Normal"])))
        except OSError:
            pass
    while viewer is not None:
        try:
            request = read()
            log["requests"] += 1
            answer(request)
            if request["train"] and (log["iteration"] < iterations or not request["keep_alive"]):
                break
        except (OSError, ValueError, KeyError) as error:
            log["broken"] += isinstance(error, KeyError)
            viewer = None
end()
