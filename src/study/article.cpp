#include "piste/study/article.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>
#include <string_view>

#include "piste/io/config.h"

namespace piste {
namespace {

// Decimals of a number as printed: 3 of "0.170", −1 of "12e1".
int decimals_of(std::string_view number) {
  const auto exponent = number.find_first_of("eE");
  const auto point = number.substr(0, exponent).find('.');
  int decimals = point == std::string_view::npos ? 0 : static_cast<int>(number.substr(0, exponent).size() - point - 1);
  if (exponent == std::string_view::npos) return decimals;
  std::string_view power = number.substr(exponent + 1);
  if (power.starts_with('+')) power.remove_prefix(1);
  int shift = 0;
  std::from_chars(power.data(), power.data() + power.size(), shift);
  return decimals - shift;
}

// Half of the last significant digit of `value`, which is printed with so many decimals and `significant` digits.
double rounding_of(double value, int decimals, std::optional<long> significant) {
  constexpr double kExact = 1e-9;  // tolerance for the rounding of the logarithm of a power of ten
  const double last = 0.5 * std::pow(10, -decimals);
  if (!significant || value == 0) return last;
  const double leading = std::floor(std::log10(std::abs(value)) + kExact);
  return std::max(last, 0.5 * std::pow(10, leading + 1 - static_cast<double>(*significant)));
}

// Dimension and unit of the three signals of a triad.
struct Triad {
  std::string key;
  int first;
  const Dimension& dimension;
  double factor;  // from SI to the shown unit
};

void read_triad(const Config& row, const Triad& triad, std::optional<long> significant, PrintedRow& out) {
  const Vector3d values = triad.factor * row.vector(triad.key, triad.dimension);
  const std::string std_key = triad.key + "_std";
  std::istringstream written(row.text(triad.key));
  std::array<std::string, 3> numbers;
  std::string unit;
  written >> numbers[0] >> numbers[1] >> numbers[2] >> unit;
  const double shown = triad.factor * unit_factor(unit, triad.dimension);  // of one unit as written
  const auto printed = out.begin() + triad.first;
  for (int i = 0; i < 3; ++i) {
    Printed& number = printed[i];
    number.value = values(i);
    number.rounding =
        shown * rounding_of(values(i) / shown, decimals_of(numbers[static_cast<std::size_t>(i)]), significant);
  }
  if (!row.has(std_key)) return;
  const Vector3d spread = triad.factor * row.vector(std_key, triad.dimension);
  if (!(spread.array() >= 0).all()) row.fail(std_key, "a standard deviation is not below zero");
  for (int i = 0; i < 3; ++i) printed[i].std = spread(i);
}

std::size_t place_of(const Config& row, const std::vector<std::string>& sensors) {
  const std::string name = row.text("sensor");
  const auto found = std::ranges::find(sensors, name);
  if (found == sensors.end()) {
    row.fail("sensor", fmt::format("`{}` is none of the article's `sensors`: {}", name, fmt::join(sensors, ", ")));
  }
  return static_cast<std::size_t>(found - sensors.begin());
}

enum class Printing { kBias, kRatio };

PrintedTable read_table(const std::optional<Config>& tables, std::string_view key, Printing printing,
                        const std::vector<std::string>& sensors) {
  PrintedTable out{"", std::vector<PrintedRow>(sensors.size())};
  const std::optional<Config> table = tables ? tables->find_map(key) : std::nullopt;
  if (!table) return out;
  out.name = table->text("name");
  std::optional<long> significant;
  if (table->has("significant_digits")) {
    significant = table->integer("significant_digits");
    if (*significant < 1) table->fail("significant_digits", "one at least");
  }
  const bool ratio = printing == Printing::kRatio;
  const Triad accel{"accel", 0, ratio ? dimension::kRatio : dimension::kAcceleration, 1};
  const Triad gyro{"gyro", 3, ratio ? dimension::kRatio : dimension::kAngularRate, ratio ? 1 : kDegreesPerRadian};
  std::set<std::size_t> seen;
  for (const Config& row : table->maps("rows")) {
    const std::size_t sensor = place_of(row, sensors);
    if (!seen.insert(sensor).second) row.fail("sensor", fmt::format("`{}` stands twice", sensors[sensor]));
    for (const Triad& triad : {accel, gyro}) read_triad(row, triad, significant, out.sensors[sensor]);
  }
  if (seen.empty()) table->fail("rows", "is missing; a table has a row of one sensor at least");
  return out;
}

ArticleRemarks read_remarks(const Config& file) {
  const auto remarks = file.find_map("remarks");
  if (!remarks) return {};
  return {remarks->text("mean_signal", ""), remarks->text("correlation", ""), remarks->text("significance", ""),
          remarks->text("scale_at_rest", "")};
}

std::vector<std::string> read_sensors(const Config& file) {
  std::vector<std::string> sensors = file.words("sensors");
  if (sensors.empty()) file.fail("sensors", "is missing; name the article's sensors, such as [sensor 1, sensor 2]");
  std::set<std::string> names;
  for (const std::string& name : sensors) {
    if (!names.insert(name).second) file.fail("sensors", fmt::format("`{}` stands twice", name));
  }
  return sensors;
}

}  // namespace

bool PrintedTable::empty() const {
  return std::ranges::none_of(sensors, [](const PrintedRow& row) {
    return std::ranges::any_of(row, [](const Printed& p) { return std::isfinite(p.value); });
  });
}

Article read_article(const std::filesystem::path& path) {
  const Config file = Config::load(path);
  Article out;
  out.title = file.text("title");
  out.sensors = read_sensors(file);
  if (file.has("runs")) {
    const long runs = file.integer("runs");
    if (runs < 1) file.fail("runs", "one at least; leave it out where the article does not say");
    out.runs = static_cast<std::size_t>(runs);
  }
  const auto tables = file.find_map("tables");
  const auto read = [&](std::string_view key, Printing printing) {
    return read_table(tables, key, printing, out.sensors);
  };
  out.tables = {.rest = read("rest", Printing::kBias),
                .before = read("before", Printing::kBias),
                .after = read("after", Printing::kBias),
                .joint_bias = read("joint_bias", Printing::kBias),
                .joint_scale = read("joint_scale", Printing::kRatio),
                .correlation = read("correlation", Printing::kRatio),
                .bias_only = read("bias_only", Printing::kBias)};
  out.remarks = read_remarks(file);
  file.finish();
  return out;
}

const PrintedRow* ArticleBeside::row(const PrintedTable& table, const std::string& sensor) const {
  const auto found = counterparts.find(sensor);
  return found == counterparts.end() ? nullptr : &table.sensors[found->second];
}

}  // namespace piste
