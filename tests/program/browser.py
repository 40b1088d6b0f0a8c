#!/usr/bin/env python3
"""The site of the documents and a report, opened in a browser (headless Chromium).

    browser.py PROGRAM SOURCE_FOLDER FOLDER
"""
import functools
import http.server
import os
import pathlib
import shutil
import subprocess
import sys
import threading
import time

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from program import Program  # noqa: E402

WAIT = 60  # s, for the index of the search


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def opened():
    options = Options()
    for word in ("--headless=new", "--no-sandbox", "--window-size=1300,900"):
        options.add_argument(word)
    return webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)


def check_pictures(browser, least):
    """Every picture has been decoded."""
    sizes = [browser.execute_script("return arguments[0].naturalWidth", one)
             for one in browser.find_elements(By.TAG_NAME, "img")]
    if len(sizes) < least or not all(sizes):
        raise SystemExit(f"{browser.current_url}: widths of pictures {sizes}")


def check_table(browser):
    """The table is not cut off at its right."""
    cut = browser.execute_script(
        "return Array.from(document.querySelectorAll('.md-typeset__scrollwrap, .decks td'))"
        ".filter(one => one.scrollWidth > one.clientWidth).length")
    if cut:
        raise SystemExit(f"{browser.current_url}: {cut} parts are wider than their place")


def check_log(browser):
    """The document has caused no error."""
    if log := [one for one in browser.get_log("browser") if one["level"] == "SEVERE"]:
        raise SystemExit(f"{browser.current_url}: {log}")


def found_by_search(browser, word):
    browser.find_element(By.CSS_SELECTOR, "input.md-search__input").send_keys(word)
    end = time.monotonic() + WAIT
    while time.monotonic() < end:
        if "match" in browser.find_element(By.CSS_SELECTOR, ".md-search-result__meta").text:
            return [one.text for one in
                    browser.find_elements(By.CSS_SELECTOR, ".md-search-result__title")]
        time.sleep(0.2)
    raise SystemExit(f"the search for {word} does not end")


def check_site(browser, program, source, folder):
    subprocess.run([sys.executable, source / "jobs/site.py", folder / "docs", program.path],
                   check=True)
    handler = functools.partial(Quiet, directory=folder / "docs/site")
    server = http.server.ThreadingHTTPServer(("localhost", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        browser.get(f"http://localhost:{server.server_port}/index.html")
        check_pictures(browser, 2)
        found = found_by_search(browser, "restitution")
        if "inputs/verify/impact.toml" not in found:
            raise SystemExit(f"the search for restitution finds {found}")
        browser.get(f"http://localhost:{server.server_port}/decks/index.html")
        check_pictures(browser, len(list((source / "inputs").rglob("*.toml"))))
        check_table(browser)
        check_log(browser)
    finally:
        server.shutdown()


def check_report(browser, program, source, folder):
    program.done(1, "run", source / "inputs/track/plain.toml", "-o", folder / "plain")
    report = folder / "report.html"
    subprocess.run([sys.executable, source / "postproc", "report", folder / "plain", "-o", report],
                   check=True, env=os.environ)
    browser.get(report.as_uri())
    check_pictures(browser, 2)
    text = browser.find_element(By.TAG_NAME, "body").text
    for words in ("finished", "largest wheel force between the run-ins", "Cost, mean over the"):
        if words not in text:
            raise SystemExit(f"the report lacks {words!r}: {text}")
    check_log(browser)


def main():
    program, source, folder = Program(sys.argv[1]), *(pathlib.Path(one).resolve()
                                                      for one in sys.argv[2:4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    browser = opened()
    try:
        check_site(browser, program, source, folder)
        check_report(browser, program, source, folder)
    finally:
        browser.quit()


if __name__ == "__main__":
    main()
