# SPDX-License-Identifier: BSD-2-Clause
"""Chromium for the tests of pages, and what is asked of each of them."""
import os

from selenium import webdriver
from selenium.common.exceptions import SessionNotCreatedException
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

PATIENCE = 60  # s, on a machine that is busy


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


# Names of what can be operated, contrast of texts, and nothing that is wider than the page.
CHECKS = """
const wrong = [];
const luminance = (c) => { const f = c.map((v) => { v /= 255; return v <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4; });
  return .2126 * f[0] + .7152 * f[1] + .0722 * f[2]; };
const numbers = (c) => (c.match(/[\\d.]+/g) || []).map(Number);
const ground = (e) => { for (; e; e = e.parentElement) { const c = numbers(getComputedStyle(e).backgroundColor); if (c.length === 3 || c[3] === 1) return c.slice(0, 3); } return [255, 255, 255]; };
for (const e of document.querySelectorAll("button, input, select, [role=button], [role=tab], [role=grid], [role=tabpanel], svg[role], aside:not([hidden])")) {
  const name = e.getAttribute("aria-label") || e.textContent.trim() || e.closest("label")?.textContent.trim() || document.getElementById(e.getAttribute("aria-labelledby"))?.textContent;
  if (!name) wrong.push("no name: " + e.outerHTML.slice(0, 100));
}
for (const e of document.querySelectorAll("[aria-controls], [aria-labelledby]"))
  for (const a of ["aria-controls", "aria-labelledby"]) if (e.hasAttribute(a) && e.checkVisibility() && e.getAttribute(a).split(" ").some((id) => !document.getElementById(id))) wrong.push(a + " of " + e.id + " leads nowhere");
for (const e of document.querySelectorAll("body *")) {
  if (e.closest("svg") || !e.checkVisibility() || ![...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim())) continue;
  const [a, b] = [luminance(numbers(getComputedStyle(e).color).slice(0, 3)), luminance(ground(e))].sort((x, y) => y - x);
  if ((a + .05) / (b + .05) < 4.5) wrong.push("contrast " + ((a + .05) / (b + .05)).toFixed(2) + ": " + e.textContent.slice(0, 40));
}
if (document.documentElement.scrollWidth > innerWidth) wrong.push("wider than the page: " + document.documentElement.scrollWidth);
return [...new Set(wrong)];
"""


def examine(driver, state):
    wrong = driver.execute_script(CHECKS)
    if os.environ.get("AXE"):
        with open(os.environ["AXE"], encoding="utf-8") as file:
            driver.execute_script(file.read())
        found = driver.execute_async_script("axe.run().then((r) => arguments[0](r.violations.map((v) => v.id + ': ' + v.nodes.map((n) => n.html.slice(0, 120)).slice(0, 3).join(' | '))))")
        wrong += [f"axe {one}" for one in found]
    assert not wrong, f"{state}: " + "\n".join(wrong)


def look(driver, pictures, name):
    if pictures:
        driver.save_screenshot(f"{pictures}/{name}.png")


def text(driver, selector):
    return driver.find_element(By.CSS_SELECTOR, selector).text
