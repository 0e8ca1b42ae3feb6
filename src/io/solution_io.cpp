#include "piste/io/solution_io.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "io/csv.h"
#include "io/row_rate.h"
#include "math/geoid.h"
#include "math/gps_time.h"
#include "math/projection.h"
#include "piste/math/units.h"
#include "quantity.h"

namespace piste {

// What RowCsv holds.
namespace row_csv {

struct BiasRow {
  std::vector<Quantity> quantities;
  void operator()(const Solution& solution, std::size_t i, std::span<double> row) const {
    const Estimate x = solution.estimate(i);
    const Sigmas s = solution.sigmas(i);
    double* out = row.data();
    *out++ = solution.time(i);
    for (const Quantity& q : quantities) {
      const auto [value, sigma] = shown(q, x, s);
      out = std::copy_n(value.data(), q.size(), out);
      out = std::copy_n(sigma.data(), q.size(), out);
    }
  }
};

// The columns of RowExtras.
class ExtraColumns {
 public:
  ExtraColumns(RowExtras extras) : extras_(std::move(extras)) {
    for (const int code : extras_.epsg) projections_.push_back(std::make_unique<Projection>(code));
  }
  std::vector<CsvColumn> extras() const;
  void fill(const World& world, double time, const Navigation& n, const Estimate* x, std::span<double> row);
  bool needs_estimate() const { return extras_.needs_log(); }
  // time_utc is text, and stands last.
  std::string_view text_column() const { return extras_.time == RowTime::kUtc ? "time_utc" : ""; }
  std::string text(std::span<const double> row) const {
    return extras_.time == RowTime::kUtc ? utc_text({*extras_.week, row[0]}) : "";
  }

