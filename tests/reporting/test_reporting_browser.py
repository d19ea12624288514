"""The page in a real browser: nothing on the console, sections, sorting, copying, themes, printing."""

import base64
import csv
import io
import os
import shutil
from pathlib import Path

import pytest
import reporting_inputs as made

from sstl_cli.reporting.load import load
from sstl_cli.steps import report

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
support = pytest.importorskip("selenium.webdriver.support.wait")
CHROMIUM, DRIVER = (shutil.which(n) or f"/usr/bin/{n}" for n in ("chromium", "chromedriver"))
FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
ROOT = Path(__file__).parents[2]
THEMES = {"light": "rgb(255, 255, 255)", "dark": "rgb(20, 23, 27)"}

pytestmark = pytest.mark.skipif(
    not (Path(CHROMIUM).exists() and Path(DRIVER).exists()), reason="chromium and chromedriver (Debian packages) are absent"
)


@pytest.fixture(scope="module")
def shots(tmp_path_factory):
    """Where pictures are left to be looked at; a tree that cannot be written keeps none."""
    folder = (ROOT if os.access(ROOT, os.W_OK) else tmp_path_factory.mktemp("shots")) / "build" / "screenshots"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    folder = tmp_path_factory.mktemp("browser")
    page = folder / "report.html"
    page.write_text(report.run(load(made.write_all(folder))).html, encoding="utf-8")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in [*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options, webdriver.ChromeService(DRIVER))
    driver.set_window_size(1100, 1000)
    driver.execute_cdp_cmd("Browser.grantPermissions", {"permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"]})
    driver.get(page.as_uri())
    yield driver
    driver.quit()


def test_console_is_silent_and_nothing_else_is_fetched(browser):
    assert browser.get_log("browser") == []
    requested = [e["message"] for e in browser.get_log("performance") if 'Network.requestWillBeSent"' in e["message"]]
    assert requested and not [m for m in requested if "http://" in m or "https://" in m]
    assert browser.execute_script("return performance.getEntriesByType('resource').length") == 0


def test_every_section_is_shown(browser):
    shown = [s.get_attribute("id") for s in browser.find_elements("css selector", "main > section") if s.is_displayed()]
    assert shown == ["diagnosis", "logs", "theta", "mapping", "compensation", "blind", "effects", "summary", "files"]
    links = [a.get_attribute("href").partition("#")[2] for a in browser.find_elements("css selector", "nav a")]
    assert links == shown
    sizes = browser.execute_script("return [...document.querySelectorAll('svg')].map(s => s.getBoundingClientRect().width)")
    assert len(sizes) > 20 and min(sizes) > 150
    assert browser.execute_script("return document.documentElement.scrollWidth <= window.innerWidth")


def test_hostile_names_are_text(browser):
    assert made.HOSTILE in browser.find_element("id", "logs").text
    assert len(browser.find_elements("tag name", "script")) == 1


def column(browser, table, place):
    script = "return [...arguments[0].tBodies[0].rows].map(r => r.cells[arguments[1]].textContent)"
    return browser.execute_script(script, table, place)


def test_sorting_by_click_and_by_keyboard(browser):
    table = browser.find_element("css selector", "#diagnosis table[aria-label='Where the gap sits']")
    heads = table.find_elements("css selector", "th")
    assert [h.get_attribute("aria-sort") for h in heads] == ["none"] * 5
    before = [float(v) for v in column(browser, table, 3)]
    button = heads[3].find_element("tag name", "button")
    button.click()
    assert [float(v) for v in column(browser, table, 3)] == sorted(before)
    assert heads[3].get_attribute("aria-sort") == "ascending"
    browser.execute_script("arguments[0].focus()", button)
    button.send_keys("\ue007")
    assert [float(v) for v in column(browser, table, 3)] == sorted(before, reverse=True)
    assert heads[3].get_attribute("aria-sort") == "descending"
    heads[2].find_element("tag name", "button").send_keys(" ")
    assert column(browser, table, 2) == sorted(column(browser, table, 2)) and heads[3].get_attribute("aria-sort") == "none"


def test_empty_cells_sort_to_the_end_both_ways(browser):
    table = browser.find_element("css selector", "#theta table")
    names = [h.text.split()[0] for h in table.find_elements("css selector", "th")]
    place = names.index("gamma_r")
    button = table.find_elements("css selector", "th button")[place]
    for _ in range(2):
        button.click()
        assert column(browser, table, place)[-1] == "–"


def test_copy_as_csv_is_exact_and_safe_to_open(browser):
    box = browser.find_element("css selector", "#logs .table")
    box.find_element("css selector", ".copy").click()
    status = box.find_element("css selector", ".said")
    support.WebDriverWait(browser, 5).until(lambda _: status.text)
    assert status.text == "Copied 4 rows."
    text = browser.execute_async_script("navigator.clipboard.readText().then(arguments[0], e => arguments[0](String(e)))")
    rows = list(csv.reader(io.StringIO(text)))
    head, body = rows[0], rows[1:]
    assert head[:2] == ["run", "configuration"] and "lead / mm" in head and len(body) == 4
    by_run = {row[0]: row for row in body}
    # text that a spreadsheet would run as a formula is defused; numbers are not
    assert "'" + made.FORMULA in by_run and made.HOSTILE in by_run
    _, x, _, _ = made.one_run("act", 1.0)
    assert float(by_run[made.HOSTILE][head.index("input to / N")]) == x.max()
    theta = browser.find_element("css selector", "#theta table")
    copied = list(csv.DictReader(io.StringIO(browser.execute_script("return window.sstlCsv(arguments[0])", theta))))
    assert any(row["beta_p / N"].startswith("-0.") for row in copied)
    assert [row["gamma_r"] for row in copied].count("") == 1


