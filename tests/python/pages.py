"""Pages of reports in Chromium, over its DevTools protocol: charts drawn, no error, nothing loaded; pictures and PDFs.

    python pages.py CHROMIUM FOLDER NAME=PAGE …

writes FOLDER/NAME-WIDTH.png and FOLDER/NAME.pdf, prints a line for each, and exits with status 1 if a page is not as it should be.
Needs websocket-client.
"""

import base64
import json
import pathlib
import subprocess
import sys
import tempfile
import time
import urllib.request

import websocket

WIDTHS = [1200, 600]
HEIGHT = 900
# Seconds that the browser may take to start, and to answer.
START = 60
ANSWER = 120
# Seconds of silence after which a page has nothing more to say.
SILENCE = 0.5

# A chart is drawn if its canvas has ink besides its background, and of each line its colour: see page.js.
LOOK = """(() => {
  const places = [...document.querySelectorAll("[data-chart]")];
  const data = document.getElementById("data") ? JSON.parse(document.getElementById("data").textContent) : { charts: [] };
  const blank = [], uncoloured = [];
  const colours = [[0xd5, 0x5e, 0x00], [0x00, 0x72, 0xb2]];
  for (const place of places) {
    const chart = data.charts[+place.dataset.chart], canvas = place.querySelector("canvas");
    if (!canvas || !canvas.width || !canvas.height) { blank.push(chart.title); continue; }
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let ink = 0;
    for (let i = 3; i < pixels.length; i += 4) ink += pixels[i] > 0;
    if (ink < 200) { blank.push(chart.title); continue; }
    const near = ([r, g, b]) => {
      for (let i = 0; i < pixels.length; i += 4)
        if (pixels[i + 3] > 200 && Math.abs(pixels[i] - r) < 40 && Math.abs(pixels[i + 1] - g) < 40 && Math.abs(pixels[i + 2] - b) < 40) return true;
      return false;
    };
    // Lines of later colours may lie over earlier ones: the last one is looked for.
    const last = chart.beside ? (chart.beside.series.length ? 1 : 0) : chart.series.length - 1;
    if (last < colours.length && !near(colours[last])) uncoloured.push(chart.title);
  }
  const pictures = [...document.querySelectorAll("figure > svg")];
  const flat = pictures.filter(svg => svg.getBoundingClientRect().height < 20 || svg.querySelectorAll("path,polyline,polygon,rect,circle,line").length < 3);
  return { charts: places.length, blank, uncoloured, pictures: pictures.length, flat: flat.length,
    wide: document.documentElement.scrollWidth, tall: document.documentElement.scrollHeight };
})()"""

# Where the middle of the first chart over time is; none without one.
PLACE = """(() => {
  const over = document.querySelector("[data-chart] .u-over");
  if (!over) return null;
  over.scrollIntoView({ block: "center" });
  const box = over.getBoundingClientRect();
  return { x: box.left + box.width / 2, y: box.top + box.height / 2 };
})()"""

# What the legend of the first chart says below the cursor.
LEGEND = """[...document.querySelector("[data-chart]").querySelectorAll(".u-series .u-value")].map(value => value.textContent)"""

# Whether the dam in motion is drawn, moves with the slide and while it plays; none without one.
MOTION = """(async () => {
  const place = document.getElementById("dam-in-motion");
  if (!place) return null;
  const canvas = place.querySelector("canvas"), slide = place.querySelector(".instant"), play = place.querySelector(".play");
  const picture = () => canvas.toDataURL();
  const ink = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.filter((value, i) => i % 4 === 3 && value > 0).length;
  const first = picture(), began = slide.value;
  slide.value = slide.min;
  slide.dispatchEvent(new Event("input"));
  const still = picture();
  slide.value = began;
  slide.dispatchEvent(new Event("input"));
  const again = picture();
  play.click();
  await new Promise(done => setTimeout(done, 300));
  play.click();
  const played = Number(slide.value) > Number(began) && picture() !== first;
  return { drawn: ink > 0.2 * canvas.width * canvas.height, moves: still !== first && again === first, played };
})()"""