 private:
  RowExtras extras_;
  std::optional<int> zone_ = {};  // of UTM
  std::vector<std::unique_ptr<Projection>> projections_;
};

}  // namespace row_csv

namespace {

using row_csv::BiasRow, row_csv::ExtraColumns;

constexpr int kTimeDecimals = 6, kDegreeDecimals = 7;

/// A unit as it stands in a column name.
std::string column_unit(std::string_view unit) {
  std::string name;
  for (const char c : unit) {
    if (c != '^') name += c == '/' ? '_' : c;
  }
  return name;
}

int decimals_of(Block block) {
  constexpr auto kSmall = 8, kLarge = 6, kPpm = 2;
  return info(block).unit == "ppm" ? kPpm : info(block).unit == "m" || info(block).unit == "deg" ? kLarge : kSmall;
}

void add_columns(std::vector<CsvColumn>& columns, const Quantity& q, std::string_view prefix) {
  const BlockInfo& row = info(q.block);
  for (int i = 0; i < row.size; ++i) {
    const std::string axis = row.size == 1 ? "" : fmt::format("_{}", row.axes[static_cast<std::size_t>(i)]);
    columns.push_back({fmt::format("{}{}{}_{}", prefix, q.name, axis, column_unit(row.unit)), decimals_of(q.block)});
  }
}

std::vector<CsvColumn> navigation_columns() {
  constexpr int kMetres = 5, kDegrees = kDegreeDecimals, kPlace = 10;
  return {{"time_s", kTimeDecimals},
          {"latitude_deg", kPlace},
          {"longitude_deg", kPlace},
          {"height_m", kMetres},
          {"velocity_north_m_s", kMetres},
          {"velocity_east_m_s", kMetres},
          {"velocity_down_m_s", kMetres},
          {"roll_deg", kDegrees},
          {"pitch_deg", kDegrees},
          {"heading_deg", kDegrees},
          {"sigma_north_m", kMetres},
          {"sigma_east_m", kMetres},
          {"sigma_down_m", kMetres},
          {"sigma_velocity_north_m_s", kMetres},
          {"sigma_velocity_east_m_s", kMetres},
          {"sigma_velocity_down_m_s", kMetres},
          {"sigma_roll_deg", kDegrees},
          {"sigma_pitch_deg", kDegrees},
          {"sigma_heading_deg", kDegrees}};
}

constexpr std::size_t kNavigationColumns = 19;

std::vector<CsvColumn> with_extras(std::vector<CsvColumn> columns, const std::vector<CsvColumn>& extras) {
  columns.insert(columns.end(), extras.begin(), extras.end());
  return columns;
}

void navigation_row(double time, const Navigation& n, const NavigationSigmas& s, std::span<double> row) {
  double* out = row.data();  // kNavigationColumns values
  *out++ = time;
  *out++ = kDegreesPerRadian * n.position.latitude;
  *out++ = kDegreesPerRadian * n.position.longitude;
  *out++ = n.position.height;
  for (const Vector3d& v : {n.velocity, Vector3d(kDegreesPerRadian * n.euler), s.position, s.velocity,
                            Vector3d(kDegreesPerRadian * s.euler)}) {
    out = std::copy_n(v.data(), 3, out);
  }
}

void navigation_row(const Solution& solution, std::size_t i, std::span<double> row) {
  navigation_row(solution.time(i), solution.navigation(i), solution.navigation_sigmas(i), row);
}

std::vector<CsvColumn> bias_columns(const std::vector<Quantity>& quantities) {
  std::vector<CsvColumn> columns{{"time_s", kTimeDecimals}};
  for (const Quantity& q : quantities) {
    add_columns(columns, q, "");
    add_columns(columns, q, "sigma_");
  }
  return columns;
}

std::vector<CsvColumn> attitude_columns() {
  return {{"time_s", kTimeDecimals},
          {"roll_deg", kDegreeDecimals},
          {"pitch_deg", kDegreeDecimals},
          {"heading_deg", kDegreeDecimals},
          {"sigma_roll_deg", kDegreeDecimals},
          {"sigma_pitch_deg", kDegreeDecimals},
          {"sigma_heading_deg", kDegreeDecimals}};
}

void attitude_row(const Solution& solution, std::size_t i, std::span<double> row) {
  const Vector3d euler = kDegreesPerRadian * solution.navigation(i).euler,
                 sigma = kDegreesPerRadian * solution.navigation_sigmas(i).euler;
  row[0] = solution.time(i);
  std::copy_n(sigma.data(), 3, std::copy_n(euler.data(), 3, row.data() + 1));
}

// The same as numbers.
template <class Row>
NumberTable table_of(const std::vector<CsvColumn>& columns, const Solution& solution, double rate, const Row& fill) {
  NumberTable table;
  for (const CsvColumn& column : columns) table.names.push_back(column.name);
  const std::vector<std::size_t> rows = rows_at(solution, rate);
  table.values.resize(rows.size() * columns.size());
  std::span<double> left(table.values);
  for (const std::size_t i : rows) {
    fill(solution, i, left.first(columns.size()));
    left = left.subspan(columns.size());
  }
  return table;
}

// The output of a writer as one text.
template <class Write>
std::string text_of(Write&& write) {
  std::string text;
  write([&text](std::string_view piece) { text += piece; });
  return text;
}

}  // namespace

namespace row_csv {

namespace {

void add_three(std::vector<CsvColumn>& columns, std::string_view before, std::array<std::string_view, 3> axes,
               std::string_view unit, int decimals) {
  for (const std::string_view axis : axes) columns.push_back({fmt::format("{}{}{}", before, axis, unit), decimals});
}

}  // namespace

std::vector<CsvColumn> ExtraColumns::extras() const {
  constexpr int kMetres = 5, kRates = 6;
  constexpr std::array<std::string_view, 3> kXyz{"x", "y", "z"}, kNed{"north", "east", "down"};
  std::vector<CsvColumn> columns;
  if (extras_.sea_height) columns.push_back({"height_sea_m", kMetres});
  if (extras_.enu) add_three(columns, "", {"east", "north", "up"}, "_m", kMetres);
  if (extras_.ecef) add_three(columns, "ecef_", kXyz, "_m", kMetres);
  if (extras_.utm) {
    columns.insert(columns.end(), {{"utm_easting_m", kMetres}, {"utm_northing_m", kMetres}, {"utm_zone", 0}});
  }
  for (const int code : extras_.epsg) {
    for (const char* axis : {"easting", "northing"})
      columns.push_back({fmt::format("epsg_{}_{}_m", code, axis), kMetres});
  }
  if (extras_.speed) columns.insert(columns.end(), {{"speed_m_s", kMetres}, {"course_deg", kMetres}});
  if (extras_.acceleration) add_three(columns, "acceleration_", kNed, "_m_s2", kMetres);
  if (extras_.rates) {
    add_three(columns, "rate_", kXyz, "_deg_s", kRates);
    add_three(columns, "force_", kXyz, "_m_s2", kRates);
  }
  if (extras_.time == RowTime::kGpsWeek) columns.push_back({"gps_week", 0});
  if (extras_.time == RowTime::kUnix) columns.push_back({"time_unix_s", kTimeDecimals});
  return columns;
}

// `x`: of the body, for what its motion gives.
void ExtraColumns::fill(const World& world, double time, const Navigation& n, const Estimate* x,
                        std::span<double> row) {
  if (row.empty()) return;
  double* out = row.data();
  const auto put = [&out](const Vector3d& v) { out = std::copy_n(v.data(), 3, out); };
  if (extras_.sea_height) *out++ = n.position.height - geoid_undulation(n.position);
  if (extras_.enu) {
    const Vector3d p = world.from_geodetic(n.position);
    put({p.y(), p.x(), -p.z()});
  }
  if (extras_.ecef) {
    Vector3d p;
    GeographicLib::Geocentric::WGS84().Forward(kDegreesPerRadian * n.position.latitude,
                                               kDegreesPerRadian * n.position.longitude, n.position.height, p.x(),
                                               p.y(), p.z());
    put(p);
  }
  if (extras_.utm) {
    int zone = 0;
    bool north = true;
    double easting = 0, northing = 0;
    const int asked = zone_ ? std::abs(*zone_) : static_cast<int>(GeographicLib::UTMUPS::STANDARD);
    GeographicLib::UTMUPS::Forward(kDegreesPerRadian * n.position.latitude, kDegreesPerRadian * n.position.longitude,
                                   zone, north, easting, northing, asked);
    zone_ = north ? zone : -zone;
    put({easting, northing, static_cast<double>(*zone_)});
  }
  for (const auto& projection : projections_) {
    const Eigen::Vector2d place = projection->easting_northing(n.position);
    out = std::copy_n(place.data(), 2, out);
  }
  if (extras_.speed) {
    *out++ = std::hypot(n.velocity.x(), n.velocity.y());
    const double course = kDegreesPerRadian * std::atan2(n.velocity.y(), n.velocity.x());
    *out++ = course < 0 ? course + 360 : course;
  }
  if (extras_.needs_log()) {
    const auto [rate, force] = extras_.motion(time, *x);
    if (extras_.acceleration) {
      const Vector3d gravity = world.gravity(x->p_wb).value;
      put(world.rotation_wn(x->p_wb).transpose() *
          (x->R_wb() * force + gravity - 2 * world.earth_rate().cross(x->v_wb)));
    }
    if (extras_.rates) {
      put(kDegreesPerRadian * rate);
      put(force);
    }
  }
  if (extras_.time == RowTime::kGpsWeek) *out++ = *extras_.week;
  if (extras_.time == RowTime::kUnix) *out++ = unix_time({*extras_.week, time});
}

}  // namespace row_csv

struct RowCsv::Writer {
  Writer(RowFile file, const StateLayout& layout, double rate, TextSink sink, const RowExtras& more)
      : kind(file),
        biases{quantities_of(layout)},
        extras(file == RowFile::kNavigation ? more : RowExtras{}),
        columns(file == RowFile::kNavigation ? with_extras(navigation_columns(), extras.extras())
                : file == RowFile::kBiases   ? bias_columns(biases.quantities)
                                             : attitude_columns()),
        at(rate),
        row(columns.size()),
        waiting(columns.size()),
        csv(columns, std::move(sink), extras.text_column()) {}

