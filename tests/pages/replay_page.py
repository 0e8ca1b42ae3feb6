"""The page of a replay, driven in a headless Chromium: what it draws is what the files say, whatever one does with it.

usage: replay_page.py REPLAY SOURCE WORK [PICTURES]
Ends with 77, which ctest shows as skipped, where there is no Chromium.
"""

import csv
import datetime
import json
import math
import pathlib
import random
import re
import shutil
import subprocess
import sys
import time

import chromium

CHARTS = {"height": ("height_m", "sigma_down_m"), "velocity_north": ("velocity_north_m_s", "sigma_velocity_north_m_s"),
          "velocity_east": ("velocity_east_m_s", "sigma_velocity_east_m_s"), "roll": ("roll_deg", "sigma_roll_deg"),
          "pitch": ("pitch_deg", "sigma_pitch_deg"), "heading": ("heading_deg", "sigma_heading_deg")}
WEEK = 2296
failures = []


def check(right, text):
    if not right:
        failures.append(text)
        print("FAILED:", text, flush=True)


def rows_of(path):
    with open(path) as file:
        return list(csv.DictReader(file))


def make_run(replay, source, work):
    """The shipped run with every 97th position 4 m beside the track, withheld fixes, and a name that is markup."""
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    for name in ("mt9a_1.csv", "ln200_attitude.csv"):
        shutil.copy(source / "data/ski_run" / name, work)
    rows = rows_of(source / "data/ski_run/gnss.csv")
    with open(work / "gnss.csv", "w") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        for k, row in enumerate(rows):
            if k % 97 == 50:
                row["latitude_deg"] = repr(float(row["latitude_deg"]) + 4 / 111e3)
            writer.writerow(row)
    text = f"week: {WEEK}\n" + (source / "config/ski_run.yaml").read_text().replace("../data/ski_run/", "").replace(
        "sensors/", str(source / "config/sensors") + "/").replace("outages: []", "outages: [[302510, 5]]")
    config = work / "<script>alert(1)<script>.yaml"
    config.write_text("# </script><script>document.title='broken'</script><!--\n" + text)
    subprocess.run([replay, str(config), "--output", str(work / "out"), "--quiet"], check=True)
    return work / "out"