@pytest.mark.parametrize("theme", list(THEMES))
def test_themes_with_screenshots(browser, theme, shots):
    feature = {"name": "prefers-color-scheme", "value": theme}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
    assert browser.execute_script("return getComputedStyle(document.documentElement).backgroundColor") == THEMES[theme]
    ink = browser.execute_script("return getComputedStyle(document.querySelector('#logs svg text')).fill")
    assert ink == browser.execute_script("return getComputedStyle(document.documentElement).color")
    size = browser.execute_cdp_cmd("Page.getLayoutMetrics", {})["cssContentSize"]
    clip = {"x": 0, "y": 0, "width": size["width"], "height": min(size["height"], 16000), "scale": 1}
    shot = browser.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip})
    path = shots / f"report-{theme}.png"
    path.write_bytes(base64.b64decode(shot["data"]))
    assert path.stat().st_size > 100_000


def test_prints_light_and_without_controls(browser, shots):
    features = [{"name": "prefers-color-scheme", "value": "dark"}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print", "features": features})
    try:
        style = "return getComputedStyle(document.querySelector(arguments[0]))[arguments[1]]"
        assert browser.execute_script(style, "html", "backgroundColor") == "rgb(255, 255, 255)"
        assert browser.execute_script(style, ".copy", "display") == "none"
        assert browser.execute_script(style, ".scroll", "maxHeight") == "none"
        pdf = base64.b64decode(browser.execute_cdp_cmd("Page.printToPDF", {})["data"])
        assert pdf.startswith(b"%PDF") and pdf.count(b"/Type /Page\n") + pdf.count(b"/Type /Page ") >= 3
        (shots.parent / "report.pdf").write_bytes(pdf)
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": []})


def test_nothing_is_cut_off_on_paper_and_a_narrow_screen_can_be_scrolled(browser):
    cut = "return [...document.querySelectorAll('.scroll,figure')].filter(e => e.scrollWidth > e.clientWidth + 1).map(e => e.ariaLabel || e.className)"
    # A4 in portrait between margins of 1 cm
    metrics = {"width": 718, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
    try:
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        # tables of the class wide get a page in landscape
        assert [name for name in browser.execute_script(cut) if name not in wide_tables(browser)] == []
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {**metrics, "width": 1040})
        assert browser.execute_script(cut) == []
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {**metrics, "width": 420})
        assert browser.execute_script("return document.documentElement.scrollWidth <= window.innerWidth")
        beyond = browser.execute_script(cut)
        assert "Parameters of the candidates, with 95 % intervals" in beyond
        style = "return [...document.querySelectorAll('.scroll')].map(e => getComputedStyle(e)).every(s => s.overflowX === 'auto' && s.backgroundImage.includes('gradient'))"
        assert browser.execute_script(style)
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def wide_tables(browser):
    return browser.execute_script("return [...document.querySelectorAll('.wide .scroll')].map(e => e.ariaLabel)")


def test_the_value_under_the_pointer_and_a_closer_look(browser):
    svg = browser.find_element("css selector", "#logs svg[data-axes]")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", svg)
    # the middle of the axes, in pixels of the page
    script = """
      const svg = arguments[0], axes = JSON.parse(svg.dataset.axes)[0], [l, t, r, b] = axes.box;
      const at = new DOMPoint((l + r) / 2, (t + b) / 2).matrixTransform(svg.getScreenCTM());
      svg.dispatchEvent(new PointerEvent("pointermove", {clientX: at.x, clientY: at.y}));
      return [svg.nextElementSibling.textContent, (axes.x.from + axes.x.to) / 2, (axes.y.from + axes.y.to) / 2]
    """
    text, x, y = browser.execute_script(script, svg)
    found = [float(word) for word in text.replace(",", " ").split() if word.replace(".", "").replace("-", "").isdigit()]
    assert found == [pytest.approx(x, rel=1e-3), pytest.approx(y, rel=1e-3)] and text.count("tension") == 2 and " N" in text

    def box_after(key):
        press = "if (arguments[1]) arguments[0].dispatchEvent(new KeyboardEvent('keydown', {key: arguments[1]}));"
        return [float(v) for v in browser.execute_script(press + "return arguments[0].getAttribute('viewBox')", svg, key).split()]

    whole = box_after(None)
    assert box_after("+")[2] == pytest.approx(0.75 * whole[2])
    assert box_after("ArrowRight")[0] > 0.125 * whole[2]
    assert box_after("0") == pytest.approx(whole)
    assert browser.get_log("browser") == []