  void fill(const Solution& rows, std::size_t i, std::span<double> to) const {
    switch (kind) {
      case RowFile::kNavigation:
        navigation_row(rows, i, to);
        return fill_extras(rows, i, to.subspan(kNavigationColumns));
      case RowFile::kBiases:
        return biases(rows, i, to);
      case RowFile::kAttitude:
        return attitude_row(rows, i, to);
    }
  }
  void fill_extras(const Solution& rows, std::size_t i, std::span<double> to) const {
    if (to.empty()) return;
    const Estimate x = extras.needs_estimate() ? rows.estimate(i) : Estimate{};
    extras.fill(rows.world(), rows.time(i), rows.navigation(i), &x, to);
  }
  void write(const Solution& rows, std::size_t i) {
    fill(rows, i, row);
    csv.row(row, extras.text(row));
  }

  void add(const Solution& rows) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (at.all()) {
        write(rows, i);
      } else if (at.next(rows.time(i))) {
        if (i > 0) {
          write(rows, i - 1);
        } else {
          csv.row(waiting, extras.text(waiting));
        }
      }
    }
    // The next piece decides whether its last row is written.
    if (!at.all() && !rows.empty()) fill(rows, rows.size() - 1, waiting);
  }

  void finish() {
    if (!at.all() && at.last()) csv.row(waiting, extras.text(waiting));
    csv.finish();
  }

  RowFile kind;
  BiasRow biases;
  mutable ExtraColumns extras;  // remembers a zone
  std::vector<CsvColumn> columns;
  RowRate at;
  std::vector<double> row, waiting;  // `waiting`: the last row so far
  CsvWriter csv;
};

struct PlaceCsv::Writer {
  Writer(const RowExtras& more, World of, TextSink sink)
      : extras(more),
        world(std::move(of)),
        row(with_extras(navigation_columns(), extras.extras()).size()),
        csv(with_extras(navigation_columns(), extras.extras()), std::move(sink), extras.text_column()) {}
  row_csv::ExtraColumns extras;
  World world;
  std::vector<double> row;
  CsvWriter csv;
};

PlaceCsv::PlaceCsv(const RowExtras& extras, const World& world, TextSink sink)
    : writer_(std::make_unique<Writer>(extras, world, std::move(sink))) {}