# Where in the run, from 0 to 1, the dam is shown; none without one.
INSTANT = """(() => {
  const slide = document.querySelector("#dam-in-motion .instant");
  return slide && (slide.value - slide.min) / (slide.max - slide.min);
})()"""

# Sorts the table by its last column of numbers in both ways; whether the rows follow, none without such a table.
SORT = """(() => {
  const table = document.querySelector("table.sortable");
  if (!table) return null;
  const column = [...table.tHead.rows[0].cells].findLastIndex(cell => cell.classList.contains("number"));
  const button = table.tHead.rows[0].cells[column].querySelector("button");
  const values = () => [...table.tBodies[0].rows].map(row => row.cells[column].querySelector("data")).filter(data => data).map(data => Number(data.value));
  const before = table.tBodies[0].rows.length;
  const ascend = values => values.every((value, i) => i === 0 || values[i - 1] <= value);
  button.click();
  const up = ascend(values());
  button.click();
  return up && ascend(values().reverse()) && table.tBodies[0].rows.length === before;
})()"""


class Browser:
    """A headless Chromium with one tab."""

    def __init__(self, program):
        self.folder = tempfile.TemporaryDirectory()
        options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--remote-debugging-port=0", "--remote-allow-origins=*"]
        options += ["--no-first-run", "--disable-background-networking", f"--user-data-dir={self.folder.name}", "about:blank"]
        self.process = subprocess.Popen([program, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.number = 0
        self.events = []
        self.socket = websocket.create_connection(self.address(), timeout=ANSWER)
        for domain in ["Page", "Runtime", "Log", "Network"]:
            self.ask(f"{domain}.enable")

    def address(self):
        """Of the tab, once the browser listens."""
        port, begun = pathlib.Path(self.folder.name, "DevToolsActivePort"), time.monotonic()
        while time.monotonic() < begun + START:
            if self.process.poll() is not None:
                sys.exit(f"the browser ended with status {self.process.returncode}")
            try:
                number = port.read_text().splitlines()[0]
                with urllib.request.urlopen(f"http://127.0.0.1:{number}/json/list", timeout=5) as answer:
                    tabs = [tab for tab in json.load(answer) if tab["type"] == "page"]
                if tabs:
                    return tabs[0]["webSocketDebuggerUrl"]
            except (OSError, IndexError, ValueError):
                pass
            time.sleep(0.1)
        sys.exit(f"the browser does not listen after {START} s")

    def ask(self, method, **parameters):
        """The result of a method; events that come before it are kept."""
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self.socket.recv())
            if message.get("id") == self.number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']['message']}")
                return message["result"]
            self.events.append(message)

    def listen(self, wanted=None, seconds=SILENCE):
        """Keeps events until one is `wanted`, or there is silence for some seconds."""
        self.socket.settimeout(ANSWER if wanted else seconds)
        try:
            while True:
                message = json.loads(self.socket.recv())
                self.events.append(message)
                if message.get("method") == wanted:
                    return
        except websocket.WebSocketTimeoutException:
            if wanted:
                raise RuntimeError(f"no {wanted} after {ANSWER} s") from None
        finally:
            self.socket.settimeout(ANSWER)

    def evaluate(self, expression):
        """The value of an expression in the page."""
        result = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"]["exception"].get("description", "it failed"))
        return result["result"].get("value")

    def close(self):
        self.socket.close()
        self.process.terminate()
        self.process.wait(timeout=ANSWER)
        self.folder.cleanup()


def told(events, page):
    """Errors of the page, and what it asked for besides itself."""
    errors, requests = [], []
    for event in events:
        method, about = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = about["exceptionDetails"]
            errors.append(details.get("exception", {}).get("description", details["text"]).splitlines()[0])
        elif method == "Runtime.consoleAPICalled" and about["type"] in ("error", "warning", "assert"):
            errors.append(" ".join(str(part.get("value", part.get("description"))) for part in about["args"]))
        elif method == "Log.entryAdded" and about["entry"]["level"] in ("error", "warning"):
            errors.append(about["entry"]["text"])
        elif method == "Network.requestWillBeSent" and about["request"]["url"].split("#")[0] != page:
            requests.append(about["request"]["url"][:200])
    return errors, requests


def problems_of(browser, page, width, name, folder):
    """What is wrong with a page at a width, and a line about it."""
    browser.events.clear()
    browser.ask("Emulation.setDeviceMetricsOverride", width=width, height=HEIGHT, deviceScaleFactor=1, mobile=False)
    browser.ask("Page.navigate", url=page)
    browser.listen("Page.loadEventFired")
    browser.listen()
    found, problems, said = browser.evaluate(LOOK), [], []
    if found["charts"] + found["pictures"] == 0:
        problems.append("it has neither charts nor pictures")
    if found["blank"]:
        problems.append(f"{len(found['blank'])} charts are not drawn: {', '.join(found['blank'][:3])}")
    if found["uncoloured"]:
        problems.append(f"{len(found['uncoloured'])} charts lack a line: {', '.join(found['uncoloured'][:3])}")
    if found["flat"]:
        problems.append(f"{found['flat']} pictures are empty")
    if found["wide"] > width:
        problems.append(f"it is {found['wide']} px wide and has to be moved sideways")
    if at := browser.evaluate(PLACE):
        browser.ask("Input.dispatchMouseEvent", type="mouseMoved", **at)
        browser.listen()
        legend = browser.evaluate(LEGEND)
        said.append("cursor: " + " | ".join(legend))
        if not legend or not all(legend):
            problems.append(f"the cursor in a chart shows {legend}")
        for kind in ["mousePressed", "mouseReleased"]:
            browser.ask("Input.dispatchMouseEvent", type=kind, button="left", clickCount=1, **at)
        browser.listen()
        if (instant := browser.evaluate(INSTANT)) is not None and abs(instant - 0.5) > 0.02:
            problems.append(f"a click in the middle of a chart leads to {instant:.2f} of the run")
    shot = browser.ask("Page.captureScreenshot", format="png", captureBeyondViewport=True)
    (folder / f"{name}-{width}.png").write_bytes(base64.b64decode(shot["data"]))
    if width == WIDTHS[0]:
        # A4.
        pdf = browser.ask("Page.printToPDF", printBackground=True, preferCSSPageSize=True, paperWidth=8.27, paperHeight=11.69)
        pdf = base64.b64decode(pdf["data"])
        (folder / f"{name}.pdf").write_bytes(pdf)
        pages = pdf.count(b"/Type /Page\n")
        said.append(f"PDF of {pages} pages, {len(pdf) / 1e6:.1f} MB")
        if not pdf.startswith(b"%PDF") or pages == 0:
            problems.append("it does not print")
    if (motion := browser.evaluate(MOTION)) is not None:
        said.append("the dam moves")
        problems += [f"the dam in motion: {what} is not true" for what, so in motion.items() if not so]
    if (sorts := browser.evaluate(SORT)) is not None:
        said.append("the table sorts")
        if not sorts:
            problems.append("the table of all runs does not sort")
    browser.listen()
    errors, requests = told(browser.events, page)
    problems += [f"error: {error}" for error in errors] + [f"request: {request}" for request in requests]
    content = f"{found['charts']} charts, {found['pictures']} pictures, {found['tall']} px high"
    return problems, ", ".join([content, *said])


def main():
    program, folder, *pages = sys.argv[1:]
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    browser, failed = Browser(program), False
    try:
        for name, path in (page.split("=", 1) for page in pages):
            page = pathlib.Path(path).resolve().as_uri()
            for width in WIDTHS:
                problems, line = problems_of(browser, page, width, name, folder)
                failed |= bool(problems)
                print(f"{name}, {width} px: {line}; {'FAILED' if problems else 'no error, nothing loaded'}")
                for problem in problems:
                    print(f"  {problem}")
    finally:
        browser.close()
    sys.exit(failed)


if __name__ == "__main__":
    main()
