"""The page of a run in a real browser: browser_test.py BIPOT FRAME_JSON FOLDER.

Runs shipped scenes into FOLDER, opens their pages in headless Chromium, and compares what they show
with the HDF5 files. Screenshots stay in FOLDER."""

import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import chromium

BIPOT, FRAME_JSON, FOLDER = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
SCENES = {"drum": 200, "hopper": 300, "plane_shear": 200, "pipe": 300}
PRECISION = 6e-3  # half a unit of the third digit of 1.00, and 0.11 % of the 16-bit numbers
FAULTS = []


def expect(condition, what):
    print(("ok    " if condition else "FAULT ") + what)
    if not condition:
        FAULTS.append(what)


def number(text):
    """The first number of a text that textOf() wrote; its powers of ten are superscripts."""
    found = re.search(r"([-−]?[\d.]+)(?:·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?", text)
    power = (found[2] or "").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    return float(found[1].replace("−", "-")) * 10 ** int(power or 0)


def close(shown, true):
    return abs(shown - true) <= PRECISION * abs(true) + 1e-12


def tip(page):
    """Rows of the tip: its title and {name: text}."""
    lines = page.value("[...document.querySelectorAll('#tip > *')].map(e => e.textContent)")
    if page.value("document.getElementById('tip').hidden") or not lines:
        return None, {}
    names = ["radius", "mass", "speed", "spin", "contacts", "contact force", "gap", "normal force",
             "tangential", "ratio", "status"]
    rows = {}
    for line in lines[1:]:
        name = max((n for n in names if line.startswith(n + " ")), key=len, default=None)
        if name:
            rows[name] = line[len(name) + 1:]
    return lines[0], rows


ON_SCREEN = """(absolute => {
  const x = absolute.map((part, c) => part - bipotPlayer.run.about.origin[c]);
  const view = bipotPlayer.view, box = document.getElementById('stage').getBoundingClientRect();
  let place;
  if (bipotPlayer.run.dim === 2) place = view.toScreen(...x);
  else {
    const c = view.camera(), to = sub3(x, c.eye), {width, height} = view.size();
    const deep = -dot3(to, c.from);
    place = [width / 2 + dot3(to, c.right) / deep / c.t * height / 2,
      height / 2 - dot3(to, c.above) / deep / c.t * height / 2];
  }
  return [box.left + 1 + place[0], box.top + 1 + place[1]];
})"""


