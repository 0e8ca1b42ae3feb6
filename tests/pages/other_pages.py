"""The pages of the other programs in a headless Chromium: no error, no request, light and dark, whole on a phone, curves that are
those of the files.

usage: other_pages.py APPS SOURCE WORK [PICTURES]
Ends with 77, which ctest shows as skipped, where there is no Chromium.
"""

import csv
import json
import math
import pathlib
import random
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
    """Runs the programs that take seconds. The page of each."""
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
    noise = random.Random(56)
    with open(work / "rest.csv", "w") as file:
        file.write("time_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2\n")
        wandered = 0.0
        for k in range(60000):
            wandered += noise.gauss(0, 2e-4)
            row = [noise.gauss(wandered, 0.05) for _ in range(3)] + [noise.gauss(-9.81 * (axis == 2), 0.02) for axis in range(3)]
            file.write(f"{k / 100:.2f}," + ",".join(f"{v:.6f}" for v in row) + "\n")
    run("allan", "rest.csv", "--output", "allan")
    run("replay", source / "config/ski_run.yaml", "--output", "replay")
    run("evaluate", "replay", data / "truth.csv", "--output", "evaluate")
    (work / "other.yaml").write_text(f"base: {source}/config/ski_run.yaml\noutages: [[302500, 10]]\n")
    run("descents", f"one={source}/config/ski_run.yaml", "two=other.yaml", "--output", "descents")
    (work / "tuned.yaml").write_text(f"base: {source}/config/ski_run.yaml\nspan: {{start: 302490 s, end: 302550 s}}\n")
    run("tune", "tuned.yaml", "--output", "tune")
    (work / "campaign.yaml").write_text(
        "low_pass: 12 Hz\nruns:\n  - name: ski-1\n    activity: ski\n"
        f"    reference: {{file: logs/ln200.csv, format: csv, sensor: {sensors}/ln200.yaml, axes: +x +y +z, sampling: mean}}\n"
        "    gnss: {file: logs/gnss_l1l2.csv, format: csv, lever_arm: 0 0 0 m}\n    phases: auto\n    mems:\n"
        f"      - {{name: MT-9A 1, file: logs/mt9a_1.csv, format: csv, sensor: {sensors}/xsens_mt9a.yaml, axes: +x +y +z, sampling: mean}}\n")
    run("study", "campaign.yaml", "--output", "study")
    return {"inspect": work / "inspect/inspection.html", "compare": work / "compare/alignment.html",
            "montecarlo": work / "montecarlo/consistency.html", "allan": work / "allan/allan.html",
            "evaluate": work / "evaluate/evaluation.html", "descents": work / "descents/descents.html", "tune": work / "tune/tune.html",
            "study": work / "study/study.html"}


def rows_of(path):
    with open(path) as file:
        return list(csv.DictReader(file))


def check_charts(browser, name):
    """Each chart has curves, and zooms to the window that is asked for; charts of one axis do so together."""
    for chart in browser.run("Object.keys(piste.charts)"):
        handle = f"piste.charts[{json.dumps(chart)}]"
        whole = browser.run(f"{handle}.window().time")
        start, end = whole[0] + 0.4 * (whole[1] - whole[0]), whole[0] + 0.6 * (whole[1] - whole[0])
        browser.run(f"{handle}.show({start}, {end})")
        shown, curves = browser.run(f"[{handle}.window().time, {handle}.curves()]")
        near = 1e-6 * (whole[1] - whole[0])
        check(abs(shown[0] - start) < near and abs(shown[1] - end) < near, f"{name}, {chart}: {shown} in place of {start} to {end}")
        check(len({c["label"] for c in curves}) == len(curves), f"{name}, {chart}: curves of one name")
        browser.run("document.getElementById('reset').click()")
        browser.run(f"{handle}.show({whole[0]}, {whole[1]})")
        curves = browser.run(f"{handle}.curves()")
        there = sum(v is not None for c in curves for v in c["value"])
        check(there >= 1 and all(len({len(c[k]) for k in ("t", "value", "low", "high")}) == 1 for c in curves), f"{name}, {chart}: {there} values")
    browser.run("document.getElementById('reset').click()")


