#include "piste/io/solution_io.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "io/csv.h"
#include "piste/math/units.h"
#include "quantity.h"

namespace piste {

// What RowCsv holds.
namespace row_csv {

// Which rows are written at a rate [Hz], 0 being that of the IMU. An epoch is taken if neither of its neighbours is
// nearer to the same multiple of 1 / rate.
class AtRate {
 public:
  explicit AtRate(double rate) : rate_(rate) {}
  bool all() const { return rate_ == 0; }
  /// The next row's time. Returns whether the row before it is written.
  bool next(double time) {
    const double at = time * rate_, place = std::round(at), off = std::abs(at - place);
    const bool rival = place == place_, taken = waits_ && !beaten_ && !(rival && off < off_);
    beaten_ = waits_ && rival && off_ <= off;
    waits_ = true;
    place_ = place;
    off_ = off;
    return taken;
  }
  /// Whether the last row is written.
  bool last() const { return waits_ && !beaten_; }

 private:
  double rate_, place_ = 0, off_ = 0;
  bool waits_ = false, beaten_ = false;
};

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

}  // namespace row_csv

namespace {

using row_csv::AtRate, row_csv::BiasRow;

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

std::vector<std::size_t> rows_at(const Solution& solution, double rate) {
  std::vector<std::size_t> rows;
  AtRate at(rate);
  for (std::size_t i = 0; i < solution.size(); ++i) {
    if (at.all()) {
      rows.push_back(i);
    } else if (at.next(solution.time(i))) {
      rows.push_back(i - 1);
    }
  }
  if (!at.all() && at.last()) rows.push_back(solution.size() - 1);
  return rows;
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

void navigation_row(const Solution& solution, std::size_t i, std::span<double> row) {
  const Navigation n = solution.navigation(i);
  const NavigationSigmas s = solution.navigation_sigmas(i);
  double* out = row.data();
  *out++ = solution.time(i);
  *out++ = kDegreesPerRadian * n.position.latitude;
  *out++ = kDegreesPerRadian * n.position.longitude;
  *out++ = n.position.height;
  for (const Vector3d& v : {n.velocity, Vector3d(kDegreesPerRadian * n.euler), s.position, s.velocity,
                            Vector3d(kDegreesPerRadian * s.euler)}) {
    out = std::copy_n(v.data(), 3, out);
  }
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

struct RowCsv::Writer {
  Writer(RowFile file, const StateLayout& layout, double rate, TextSink sink)
      : kind(file),
        biases{quantities_of(layout)},
        columns(file == RowFile::kNavigation ? navigation_columns()
                : file == RowFile::kBiases   ? bias_columns(biases.quantities)
                                             : attitude_columns()),
        at(rate),
        row(columns.size()),
        waiting(columns.size()),
        csv(columns, std::move(sink)) {}

  void fill(const Solution& rows, std::size_t i, std::span<double> to) const {
    switch (kind) {
      case RowFile::kNavigation:
        return navigation_row(rows, i, to);
      case RowFile::kBiases:
        return biases(rows, i, to);
      case RowFile::kAttitude:
        return attitude_row(rows, i, to);
    }
  }
  void write(const Solution& rows, std::size_t i) {
    fill(rows, i, row);
    csv.row(row);
  }

  void add(const Solution& rows) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (at.all()) {
        write(rows, i);
      } else if (at.next(rows.time(i))) {
        if (i > 0) {
          write(rows, i - 1);
        } else {
          csv.row(waiting);
        }
      }
    }
    // The next piece decides whether its last row is written.
    if (!at.all() && !rows.empty()) fill(rows, rows.size() - 1, waiting);
  }

  void finish() {
    if (!at.all() && at.last()) csv.row(waiting);
    csv.finish();
  }

  RowFile kind;
  BiasRow biases;
  std::vector<CsvColumn> columns;
  AtRate at;
  std::vector<double> row, waiting;  // `waiting`: the last row so far
  CsvWriter csv;
};

RowCsv::RowCsv(RowFile kind, const StateLayout& layout, double rate, TextSink sink)
    : writer_(std::make_unique<Writer>(kind, layout, rate, std::move(sink))) {}
RowCsv::~RowCsv() = default;
RowCsv::RowCsv(RowCsv&&) noexcept = default;
RowCsv& RowCsv::operator=(RowCsv&&) noexcept = default;
void RowCsv::add(const Solution& rows) { writer_->add(rows); }
void RowCsv::finish() { writer_->finish(); }

namespace {

void write_rows(RowFile kind, const Solution& solution, double rate, const TextSink& sink) {
  RowCsv csv(kind, solution.layout(), rate, sink);
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

void navigation_csv(const Solution& solution, double rate, const TextSink& sink) {
  write_rows(RowFile::kNavigation, solution, rate, sink);
}

NumberTable navigation_table(const Solution& solution, double rate) {
  return table_of(navigation_columns(), solution, rate, navigation_row);
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