def check_bodies(page, name, frame):
    """Hovers over bodies; what the tip says is in the file."""
    seen = 0
    for k in range(0, len(frame["bodies"]), max(1, len(frame["bodies"]) // 12)):
        x, y = page.value(f"{ON_SCREEN}({json.dumps(frame['bodies'][k]['x'])})")
        page.mouse("mouseMoved", x, y)
        title, rows = tip(page)
        if not title or not re.match(r"(Disk|Sphere) \d+", title):
            continue
        body = next(b for b in frame["bodies"] if b["number"] == int(title.split()[1]))
        good = close(number(rows["radius"]), body["radius"]) and close(number(rows["speed"]), body["speed"])
        contacts = sum(body["number"] == c["i"] or (body["number"] == c["j"] and not c["wall"]) for c in frame.get("contacts") or [])
        good = good and number(rows["contacts"]) == contacts
        seen += 1
        if not good:
            expect(False, f"{name}: {title} shows {rows}, the file has {body}, {contacts} contacts")
            return
    expect(seen >= 4, f"{name}: radius, speed and contacts of {seen} bodies are those of the HDF5 file")


def check_contacts(page, name, frame):
    """Hovers over the strongest contacts of disks."""
    seen, strongest = 0, sorted(frame["contacts"], key=lambda c: -c["force_n"])[:8]
    for c in strongest:
        body = next(b for b in frame["bodies"] if b["number"] == c["i"])
        point = [p - body["radius"] * n for p, n in zip(body["x"], c["n"])]
        x, y = page.value(f"{ON_SCREEN}({json.dumps(point)})")
        page.mouse("mouseMoved", x, y)
        title, rows = tip(page)
        if not title or not title.startswith("Contact"):
            continue
        if not title.startswith(f"Contact {c['i']} – " + ("wall" if c["wall"] else str(c["j"]))):
            continue
        seen += 1
        status = ["opens", "sticks", "slips"][c["status"]]
        if not (close(number(rows["normal force"]), c["force_n"]) and rows["status"] == status
                and close(abs(number(rows["tangential"])), c["force_t"])):
            expect(False, f"{name}: {title} shows {rows}, the file has {c}")
            return
    expect(seen >= 3, f"{name}: forces and status of {seen} contacts are those of the HDF5 file")


def scrub_to(page, step):
    """Moves the slider as a reader does, to the frame of this step."""
    page.value(f"""(() => {{ const s = document.getElementById('scrub');
      s.value = bipotPlayer.run.frames.findIndex(f => f.step === {step});
      s.dispatchEvent(new Event('input')); }})()""")
    page.frames_drawn()


def check_page(page, name, steps):
    run = FOLDER / name
    for width, height in ((1280, 900), (390, 844)):
        for dark in (False, True):
            where = f"{name} {width}{' dark' if dark else ''}"
            page.show(width, height, dark)
            page.open(run / "index.html")
            page.wait("window.bipotPlayer !== undefined")
            page.frames_drawn()
            expect(page.value("document.documentElement.dataset.theme") == ("dark" if dark else "light"),
                   f"{where}: the theme of the reader")
            expect(page.value("document.documentElement.scrollWidth") <= width, f"{where}: nothing is too wide")
            expect(page.value("[...document.querySelectorAll('pre')].every(p => p.scrollWidth <= p.clientWidth)"),
                   f"{where}: no command is cut")
            page.screenshot(FOLDER / f"{name}_{width}{'_dark' if dark else ''}.png", whole=True)
    page.show(1280, 900, False)
    page.open(run / "index.html")
    page.wait("window.bipotPlayer !== undefined")
    last = json.loads(subprocess.check_output([FRAME_JSON, run, str(steps)]))
    expect(page.value("bipotPlayer.frame.step") == steps, f"{name}: opens with the last step")
    check_bodies(page, name, last)
    if page.value("bipotPlayer.run.dim") == 2 and not page.value("Boolean(bipotPlayer.frame.cell)"):
        check_contacts(page, name, last)
    middle = steps // 2
    scrub_to(page, middle)
    expect(page.value("bipotPlayer.frame.step") == middle
           and f"step {middle} " in page.value("document.getElementById('clock').textContent"),
           f"{name}: scrubbing to step {middle} shows that frame")
    heads = page.value("[...document.querySelectorAll('#curves h2, .plot h3')].map(h => h.textContent)")
    expect(heads[0].endswith("[s]"), f"{name}: the time axis has its unit")
    expect([h for h in heads if re.fullmatch(r"Contacts(contacts|with a force|[ …\d])+", h)],
           f"{name}: contacts are counted in whole numbers {heads}")
    x, y = page.value("(b => [b.left + b.width / 2, b.top + 5])(document.getElementById('stage').getBoundingClientRect())")
    page.key("Home")
    expect(page.value("bipotPlayer.at") == 0, f"{name}: Home shows the first frame")
    page.key("ArrowRight")
    expect(page.value("bipotPlayer.at") == 1, f"{name}: the arrow steps")
    page.key(" ")
    page.wait("bipotPlayer.at > 3", 20)
    page.key(" ")
    at = page.value("bipotPlayer.at")
    page.frames_drawn(10)
    expect(page.value("bipotPlayer.at") == at, f"{name}: plays, and pauses at frame {at}")
    before = page.value("bipotPlayer.view.lengthScale()")
    page.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y + 200, deltaX=0, deltaY=-200)
    page.frames_drawn()
    expect(page.value("bipotPlayer.view.lengthScale()") > before, f"{name}: the wheel zooms")
    page.key("f")
    page.key("End")
    time = page.value(f"bipotPlayer.run.frames.find(f => f.step === {middle}).time")
    page.open(run / "index.html", f"#t={time:.7g}")
    page.wait("window.bipotPlayer !== undefined")
    expect(page.value("bipotPlayer.frame.step") == middle, f"{name}: a link opens its moment")
    bars = "[...document.querySelectorAll('.plot .now')].map(bar => bar.style.transform)"
    before = page.value(bars)
    page.value("document.getElementById('theme').click()")
    page.frames_drawn()
    expect(before and page.value(bars) == before, f"{name}: the bars of time stay in another theme")
    expect(not page.errors, f"{name}: the console is silent {page.errors[:3] or ''}")


def check_small_stages(page, name):
    """Stages as narrow as in a window opened behind others, which gets its size later."""
    page.show(1280, 900, False)
    page.open(FOLDER / name / "index.html")
    page.wait("window.bipotPlayer !== undefined")
    page.frames_drawn()
    shown = page.value("bipotPlayer.view.lengthScale()")
    for width in ("2px", "42px", ""):
        page.value(f"document.getElementById('stage').style.width = '{width}'")
        page.frames_drawn()
        page.value("document.getElementById('fit').click()")
        page.frames_drawn()
        scale = page.value("bipotPlayer.view.lengthScale()")
        if width == "42px":
            expect(0 < scale < shown, f"{name}: a narrow stage has a small scale")
    expect(scale == shown, f"{name}: the old size brings back the old scale")
    expect(not page.errors, f"{name}: small stages draw without errors {page.errors[:1] or ''}")


PRINTED = """(() => {
  window.dispatchEvent(new Event('beforeprint'));
  const view = document.getElementById('view'), copy = document.createElement('canvas');
  [copy.width, copy.height] = [view.width, view.height];
  const pen = copy.getContext('2d');
  pen.drawImage(view, 0, 0);
  const pixels = new Uint32Array(pen.getImageData(0, 0, copy.width, copy.height).data.buffer);
  const theme = document.documentElement.dataset.theme;
  window.dispatchEvent(new Event('afterprint'));
  return [theme, view.offsetHeight, new Set(pixels).size, document.documentElement.dataset.theme];
})()"""


def check_paper(page, name):
    """A page on paper has the picture as well, in light colours."""
    page.show(1280, 900, True)
    page.open(FOLDER / name / "index.html")
    page.wait("window.bipotPlayer !== undefined")
    page.frames_drawn()
    page.call("Emulation.setEmulatedMedia", media="print")
    theme, height, colours, later = page.value(PRINTED)
    page.call("Emulation.setEmulatedMedia", media="")
    expect(theme == "light" and later == "dark" and height > 200 and colours > 20,
           f"{name}: paper shows the picture {theme} {height} {colours} {later}")


def check_watched_run(page):
    """A page of a run that goes on gets its frames without a reload, and learns of the end."""
    run = subprocess.Popen([BIPOT, "run", "drum", "--steps", "100000", "--watch", "--port", "0", "--quiet",
                            "--out", FOLDER / "watched"], stderr=subprocess.PIPE, text=True)
    line = run.stderr.readline()
    if "built without cpp-httplib" in line:
        print("cpp-httplib is not installed: --watch is not tested")
        return
    address = re.search(r"http://127\.0\.0\.1:\d+/", line)[0]
    page.own += (address,)
    page.show(1280, 900, False)
    page.open_address(address)
    page.wait("window.bipotPlayer !== undefined")
    page.value("window.sameDocument = true")
    last = "bipotPlayer.run.frames.at(-1).step"
    first = page.value(last)
    page.wait(f"{last} > {first} + 20")
    expect(page.value("window.sameDocument && bipotPlayer.at === bipotPlayer.run.frames.length - 1"),
           f"watched: frames after step {first} arrive without a reload, and the last is shown")
    expect(page.value("bipotPlayer.curves.charts.every(c => !c.plot || c.plot.data[0].length > 20)"),
           "watched: the curves grow")
    expect("running" in page.value("document.getElementById('status').textContent"), "watched: the head says so")
    page.key("Home")
    step = page.value(last)
    page.wait(f"{last} > {step}")
    expect(page.value("bipotPlayer.at") == 0, "watched: a reader who looks at the beginning stays there")
    page.screenshot(FOLDER / "watched.png", whole=True)
    began = time.time()
    run.send_signal(signal.SIGINT)
    run.wait(60)
    took = time.time() - began
    page.wait("!bipotPlayer.run.about.live")
    head = page.value("document.getElementById('status').textContent")
    expect("interrupted" in head, f"watched: the page learns of the end: {head}")
    frame = page.value(last)
    expect(frame == json.loads((FOLDER / "watched" / "summary.json").read_text())["last_step"],
           "watched: and has the last frame")
    print(f"      Ctrl-C ended the run in {took:.2f} s")
    expect(not page.errors, f"watched: the console is silent {page.errors[:3] or ''}")


def main():
    if not chromium.find():
        print("Chromium is not installed: pages are not tested in a browser")
        return 0
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    page = chromium.Page()
    try:
        for name, steps in SCENES.items():
            subprocess.run([BIPOT, "run", name, "--steps", str(steps), "--out", FOLDER / name, "--quiet"], check=False)
            check_page(page, name, steps)
            check_small_stages(page, name)
            check_paper(page, name)
        check_watched_run(page)
    finally:
        page.close()
    print(f"{len(FAULTS)} faults")
    return 1 if FAULTS else 0


sys.exit(main())