PlaceCsv::~PlaceCsv() = default;
void PlaceCsv::add(double time, const Navigation& n, const NavigationSigmas& sigmas) {
  std::vector<double>& row = writer_->row;
  navigation_row(time, n, sigmas, row);
  writer_->extras.fill(writer_->world, time, n, nullptr, std::span(row).subspan(kNavigationColumns));
  writer_->csv.row(row, writer_->extras.text(row));
}
void PlaceCsv::finish() { writer_->csv.finish(); }

RowCsv::RowCsv(RowFile kind, const StateLayout& layout, double rate, TextSink sink, const RowExtras& extras)
    : writer_(std::make_unique<Writer>(kind, layout, rate, std::move(sink), extras)) {}
RowCsv::~RowCsv() = default;
RowCsv::RowCsv(RowCsv&&) noexcept = default;
RowCsv& RowCsv::operator=(RowCsv&&) noexcept = default;
void RowCsv::add(const Solution& rows) { writer_->add(rows); }
void RowCsv::finish() { writer_->finish(); }

namespace {

void write_rows(RowFile kind, const Solution& solution, double rate, const TextSink& sink,
                const RowExtras& extras = {}) {
  RowCsv csv(kind, solution.layout(), rate, sink, extras);
  csv.add(solution);
  csv.finish();
}

}  // namespace

std::string navigation_csv(const Solution& solution) {
  return text_of([&](const TextSink& sink) { navigation_csv(solution, 0, sink); });
}

std::string biases_csv(const Solution& solution) {
  return text_of([&](const TextSink& sink) { biases_csv(solution, 0, sink); });
}

std::string innovations_csv(const Solution& solution) {
  return text_of([&](const TextSink& sink) { innovations_csv(solution, sink); });
}

void navigation_csv(const Solution& solution, double rate, const TextSink& sink, const RowExtras& extras) {
  write_rows(RowFile::kNavigation, solution, rate, sink, extras);
}

NumberTable navigation_table(const Solution& solution, double rate) {
  return table_of(navigation_columns(), solution, rate,
                  [](const Solution& rows, std::size_t i, std::span<double> row) { navigation_row(rows, i, row); });
}

AttitudeRecording attitude_recording(const Solution& solution, double rate) {
  AttitudeRecording out;
  for (const std::size_t i : rows_at(solution, rate)) {
    out.fixes.push_back({solution.time(i), solution.navigation(i).euler, solution.navigation_sigmas(i).euler});
  }
  return out;
}

std::string attitude_csv(const Solution& solution, double rate) {
  return text_of([&](const TextSink& sink) { write_rows(RowFile::kAttitude, solution, rate, sink); });
}

void biases_csv(const Solution& solution, double rate, const TextSink& sink) {
  write_rows(RowFile::kBiases, solution, rate, sink);
}

NumberTable biases_table(const Solution& solution, double rate) {
  const std::vector<Quantity> quantities = quantities_of(solution.layout());
  return table_of(bias_columns(quantities), solution, rate, BiasRow{quantities});
}

void innovations_csv(const Solution& solution, const TextSink& sink) {
  constexpr std::size_t kPieceOfInnovations = 1000;  // rows that go to the sink at once
  std::string text = "time_s,source,residual_1,residual_2,residual_3,sigma_1,sigma_2,sigma_3,nis,gate,outcome\n";
  std::size_t row = 0;
  for (const Innovation& v : solution.innovations) {
    append_fixed(text, v.time, kTimeDecimals);
    text += ',';
    text += solution.sources[static_cast<std::size_t>(v.source)];
    for (const Vector3d& values : {v.residual, v.sigma}) {
      for (int k = 0; k < 3; ++k) {
        text += ',';
        if (v.has(k)) fmt::format_to(std::back_inserter(text), FMT_COMPILE("{:.6g}"), values[k]);
      }
    }
    fmt::format_to(std::back_inserter(text), FMT_COMPILE(",{:.6g},{:.6g},{}\n"), v.nis, v.gate,
                   outcome_name(v.outcome));
    if (++row % kPieceOfInnovations > 0) continue;
    sink(text);
    text.clear();
  }
  sink(text);
}

std::string adapted_csv(const AdaptedNoise& adapted) {
  std::string text = "time_s";
  for (const std::string& name : adapted.names) text += "," + name;
  text += '\n';
  for (std::size_t row = 0; row < adapted.time.size(); ++row) {
    append_fixed(text, adapted.time[row], kTimeDecimals);
    for (std::size_t k = 0; k < adapted.names.size(); ++k) {
      fmt::format_to(std::back_inserter(text), ",{:.5g}", adapted.factor(row, k));
    }
    text += '\n';
  }
  return text;
}

}  // namespace piste
