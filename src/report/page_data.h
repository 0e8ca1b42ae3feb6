#pragma once
/// What the script of a page draws: tables of numbers and the charts of their columns.

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "piste/core/log.h"

namespace piste::page {

/// One curve of a chart. Names are those of columns of the chart's table.
struct Curve {
  std::string label, value;
  std::string sigma = {};           ///< half of the band; empty: no band
  std::string low = {}, high = {};  ///< the band, if not by a sigma
  std::string table = {};           ///< empty: the chart's
  std::string stroke = {};          ///< `dashed`, `dotted`, `dots` or `none`, which leaves the band; empty: a line
  std::optional<int> colour = {};   ///< of the palette, -1 is that of the text; none: by the curve's place
};

/// The curve of a signal of an Envelope (packed_table.h), with its extremes as its band, if it has these.
Curve envelope_curve(std::string label, const std::string& signal, bool extremes);

/// Curves over time, or over another axis of the page, in one unit.
///
/// Instead of a column, a value may be `hypot:A,B,C` of columns, `detail:A`, which is A less its running mean, or
/// `change:A`, which is A of the table `filtered` less A of `smoothed`.
struct Chart {
  std::string name;   ///< by which a script finds it; a word
  std::string title;  ///< for a reader
  std::string unit;
  std::string group;  ///< a Group's name; empty: on the first screen
  std::string table;  ///< `solution` and `biases` stand for what the reader chooses, smoothed or filtered
  std::vector<Curve> curves;
  bool points = false;              ///< dots instead of lines
  bool log = false;                 ///< a logarithmic scale of the values
  std::vector<double> levels = {};  ///< dashed lines, such as ± the prior
  double turn = 0;        ///< length of a whole turn: the line breaks where the value wraps around; 0: it does not
  std::string axis = {};  ///< an Axis' name; empty: time
  std::optional<std::array<double, 2>> limits = {};  ///< of the values that are shown at first
};

/// A stretch of an axis that is shaded: as a `rest`, an `outage` or a `turn`, which is paler.
struct Shade {
  double from = 0, to = 0;
  std::string kind;
};

/// What charts stand over instead of time. Charts of one axis have one window and one cursor. Their tables have the
/// column `x`; that of a logarithmic axis, and its ends, are decimal logarithms.
struct Axis {
  std::string name;         ///< a word
  std::string label, unit;  ///< for a reader
  bool log = false;
  double start = 0, end = 0;
  std::vector<Shade> shades = {};
};

/// A line in a picture, such as the path of a run. Its table has `x` on the axis, and `right` and `down` [px].
struct PlacedLine {
  std::string table;
  int colour = 0;
};

/// A picture of places along an axis, such as the plan of a course: it shows the cursor of the axis, and sets it.
struct Places {
  std::string name;  ///< a word
  std::string axis;  ///< an Axis' name
  std::vector<PlacedLine> lines = {};
};

/// Charts that fold as one.
struct Group {
  std::string name, title;
  std::string note = {};  ///< a sentence below the title
  bool open = false;
};

/// All of it. Times are in the clock of the tables' columns `time_s`.
struct Data {
  double start = 0, end = 0;
  std::optional<int> week = {};                             ///< GPS week of time 0, where it is known
  std::vector<std::pair<std::string, std::string>> tables;  ///< by name, as PackedTable::json()
  std::vector<Group> groups;
  std::vector<Chart> charts;
  std::vector<Axis> axes = {};  ///< besides time
  std::vector<Places> places = {};
  std::vector<Interval> rest = {}, outages = {};
  std::vector<std::string> sources = {};  ///< names, by the column `source` of the table `innovations`
  std::optional<Geodetic> origin = {};    ///< of `north_m` and `east_m`: there is a plan
};

/// Whether the libraries that draw were there when this was built.
bool draws();

/// The data and the scripts that draw them; empty without the libraries.
std::string scripts(const Data& data);

/// The places of the charts of each group, with contents.
std::string groups(const Data& data);

/// The head of what is drawn: a notice for what hinders it, and the choice of solution, clock and window. `over_time`:
/// whether charts stand over time.
std::string tools(bool over_time = true);

/// The plan, with its choices. `quality`: whether there are fixes with outcomes.
std::string plan(bool quality = true);

/// What stands in the place of plan and charts where the libraries are missing.
std::string no_charts();

/// The place of one chart outside of the groups.
std::string place(std::string_view chart);

}  // namespace piste::page
