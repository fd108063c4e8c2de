# SPDX-License-Identifier: BSD-2-Clause
"""Chromium for the tests of pages, and what is asked of each of them."""
import os

from selenium import webdriver
from selenium.common.exceptions import SessionNotCreatedException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

PATIENCE = 60  # s, on a machine that is busy
with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "rules.js"), encoding="utf-8") as rules:
    RULES = rules.read()


def chromium(width, height, dark, folder):
    """chromedriver gives it a minute, which a busy machine may need."""
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--force-device-scale-factor=1",
                 f"--window-size={width},{height}", f"--user-data-dir={folder}/chromium-{width}-{dark}"):
        options.add_argument(word)
    for last in (False, True):
        try:
            driver = webdriver.Chrome(service=webdriver.chrome.service.Service("/usr/bin/chromedriver"), options=options)
            break
        except SessionNotCreatedException:
            if last:
                raise
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                           {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
    return driver


def wait(driver, script, *arguments):
    try:
        return WebDriverWait(driver, PATIENCE).until(lambda d: d.execute_script(script, *arguments))
    except Exception:
        print(driver.execute_script("return document.body.innerText")[:2000], driver.get_log("browser"))
        raise


# What has no name says nothing to who does not see it.
NAMED = {"button", "checkbox", "combobox", "complementary", "dialog", "grid", "image", "img", "link", "meter", "region", "searchbox", "tab", "table", "tablist",
         "tabpanel", "textbox"}
NOTHING = {"generic", "none", "presentation", "GenericContainer"}


def names(driver):
    """What the browser hands to a screen reader: names of what is operated, and a role for whatever has the focus."""
    wrong = []
    for node in driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]:
        role, name = node.get("role", {}).get("value"), node.get("name", {}).get("value", "").strip()
        has = {one["name"]: one["value"].get("value") for one in node.get("properties", [])}
        if node["ignored"]:
            continue
        if role in NAMED and not any(c.isalnum() for c in name):
            wrong.append(f"no name: {role} {node.get('backendDOMNodeId')} '{name}' {has}")
        if has.get("focusable") and role in NOTHING:
            wrong.append(f"no role, though it can have the focus: {name or node.get('backendDOMNodeId')}")
    return wrong


# Where Tab can lead: in a dialog that is open nowhere else. An order that differs from that of the document, and a focus that is not seen, are faults.
TABBED = """
const shown = (e) => e.checkVisibility({ checkVisibilityCSS: true });
const within = document.querySelector("dialog[open]") ?? document;
return [...within.querySelectorAll("a[href], button, input, select, textarea, summary, [tabindex]")].filter((e) => e.tabIndex >= 0 && !e.disabled && shown(e)).length;
"""
FOCUSED = """
const e = document.activeElement, wrong = [];
if (!e || e === document.body || e === document.documentElement) return null;
const style = getComputedStyle(e), box = e.getBoundingClientRect(), text = e.outerHTML.slice(0, 110);
const edge = e.querySelector(":scope > rect"); // in a drawing
const ringed = style.outlineStyle !== "none" ? parseFloat(style.outlineWidth) : edge ? parseFloat(getComputedStyle(edge).strokeWidth) : 0;
if (ringed < 2) wrong.push(`the focus is not seen: ${text}`);
if (box.bottom < 0 || box.top > innerHeight || !box.width) wrong.push(`the focus is out of sight: ${text}`);
const before = window.tabbed;
if (before?.isConnected && before.compareDocumentPosition(e) & Node.DOCUMENT_POSITION_PRECEDING) wrong.push(`the focus goes back: ${text}`);
window.tabbed = e;
return wrong;
"""


def by_tab(driver, state):
    """From part to part by Tab alone: each of them once, in the order of the page, and seen."""
    driver.execute_script("const all = document.querySelector('dialog[open]') ?? document.body; window.tabbed = null; all.tabIndex = -1; all.focus(); all.removeAttribute('tabindex');")
    expected, came, wrong = driver.execute_script(TABBED), 0, []
    while came <= expected + 2:
        ActionChains(driver).send_keys(Keys.TAB).perform()
        said = driver.execute_script(FOCUSED)
        if said is None:
            break
        came += 1
        wrong += said
    if came != expected:
        wrong.append(f"Tab comes to {came} of {expected}")
    assert not wrong, f"{state}, by Tab: " + "\n".join(wrong)


def examine(driver, state):
    wrong = driver.execute_script(RULES) + names(driver)
    if os.environ.get("AXE"):
        with open(os.environ["AXE"], encoding="utf-8") as file:
            driver.execute_script(file.read())
        found = driver.execute_async_script("axe.run().then((r) => arguments[0](r.violations.map((v) => v.id + ': ' + v.nodes.map((n) => n.html.slice(0, 120)).slice(0, 3).join(' | '))))")
        wrong += [f"axe {one}" for one in found]
    assert not wrong, f"{state}: " + "\n".join(wrong)


def take_picture(driver, pictures, name):
    if pictures:
        driver.save_screenshot(f"{pictures}/{name}.png")


def text(driver, selector):
    return driver.find_element(By.CSS_SELECTOR, selector).text