def check_allan(browser, work):
    """The dots are the rows of allan.csv, with their intervals, above the model; a process has one colour on all axes."""
    colours = {}
    for axis in ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"):
        curves = browser.run(f"piste.charts.{axis}.show(0.001, 1e4).then(() => piste.charts.{axis}.curves())")
        check(curves[-1]["label"] == "measured", f"allan, {axis}: {curves[-1]['label']} is drawn last")
        factor = 180 / math.pi if axis.startswith("gyro") else 1
        for column, key in (("adev", "value"), ("lci", "low"), ("uci", "high")):
            drawn = {round(t, 4): v for t, v in zip(curves[-1]["t"], curves[-1][key])}
            wanted = {round(float(r["tau_s"]), 4): factor * float(r[f"{axis}_{column}"]) for r in rows_of(work / "allan/allan.csv")
                      if r[f"{axis}_{column}"]}
            check(wanted and all(drawn.get(t) is not None and abs(drawn[t] - v) < 1e-3 * v for t, v in wanted.items() if math.isfinite(v)),
                  f"allan, {axis}_{column}: {drawn}, and the file has {wanted}")
    for chart in browser.run("JSON.parse(document.getElementById('page-data').textContent).charts"):
        for curve in chart["curves"]:
            check(colours.setdefault(curve["label"], curve["colour"]) == curve["colour"], f"allan: {curve['label']} has two colours")
    check(len(set(colours.values())) == len(colours), f"allan: two curves of one colour: {colours}")


def check_cursor_of_descents(browser):
    """Pointing at the plan marks one place on each run and on all charts; their legends say what is there."""
    dots = "[...document.querySelectorAll('[data-places] circle.at')]"
    check(browser.run(f"{dots}.every(d => d.getAttribute('visibility') === 'hidden')"), "descents: a cursor before anyone points")
    browser.run("document.querySelector('[data-places]').scrollIntoView()")
    browser.run("new Promise(done => setTimeout(done, 300))")
    place = browser.run(
        "(() => { const line = document.querySelector('[data-places] svg path.line'), on = line.getPointAtLength(line.getTotalLength() / 2)"
        ".matrixTransform(line.getScreenCTM()), svg = line.closest('svg'); svg.dispatchEvent(new PointerEvent('pointermove', "
        f"{{clientX: on.x, clientY: on.y}})); return [on.x, on.y, {dots}.map(d => {{ const b = d.getBoundingClientRect(); return "
        "[d.getAttribute('visibility'), b.left + b.width / 2, b.top + b.height / 2]; })]; })()")
    check(len(place[2]) == 2 and all(d[0] == "visible" and math.hypot(d[1] - place[0], d[2] - place[1]) < 25 for d in place[2]), f"descents: {place}")
    for chart, unit in (("gained", "s"), ("speed", "m/s"), ("offset", "m")):
        browser.run("[...document.querySelectorAll('.place')].forEach(p => p.dataset.chart === '%s' && p.scrollIntoView())" % chart)
        browser.run("new Promise(done => setTimeout(done, 300))")
        said = browser.run("[...document.querySelectorAll('.place')].find(p => p.dataset.chart === '%s')?.textContent" % chart)
        check(said and f" {unit}at " in said and (chart != "gained" or " ± " in said), f"descents, {chart}: {said}")


def look_at(browser, name, page, pictures):
    for dark in (False, True):
        for width, height in ((1400, 900), (390, 844)):
            browser.open(page, width, height, dark)
            browser.wait("document.readyState === 'complete' && (window.piste || !document.getElementById('page-data'))")
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
        for name, page in make_pages(apps, source, work).items():
            browser.open(page)
            browser.wait("document.readyState === 'complete' && (window.piste || !document.getElementById('page-data'))")
            check(name == "tune" or browser.run("!!window.piste"), f"{name} has no charts")
            if browser.run("!!window.piste"):
                check_charts(browser, name)
            if name == "allan":
                check_allan(browser, work)
            if name == "descents":
                check_cursor_of_descents(browser)
            look_at(browser, name, page, pictures)
    print("all is as it should be" if not failures else f"{len(failures)} failures")
    return 1 if failures else 0


sys.exit(main())
