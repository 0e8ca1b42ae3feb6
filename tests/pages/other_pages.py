"""The pages of the other programs in a headless Chromium: no error, no request, light and dark, whole on a phone.

usage: other_pages.py APPS SOURCE WORK [PICTURES]
Ends with 77, which ctest shows as skipped, where there is no Chromium.
"""

import pathlib
import shutil
import subprocess
import sys

import chromium

failures = []


def check(right, text):
    if not right:
        failures.append(text)
        print("FAILED:", text, flush=True)


def make_pages(apps, source, work):
    """Runs the programs that take seconds. The page of each, and whether it draws."""
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)

    def run(name, *arguments):
        subprocess.run([apps / name, *map(str, arguments), "--quiet"], check=True, cwd=work, stderr=subprocess.DEVNULL)

    data, sensors = source / "data/ski_run", source / "config/sensors"
    run("inspect", data / "mt9a_1.csv", data / "gnss.csv", "--output", "inspect")
    (work / "short.yaml").write_text(
        f"base: {source}/config/scenarios/ski.yaml\nseed: 3\nmotion: {{rest_before: 40 s, run: 40 s, rest_after: 20 s}}\n")
    run("simulate", "short.yaml", "--output", "logs")
    (work / "pair.yaml").write_text(
        f"imu: {{file: logs/mt9a_1.csv, format: csv, sensor: {sensors}/xsens_mt9a.yaml, axes: +x +y +z, sampling: mean}}\n"
        f"reference: {{file: logs/ln200.csv, format: csv, sensor: {sensors}/ln200.yaml, axes: +x +y +z, sampling: mean}}\n")
    run("compare", "pair.yaml", "--output", "compare")
    run("montecarlo", source / "config/scenarios/easy_ski.yaml", "--runs", 2, "--output", "montecarlo")
    return [("inspect", work / "inspect/inspection.html", True), ("compare", work / "compare/alignment.html", False),
            ("montecarlo", work / "montecarlo/consistency.html", False)]


def look_at(browser, name, page, draws, pictures):
    for dark in (False, True):
        for width, height in ((1400, 900), (390, 844)):
            browser.open(page, width, height, dark)
            browser.wait("document.readyState === 'complete'" + (" && window.piste" if draws else ""))
            browser.run("document.querySelectorAll('details').forEach(d => d.open = true)")
            browser.run("new Promise(done => setTimeout(done, 300))")
            what = f"{name}, {'dark' if dark else 'light'}, {width} px"
            wide = browser.run("document.documentElement.scrollWidth")
            check(wide <= width, f"{what}: {wide} px wide")
            small = browser.run(
                "[...document.querySelectorAll('body *')].filter(e => e.checkVisibility() && [...e.childNodes].some(n => n.nodeType === 3 && "
                "n.data.trim()) && !['SCRIPT', 'STYLE', 'style'].includes(e.tagName)).map(e => [parseFloat(getComputedStyle(e).fontSize) * "
                "(e.getScreenCTM ? Math.hypot(e.getScreenCTM().a, e.getScreenCTM().b) : 1), e.textContent.slice(0, 40)]).filter(e => e[0] < 10.99)")
            check(not small, f"{what}: text below 11 px: {small[:3]}")
            numbers = browser.run("[...document.querySelectorAll('figcaption b')].map(e => e.textContent)")
            check(numbers == [f"Figure {k + 1}." for k in range(len(numbers))], f"{what}: figures {numbers}")
            for fault in browser.faults():
                check(False, f"{what}: {fault}")
            if pictures:
                browser.screenshot(f"{pictures}/{name}_{'dark' if dark else 'light'}_{width}.png")


def main():
    if not chromium.find():
        print("skipped: there is no Chromium (Debian: chromium)")
        return 77
    apps, source, work = map(pathlib.Path, sys.argv[1:4])
    pictures = sys.argv[4] if len(sys.argv) > 4 else None
    with chromium.Chromium() as browser:
        for name, page, draws in make_pages(apps, source, work):
            look_at(browser, name, page, draws, pictures)
    print("all is as it should be" if not failures else f"{len(failures)} failures")
    return 1 if failures else 0


sys.exit(main())
