"""`bipot run --watch` with an ordinary HTTP client: watch_test.py BIPOT FOLDER."""

import base64
import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
import zlib

BIPOT, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])


def run(name, *flags):
    return [BIPOT, "run", "drum", "--quiet", "--out", FOLDER / name, *flags]


def watch(name, *flags):
    """A run that is served, and its address."""
    started = subprocess.Popen(run(name, "--watch", "--port", "0", *flags), stderr=subprocess.PIPE, text=True)
    return started, re.search(r"http://127\.0\.0\.1:\d+/", started.stderr.readline())[0]


def get(address, **headers):
    with urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=60) as answer:
        return answer.read().decode()


def status(address, **headers):
    try:
        get(address, **headers)
        return 200
    except urllib.error.HTTPError as refusal:
        return refusal.code


def check_answers():
    started, address = watch("long", "--steps", "100000")
    page = get(address)
    assert '"live":true' in page and "connect-src 'self'" in page
    first = json.loads(get(address + "update?after=-1"))
    assert first["steps"][0] == 0 and len(first["frames"]) == len(first["steps"]) and not first["ended"]
    assert zlib.decompress(base64.b64decode(first["frame_data"]))
    last = first["steps"][-1]
    more = json.loads(get(f"{address}update?after={last}"))
    assert all(frame[0] > last for frame in more["frames"]) and more["summary"] is None
    assert more["curves"][0]["file"] == "ledger" and more["curves"][0]["all_rows"] > last

    assert status(address + "else") == 404
    assert status(address, Host="elsewhere.example") == 403  # a name that points at this machine

    port = address.rstrip("/").rsplit(":", 1)[1]
    busy = subprocess.run(run("busy", "--watch", "--port", port, "--steps", "5"), capture_output=True, text=True)
    assert busy.returncode == 2 and f"--port {port} is in use" in busy.stderr, busy
    assert not (FOLDER / "busy").exists()

    began = time.time()
    started.send_signal(signal.SIGINT)
    end = json.loads(get(f"{address}update?after={last}"))
    assert end["ended"] and end["summary"]["status"] == "interrupted"
    assert end["steps"][-1] == end["summary"]["last_step"]
    assert started.wait(60) == 5
    print(f"Ctrl-C ended the run in {time.time() - began:.2f} s")
    try:
        get(address)
        raise AssertionError("the server still answers")
    except urllib.error.URLError:
        pass


def check_same_bits():
    subprocess.run(run("alone", "--steps", "40", "--no-page"), check=True)
    started, address = watch("served", "--steps", "40")
    try:
        while not json.loads(get(address + "update?after=-1"))["ended"]:
            pass
    except (urllib.error.URLError, ConnectionError):
        pass  # the run may end before the question
    assert started.wait(60) == 0
    for name in ("ledger.csv", "walls.csv"):
        assert (FOLDER / "alone" / name).read_bytes() == (FOLDER / "served" / name).read_bytes(), name


def check_refusals():
    for flags, words in ((["--watch", "--no-page"], "give one"), (["--port", "80"], "--port goes with --watch")):
        refused = subprocess.run(run("refused", *flags), capture_output=True, text=True)
        assert refused.returncode == 2 and words in refused.stderr, refused


shutil.rmtree(FOLDER, ignore_errors=True)
FOLDER.mkdir(parents=True)
refused = subprocess.run(run("none", "--watch", "--port", "0", "--steps", "1"), capture_output=True, text=True)
if "built without cpp-httplib" in refused.stderr:
    print("cpp-httplib is not installed: --watch is not tested")
    sys.exit(0)
check_answers()
check_same_bits()
check_refusals()