def check_kinds(browser, replay, source, work):
    """Kinds and satellites of fixes, of a log that states them: as strip, chart and colours of the plan."""
    kinds, rows = {}, rows_of(source / "data/ski_run/gnss.csv")
    with open(work / "gnss.pos", "w") as file:
        file.write("%  GPST      latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)\n")
        for k, row in enumerate(rows):
            quality, satellites = (1, 2, 5)[k // 300 % 3], 5 + k % 9
            kinds[round(1000 * float(row["time_s"]))] = ({1: "fixed", 2: "float", 5: "single"}[quality], satellites)
            file.write(f"{WEEK} {row['time_s']} {row['latitude_deg']} {row['longitude_deg']} {row['height_m']} {quality} {satellites} "
                       f"{row['sigma_north_m']} {row['sigma_east_m']} {row['sigma_down_m']}\n")
    text = (source / "config/ski_run.yaml").read_text().replace("../data/ski_run/gnss.csv", "gnss.pos").replace("../data/ski_run/", "").replace(
        "sensors/", str(source / "config/sensors") + "/").replace("format: csv                         # csv | kf_gins | rtklib_pos", "format: rtklib_pos  #").replace(
        "use: position velocity", "use: position")
    (work / "kinds.yaml").write_text(text)
    subprocess.run([replay, str(work / "kinds.yaml"), "--output", str(work / "kinds"), "--quiet"], check=True)
    browser.open(work / "kinds/report.html")
    browser.wait("window.piste && piste.charts.quality && piste.charts.satellites")
    check(json.loads((work / "kinds/summary.json").read_text())["gps_week"] == WEEK, "the week of the log")
    fixes = [row for row in rows_of(work / "kinds/innovations.csv") if row["source"] == "gnss[0].position"]
    start, end = float(fixes[0]["time_s"]), float(fixes[-1]["time_s"])
    strip = browser.run(f"piste.charts.quality.show({start}, {end}).then(() => piste.charts.quality.curves())")
    drawn = sorted((round(1000 * t), curve["label"]) for curve in strip for t, v in zip(curve["t"], curve["value"]) if v is not None)
    from_axis = browser.run("piste.charts.quality.window().time[0]")  # a fix may be earlier than the first epoch
    wanted = sorted((round(1000 * float(row["time_s"])), kinds[round(1000 * float(row["time_s"]))][0]) for row in fixes
                    if float(row["time_s"]) > from_axis - 1e-6)
    check(drawn == wanted, f"the strip has {len(drawn)} kinds of fixes, {len(wanted)} are right: {drawn[:3]}, {wanted[:3]}")
    middle = (start + end) / 2
    many = browser.run(f"piste.charts.satellites.show({middle}, {middle + 20}).then(() => piste.charts.satellites.drawn())")
    check(len(many["t"]) > 100 and all(v == kinds[round(1000 * t)][1] for t, v in zip(many["t"], many["value"])), f"satellites: {many['value'][:9]}")
    options = browser.run("[...document.getElementById('colour').options].map(o => o.value)")
    check("solution" in options and "satellites" in options, f"colours of the plan: {options}")
    for option in ("solution", "satellites"):
        browser.run("(() => { const e = document.getElementById('colour'); e.value = '%s'; e.dispatchEvent(new Event('change')); })()" % option)
        scale = browser.run("document.getElementById('scale').textContent")
        check(all(k in scale for k in ("single", "float", "fixed")) if option == "solution" else re.match(r"5(\.0+)? .*13(\.0+)? satellites", scale),
              f"the plan's scale for {option}: {scale}")
    for fault in browser.faults():
        check(False, fault)


def close(a, b, turn):
    return abs(math.remainder(a - b, 360) if turn else a - b)


def check_drawn(browser, name, by_time, span):
    drawn = browser.run(f"piste.charts['{name}'].drawn()")
    value_column, sigma_column = CHARTS[name]
    lengths = {len(drawn[k]) for k in ("t", "value", "low", "high")}
    check(len(lengths) == 1, f"{name}: columns of unequal lengths {lengths}")
    check(len(drawn["t"]) >= 2, f"{name}: nothing drawn from {span}")
    width = 1400
    check(len(drawn["t"]) <= 2 * width, f"{name}: {len(drawn['t'])} points for at most {width} columns")
    inside = 0
    for t, value, low, high in zip(drawn["t"], drawn["value"], drawn["low"], drawn["high"]):
        row = by_time.get(round(1000 * t))
        if row is None:
            check(False, f"{name}: no row at {t}")
            return
        inside += span[0] <= t <= span[1]
        if value is None:
            check(low is None and high is None, f"{name}: a band without a value at {t}")
            continue
        truth, sigma = float(row[value_column]), float(row[sigma_column])
        wrong = max(abs(value - truth), abs(low - (truth - sigma)), abs(high - (truth + sigma)))
        if wrong > 0.02 * sigma + 2e-5:
            check(False, f"{name} at {t}: {value} in {low} to {high}, the file has {truth} ± {sigma}")
            return
    # All rows of a narrow window, and of a wide one its extremes.
    there = [float(r[value_column]) for r in by_time.values() if span[0] <= float(r["time_s"]) <= span[1]]
    if len(there) <= 400:
        check(inside >= len(there), f"{name}: {inside} of {len(there)} rows drawn from {span}")
    values = [v for t, v in zip(drawn["t"], drawn["value"]) if v is not None and span[0] <= t <= span[1]]
    if there and values:
        for kind in (min, max):
            check(abs(kind(values) - kind(there)) < 0.02 * max(float(r[sigma_column]) for r in by_time.values()) + 2e-5,
                  f"{name}: {kind.__name__} {kind(values)}, the file has {kind(there)} in {span}")


def element(browser, selector):
    """Left, top, width and height of an element in view."""
    return browser.run(f"(() => {{ const e = document.querySelector({json.dumps(selector)}); e.scrollIntoView({{block: 'center'}}); "
                       "const r = e.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; })()")


def check_data(browser, out):
    by_time = {round(1000 * float(row["time_s"])): row for row in rows_of(out / "smoothed.csv")}
    times = sorted(float(row["time_s"]) for row in by_time.values())
    shuffle = random.Random(56)
    for name in CHARTS:
        shortest = browser.run(f"Object.keys(piste.charts).filter(n => n.includes('{name}')).sort((a, b) => a.length - b.length)[0]")
        check(shortest == name, f"the shortest name with {name} is {shortest}")
    for k in range(12):
        length = (times[-1] - times[0]) * 10 ** -shuffle.uniform(0, 2.5)
        start = shuffle.uniform(times[0], times[-1] - length)
        span = (start, start + length) if k else (times[0], times[-1])
        for name in CHARTS:
            browser.run(f"piste.charts['{name}'].show({span[0]}, {span[1]})")
            check_drawn(browser, name, by_time, span)

    drawn = browser.run("piste.fixes.drawn()")
    rows = [row for row in rows_of(out / "innovations.csv") if row["source"].startswith("gnss")]
    wanted = sorted((row["time_s"], row["source"], row["outcome"] in ("used", "readmitted")) for row in rows)
    there = sorted((f"{fix['time']:.6f}", fix["source"], fix["used"]) for fix in drawn)
    check(there == wanted, f"{len(there)} marks, {len(wanted)} rows of receivers")
    check(sum(not fix["used"] for fix in drawn) > 10, "hardly any fix was rejected: the test says nothing")


def check_statistics(browser, out):
    browser.run("document.querySelectorAll('details').forEach(d => d.open = true)")
    browser.wait("document.querySelectorAll('.histogram figcaption').length > 2")
    caption = browser.run("document.querySelector('[data-chart=\"ratio_gnss[0].position\"] + .histogram figcaption').textContent")
    rows = [row for row in rows_of(out / "innovations.csv") if row["source"] == "gnss[0].position"]
    for axis, (number, _) in enumerate(zip("123", "ned")):
        values = [float(r["residual_" + number]) / float(r["sigma_" + number]) for r in rows if r["residual_" + number]]
        mean = sum(values) / len(values)
        std = math.sqrt(sum(v * v for v in values) / len(values) - mean ** 2)
        beyond = 100 * sum(abs(v) > 1 for v in values) / len(values)
        shown = re.findall(r"std ([\d.]+), (\d+) % beyond", caption)[axis]
        check(abs(float(shown[0]) - std) < 0.02 * std + 0.006, f"std {shown[0]} shown, {std} in the file")
        check(abs(float(shown[1]) - beyond) < 0.02 * beyond + 0.6, f"{shown[1]} % shown, {beyond} in the file")


def check_hands(browser, out, work):
    """Zoom along one axis and in a box, wheel, cursor, exports, reset, the map."""
    window = lambda name: browser.run(f"piste.charts['{name}'].window()")
    browser.run("document.getElementById('reset').click()")
    browser.run("piste.charts.roll.drawn()")
    left, top, width, height = element(browser, "[data-chart=roll] .chart")
    whole = window("roll")
    browser.drag((left + width / 2, top + 30), (left + width / 2 + 2, top + 90))
    zoomed = window("roll")
    check(zoomed["time"] == whole["time"] and zoomed["value"] != whole["value"], "a y zoom changes the values alone")
    browser.drag((left + width * 0.4, top + 60), (left + width * 0.6, top + 62))
    after = window("roll")
    check(after["value"] == zoomed["value"], f"a y zoom stays when the time is zoomed: {zoomed} {after}")
    check(after["time"][0] > whole["time"][0] and after["time"][1] < whole["time"][1], "a time zoom")
    check(window("pitch")["time"] == after["time"], "one time window")
    browser.run("piste.charts.pitch.show(%f, %f)" % tuple(whole["time"]))
    check(window("roll")["value"] == zoomed["value"], "a y zoom stays after show()")
    browser.drag((left + width * 0.4, top + 40), (left + width * 0.6, top + 100))
    boxed = window("roll")
    check(boxed["time"] != whole["time"] and boxed["value"] != zoomed["value"], "a box zooms both")
    browser.wheel(left + width / 2, top + 60, -200, ctrl=True)
    browser.wait(f"piste.charts.roll.window().time[0] > {boxed['time'][0]} + 1e-9", 5)
    browser.run("document.getElementById('reset').click()")
    check(window("roll")["time"] == whole["time"] and window("roll")["value"] == whole["value"], "reset")

    browser.hover(left + width / 2, top + 60)
    legend = browser.run("document.querySelector('[data-chart=roll] .legend').textContent")
    check(re.search(r"[\d.]+ ± [\d.]+ deg", legend), f"the cursor has value, sigma and unit: {legend}")
    browser.run("scrollTo(0, 0)")
    check(browser.run("!document.querySelector('.plan-cursor').hidden"), "time → place")
    x, y = browser.run("(() => { const r = document.querySelector('.plan-cursor').getBoundingClientRect(); return [r.left + 7, r.top + 7]; })()")
    before = browser.run("document.querySelector('[data-chart=height] .legend').textContent")
    browser.hover(x + 60, y + 60), browser.hover(x + 8, y)
    browser.drag((x + 200, y + 120), (x + 215, y + 130))  # pans
    check(browser.run("document.querySelector('[data-chart=height] .legend').textContent") != "", "place → time: " + before)

    downloads = work / "downloads"
    downloads.mkdir()
    browser("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(downloads))
    for k in (0, 1):
        browser.run(f"document.querySelectorAll('[data-chart=roll] .chart-tools button')[{k}].click()")
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline and not ((downloads / "roll.csv").exists() and (downloads / "roll.png").exists()):
        browser.run("1"), time.sleep(0.1)
    check((downloads / "roll.png").exists() and (downloads / "roll.png").read_bytes().startswith(b"\x89PNG"), "PNG")
    saved = rows_of(downloads / "roll.csv") if (downloads / "roll.csv").exists() else []
    smoothed = rows_of(out / "smoothed.csv")
    check(len(saved) == len(smoothed), f"CSV: {len(saved)} rows of {len(smoothed)}")
    if saved:
        a, b = saved[len(saved) // 2], smoothed[len(saved) // 2]
        check(a["time_s"] == b["time_s"] and abs(float(a["roll"]) - float(b["roll_deg"])) < 0.02 * float(b["sigma_roll_deg"]),
              f"CSV: {a}")


def check_time(browser, out):
    """Date and time in the head, and the axis in seconds since the start, of the week, and in UTC."""
    start = float(rows_of(out / "smoothed.csv")[0]["time_s"])
    utc = datetime.datetime(1980, 1, 6) + datetime.timedelta(seconds=WEEK * 604800 + start - 18)  # leap seconds since 2017
    head = browser.run("document.getElementById('subtitle').textContent")
    check(head.startswith(f"{utc:%Y-%m-%d %H:%M:%S} UTC · "), f"the head has {head}, the run begins at {utc}")
    browser.run("document.getElementById('reset').click(); piste.charts.roll.drawn()")

    def shown(clock):
        browser.run("(() => { const e = document.getElementById('clock'); e.value = '%s'; e.dispatchEvent(new Event('change')); })()" % clock)
        left, top, width, height = element(browser, "[data-chart=roll] .chart")
        browser.hover(left + width / 2, top + 60)
        browser.run("new Promise(done => setTimeout(done, 100))")
        return browser.run("[[...document.querySelectorAll('[data-chart=roll] .dygraph-axis-label-x')].map(e => e.textContent), "
                           "document.querySelector('[data-chart=roll] .legend').textContent, document.getElementById('window').textContent]")

    ticks, legend, window = shown("seconds")
    check(window.startswith("0.00 to") and all(0 <= float(t) <= 1000 for t in ticks), f"seconds since the start: {window}, {ticks}")
    at = float(re.search(r"at ([\d.]+) s", legend)[1])
    ticks, legend, window = shown("week")
    check(abs(float(re.search(r"at ([\d.]+) s", legend)[1]) - start - at) < 2e-3 and all(float(t) >= start for t in ticks),
          f"seconds of week: {legend}, {ticks}")
    ticks, legend, window = shown("utc")
    wanted = utc + datetime.timedelta(seconds=at)
    of_day = re.search(r"at (\d\d:\d\d:[\d.]+) UTC", legend)
    check(of_day and abs((datetime.datetime.strptime(of_day[1], "%H:%M:%S.%f") - datetime.datetime.strptime(f"{wanted:%H:%M:%S.%f}", "%H:%M:%S.%f"))
                         .total_seconds()) < 2e-3, f"UTC: {legend}, and {wanted} is right")
    check(len(ticks) > 2 and all(re.fullmatch(r"\d\d:\d\d(:\d\d)?", t) for t in ticks), f"the axis in UTC has {ticks}")
    shown("seconds")


def check_layout(browser, out, dark, pictures):
    tone = "dark" if dark else "light"
    for width, height in ((1400, 900), (390, 844)):
        browser.open(out / "report.html", width, height, dark)
        browser.wait("window.piste && document.querySelector('[data-chart=speed] canvas') !== null")
        browser.run("document.querySelectorAll('details').forEach(d => d.open = true)")
        browser.run("new Promise(done => setTimeout(done, 400))")
        wide = browser.run("document.documentElement.scrollWidth")
        check(wide <= width, f"{tone}: {wide} px wide at {width}")
        small = browser.run(
            "[...document.querySelectorAll('body *')].filter(e => e.checkVisibility() && [...e.childNodes].some(n => n.nodeType === 3 && "
            "n.data.trim()) && e.tagName !== 'SCRIPT' && parseFloat(getComputedStyle(e).fontSize) < 11).map(e => e.className + ' ' + e.textContent.slice(0, 40))")
        check(not small, f"{tone}, {width} px: text below 11 px: {small[:3]}")
        ground = browser.run("getComputedStyle(document.body).backgroundColor")
        check((sum(map(int, re.findall(r"\d+", ground)[:3])) < 384) == dark, f"{tone}: {ground}")
        if width == 1400:
            browser.run("document.querySelectorAll('details').forEach(d => d.open = d.id === 'motion')")
            inside = browser.run("['#plan', '[data-chart=height] .chart', '[data-chart=speed] .chart'].map(s => document.querySelector(s)"
                                 ".getBoundingClientRect().bottom)")
            check(max(inside) <= height, f"{tone}: the first screen ends at {inside}")
            sides = browser.run("['#plan', '[data-chart=height]'].map(s => document.querySelector(s).getBoundingClientRect().left)")
            check(sides[0] < sides[1], "plan left, height right")
        if pictures:
            browser.screenshot(f"{pictures}/{tone}_{width}.png")
        for fault in browser.faults():
            check(False, f"{tone}, {width} px: {fault}")


def main():
    if not chromium.find():
        print("skipped: there is no Chromium (Debian: chromium)")
        return 77
    replay, source, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    pictures = sys.argv[4] if len(sys.argv) > 4 else None
    out = make_run(replay, source, work)
    page = (out / "report.html").read_text()
    check("libjs-dygraphs" not in page, "piste was built without dygraphs and Leaflet")
    with chromium.Chromium() as browser:
        browser.open(out / "report.html")
        first = browser.wait("document.querySelector('[data-chart=height] canvas') !== null")
        more = browser.wait("window.piste")
        print(f"first chart after {first:.2f} s, window.piste {more:.2f} s later")
        check(more < 3, "window.piste is there within 3 s of the first chart")
        check(browser.run("document.title").startswith("<script>alert(1)"), "the name is text")
        check_data(browser, out)
        check_statistics(browser, out)
        check_hands(browser, out, work)
        check_time(browser, out)
        summary = json.loads((out / "summary.json").read_text())
        shown = browser.run("[...document.querySelectorAll('.warnings li')].map(e => e.textContent)")
        check(shown == summary["warnings"], f"warnings: {shown} on the page, {summary['warnings']} in summary.json")
        for fault in browser.faults():
            check(False, fault)
        check(browser.run("!piste.charts.quality && !piste.charts.satellites"), "kinds of fixes of a log without them")
        check_kinds(browser, replay, source, work)
        for dark in (False, True):
            check_layout(browser, out, dark, pictures)
    print("all is as it should be" if not failures else f"{len(failures)} failures")
    return 1 if failures else 0


sys.exit(main())
