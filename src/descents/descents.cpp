#include "piste/descents/descents.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "descents/course.h"
#include "io/text_reader.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "points/placed.h"
#include "smoother/lagged_errors.h"

namespace piste {
namespace {

const OutputPoint& point_of(const ReplayConfig& config, const std::string& at) {
  static const OutputPoint kImu;
  if (at.empty()) return kImu;
  if (const OutputPoint* point = config.output.point(at)) return *point;
  throw ConfigError(config.file.string(),
                    fmt::format("has no point `{0}`; name it: `output: {{at: {{{0}: 0 0 -0.4 m}}}}`", at));
}

// All rows of a run, of one point.
Trajectory track_of(const Replay& run, const OutputPoint& point, const std::string& file) {
  Trajectory track;
  track.file = file;
  std::vector<std::size_t> rows(run.solution().size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
  track.time.resize(rows.size());
  track.place.resize(rows.size());
  track.velocity.resize(rows.size());
  track.attitude.resize(rows.size());
  placed_rows(run, rows, [&](std::size_t row, const PlacedState& state) {
    const PlacedPoint placed = place(run.log.world, state, point);
    track.time[row] = placed.time;
    track.place[row] = placed.navigation.position;
    track.velocity[row] = placed.navigation.velocity;
    track.attitude[row] = from_euler(placed.navigation.euler);
  });
  return track;
}

// The numbers of the filter's error: δp along east, north, up of a point on the body is ρ + θ × R l in w.
std::vector<ErrorNumber> numbers_of(const Descent& run, const std::vector<CrossingError>& errors) {
  const Replay& replay = *run.replay;
  const Solution& solution = replay.solution();
  std::vector<ErrorNumber> numbers;
  for (const CrossingError& error : errors) {
    const Estimate x = solution.estimate(error.row + run.first_row);
    const Matrix3d R_wn = solution.world().rotation_wn(x.p_wb);
    const Vector3d along = R_wn * Vector3d(error.factor.y(), error.factor.x(), -error.factor.z()),
                   arm = x.R_wb() * run.point.lever_arm;
    ErrorNumber number{.row = error.row + run.first_row};
    number.a.head<3>() = along;
    number.a.segment<3>(full_offset(Block::kAttitude)) = arm.cross(along);
    numbers.push_back(number);
  }
  return numbers;
}

// A plane with the crossings of all runs.
struct Crossed {
  Passage passage;
  std::vector<PlaneCrossing> at;
  std::vector<CrossingError> errors;
};

constexpr double kGravity = kStandardGravity;

Crossing crossing_of(const PlaneCrossing& at, double height) {
  Crossing c;
  c.time = at.time;
  c.offset = at.offset;
  c.speed = at.velocity.norm();
  c.height = height;
  const double bend = at.velocity.cross(at.acceleration).norm();
  c.radius = bend > 0 ? std::pow(c.speed, 3) / bend : kNaN;
  c.load = (at.acceleration + Vector3d(0, 0, kGravity)).norm() / kGravity;
  c.sigma_time = c.sigma_gained = kNaN;
  return c;
}

// Crossings of one plane by all runs. Throws if a run does not cross.
Crossed cross(const std::vector<Descent>& runs, const std::vector<CoursePath>& paths, const CoursePlane& plane,
              const std::string& name, double distance, double origin_height) {
  Crossed out;
  out.passage = {.name = name, .distance = distance, .place = plane.place, .direction = plane.direction, .runs = {}};
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const auto at = crossing(paths[r], plane);
    if (!at) {
      throw DataError(runs[r].track.file,
                      name.empty()
                          ? fmt::format("the run `{}` does not cross the line's plane at {:.1f} m forwards; do "
                                        "all runs follow one course?",
                                        runs[r].name, distance)
                          : fmt::format("the run `{}` does not cross the gate `{}` forwards; are the gates in "
                                        "the order passed, and of this course?",
                                        runs[r].name, name));
    }
    out.at.push_back(*at);
    out.errors.push_back({at->row, -plane.direction / plane.direction.dot(at->velocity)});
    out.passage.runs.push_back(crossing_of(*at, origin_height + at->position.z()));
  }
  return out;
}

// Times gained since the first passage.
void set_gained(std::vector<Crossed>& all) {
  const std::vector<Crossing> first = all.front().passage.runs;
  for (Crossed& crossed : all) {
    std::vector<Crossing>& runs = crossed.passage.runs;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      runs[r].gained = (runs[0].time - first[0].time) - (runs[r].time - first[r].time);
    }
  }
}

// Variances of times of one run, and covariances of those at gates with all later ones.
class TimeErrors {
 public:
  // `gates` first, then the places along the line.
  TimeErrors(const Descent& run, std::size_t r, const std::vector<Crossed>& gates, const std::vector<Crossed>& along)
      : of_gates_(gates.size()) {
    std::vector<CrossingError> errors;
    for (const std::vector<Crossed>* list : {&gates, &along}) {
      for (const Crossed& c : *list) errors.push_back(c.errors[r]);
    }
    std::vector<std::size_t> order(errors.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return errors[a].row < errors[b].row; });
    std::vector<CrossingError> sorted;
    std::vector<std::size_t> early;
    rank_.resize(errors.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      rank_[order[k]] = k;
      sorted.push_back(errors[order[k]]);
      if (order[k] <= of_gates_) early.push_back(k);  // gates, and the line's place at the first gate
    }
    variances_ = run.variances(sorted);
    covariances_ = run.covariances(sorted, early);
    early_ = std::move(early);
  }
  double variance(std::size_t i) const { return variances_[rank_[i]]; }
  // Of the difference between two times. The earlier one is a gate or the first place of the line; if it is none, as on
  // a way that goes back, they are taken as independent, which is more than it can be.
  double variance(std::size_t i, std::size_t j) const {
    const std::size_t a = std::min(rank_[i], rank_[j]), b = std::max(rank_[i], rank_[j]);
    const auto at = std::lower_bound(early_.begin(), early_.end(), a);
    const bool known = at != early_.end() && *at == a;
    const double both = known ? covariances_(at - early_.begin(), static_cast<Eigen::Index>(b)) : 0;
    return i == j ? 0 : std::max(0.0, variances_[a] + variances_[b] - 2 * both);
  }

 private:
  std::size_t of_gates_;
  std::vector<std::size_t> rank_, early_;
  std::vector<double> variances_;
  Eigen::MatrixXd covariances_;
};

// Covariances between all crossings of two laps of one replay.
class LapErrors {
 public:
  // `gates` first, then the places along the line; of the first lap, then of the other.
  LapErrors(const std::vector<Descent>& runs, std::size_t r, const std::vector<Crossed>& gates,
            const std::vector<Crossed>& along)
      : of_lap_(gates.size() + along.size()) {
    std::vector<ErrorNumber> numbers;
    for (const std::size_t lap : {std::size_t{0}, r}) {
      std::vector<CrossingError> errors;
      for (const std::vector<Crossed>* list : {&gates, &along}) {
        for (const Crossed& c : *list) errors.push_back(c.errors[lap]);
      }
      const std::vector<ErrorNumber> of_one = numbers_of(runs[lap], errors);
      numbers.insert(numbers.end(), of_one.begin(), of_one.end());
    }
    std::vector<std::size_t> order(numbers.size()), all(numbers.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = all[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return numbers[a].row < numbers[b].row; });
    rank_.resize(order.size());
    std::vector<ErrorNumber> sorted;
    for (std::size_t k = 0; k < order.size(); ++k) {
      rank_[order[k]] = static_cast<Eigen::Index>(k);
      sorted.push_back(numbers[order[k]]);
    }
    covariances_ = lagged_covariances(runs.front().replay->smoothable(), sorted, all);
  }
  // Of the time that the other lap gained from the crossing i to the crossing j.
  double variance(std::size_t i, std::size_t j) const {
    const std::array<std::pair<std::size_t, double>, 4> terms{{{j, 1}, {i, -1}, {of_lap_ + j, -1}, {of_lap_ + i, 1}}};
    double sum = 0;
    for (const auto& [a, of_a] : terms) {
      for (const auto& [b, of_b] : terms) {
        sum += of_a * of_b * covariances_(std::min(rank_[a], rank_[b]), std::max(rank_[a], rank_[b]));
      }
    }
    return std::max(0.0, sum);
  }

 private:
  std::size_t of_lap_;
  std::vector<Eigen::Index> rank_;
  Eigen::MatrixXd covariances_;
};

// Sigmas from the columns of a folder: of times alone.
void set_folder_sigmas(const Descent& run, std::size_t r, std::vector<Crossed>& all, double common) {
  if (run.track.sigma_position.empty()) return;
  for (Crossed& c : all) {
    const Vector3d& sigma = run.track.sigma_position[c.errors[r].row];  // north, east, down
    const Vector3d& f = c.errors[r].factor;
    c.passage.runs[r].sigma_time =
        std::sqrt(square(f.x() * sigma.y()) + square(f.y() * sigma.x()) + square(common) * f.squaredNorm());
  }
}

struct Sigmas2 {  // variances of gained times of each run since the first gate, and in the section before
  std::vector<double> gates, along, sections;
};

Sigmas2 set_replay_sigmas(const Descent& run, std::size_t r, std::vector<Crossed>& gates, std::vector<Crossed>& along,
                          double common) {
  const TimeErrors errors(run, r, gates, along);
  Sigmas2 out;
  const std::size_t n = gates.size();
  const auto set = [&](Crossed& c, std::size_t i) {
    c.passage.runs[r].sigma_time = std::sqrt(errors.variance(i) + square(common) * c.errors[r].factor.squaredNorm());
  };
  for (std::size_t i = 0; i < n; ++i) {
    set(gates[i], i);
    out.gates.push_back(errors.variance(0, i));
    if (i > 0) out.sections.push_back(errors.variance(i - 1, i));
  }
  for (std::size_t i = 0; i < along.size(); ++i) {
    set(along[i], n + i);
    out.along.push_back(errors.variance(n, n + i));
  }
  return out;
}

// Variances of what the lap r gained on the first lap.
Sigmas2 gained_between_laps(const std::vector<Descent>& runs, std::size_t r, const std::vector<Crossed>& gates,
                            const std::vector<Crossed>& along) {
  const LapErrors errors(runs, r, gates, along);
  Sigmas2 out;
  const std::size_t n = gates.size();
  for (std::size_t i = 0; i < n; ++i) {
    out.gates.push_back(errors.variance(0, i));
    if (i > 0) out.sections.push_back(errors.variance(i - 1, i));
  }
  for (std::size_t i = 0; i < along.size(); ++i) out.along.push_back(errors.variance(n, n + i));
  return out;
}

CourseLine line_of(const std::vector<Descent>& runs, const std::vector<CoursePath>& paths,
                   const DescentOptions& options, DescentReport& report) {
  const std::string name = options.line.empty() ? runs.front().name : options.line;
  report.line = name;
  const auto named = std::find_if(runs.begin(), runs.end(), [&](const Descent& d) { return d.name == name; });
  const bool mean_line = named == runs.end() && name == "mean";
  if (named == runs.end() && !mean_line) {
    throw ConfigError("--line",
                      fmt::format("`{}` is no run; the runs are: {}; or mean", name, fmt::join(report.runs, ", ")));
  }
  CourseLine base(paths[mean_line ? 0 : static_cast<std::size_t>(named - runs.begin())].position);
  report.how_line = fmt::format("the path of {}", name);
  if (!mean_line) return base;
  // At each metre of the first run's path the mean of the places where all runs cross its normal plane.
  std::vector<Vector3d> points;
  for (double s = 0; s <= base.length(); s += options.step) {
    const CoursePlane plane{base.at(s), base.direction(s)};
    Vector3d sum = Vector3d::Zero();
    std::size_t count = 0;
    for (const CoursePath& path : paths) {
      if (const auto at = crossing(path, plane)) {
        sum += at->position;
        ++count;
      }
    }
    if (count == paths.size()) points.emplace_back(sum / static_cast<double>(count));
  }
  report.how_line =
      fmt::format("the mean of all runs where they cross the planes normal to the path of {}, each {:g} m",
                  runs.front().name, options.step);
  return CourseLine(points);
}

// The plane of a gate, and where it is on the line.
struct PlacedGate {
  std::string name;
  double distance;
  CoursePlane plane;
};

std::vector<PlacedGate> placed_gates(const std::vector<Gate>& gates, const CourseLine& line, const EnuFrame& frame,
                                     double height) {
  std::vector<PlacedGate> placed;
  for (const Gate& gate : gates) {
    const Vector3d place = frame.place({gate.place.latitude, gate.place.longitude, height});
    const double s = line.nearest(place);
    CoursePlane plane{place, line.direction(s)};
    if (gate.heading) plane.direction = {std::sin(*gate.heading), std::cos(*gate.heading), 0};
    placed.push_back({gate.name, s, plane});
  }
  if (!gates.empty()) return placed;
  for (const double s : apexes(line)) {
    placed.push_back({fmt::format("turn_{}", placed.size() + 1), s, {line.at(s), line.direction(s)}});
  }
  return placed;
}

constexpr double kShortestLap = 1;  // m: of less no line is made

// Rows `first` to `end` − 1.
Trajectory rows_of(const Trajectory& track, std::size_t first, std::size_t end) {
  Trajectory part = track;
  const auto cut = [&](auto& column) {
    if (column.empty()) return;
    column.erase(column.begin() + static_cast<std::ptrdiff_t>(end), column.end());
    column.erase(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(first));
  };
  cut(part.time);
  cut(part.place);
  cut(part.velocity);
  cut(part.attitude);
  cut(part.sigma_position);
  cut(part.sigma_velocity);
  cut(part.sigma_euler);
  cut(part.covariance);
  return part;
}

void check_runs(const std::vector<Descent>& runs) {
  if (runs.empty()) throw ConfigError("", "two runs at least are compared");
  std::set<std::string> names;
  for (const Descent& run : runs) {
    if (!names.insert(run.name).second) {
      throw ConfigError("", fmt::format("two runs are called `{}`; name them: NAME=RUN", run.name));
    }
    if (run.track.velocity.empty()) throw DataError(run.track.file, "has no velocities");
  }
}

}  // namespace

Eigen::MatrixXd Descent::covariances(const std::vector<CrossingError>& errors,
                                     const std::vector<std::size_t>& early) const {
  return lagged_covariances(replay->smoothable(), numbers_of(*this, errors), early);
}

std::vector<double> Descent::variances(const std::vector<CrossingError>& errors) const {
  return piste::variances(replay->smoothable(), numbers_of(*this, errors));
}

Descent descent_of(const ReplayConfig& config, const std::string& at, std::string name) {
  Descent run;
  run.name = name.empty() ? config.file.stem().string() : std::move(name);
  run.point = point_of(config, at);
  if (config.smoother != SmootherKind::kRts) {
    throw ConfigError(config.file.string(), "descents need `smoother: rts`, for the covariance of two crossings");
  }
  ReplayOptions options = replay_options(config);
  options.history = true;
  run.replay = std::make_shared<const Replay>(replay(read_recording(config), options));
  run.track = track_of(*run.replay, run.point, config.file.string());
  return run;
}

Descent descent_of(const std::filesystem::path& folder, const std::string& at, std::string name) {
  Descent run;
  run.name = name.empty() ? std::filesystem::weakly_canonical(folder).filename().string() : std::move(name);
  run.track = read_trajectory({.path = folder, .format = {}, .at = at});
  return run;
}

std::vector<Gate> read_gates(const std::filesystem::path& file) {
  TextReader reader(file.string(), TextReader::Separator::kComma);
  if (!reader.next())
    throw DataError(file.string() + ":1", "the file is empty; name,latitude_deg,longitude_deg is expected");
  const std::vector<std::string> names(reader.fields().begin(), reader.fields().end());
  const auto find = [&](std::string_view name) -> std::optional<std::size_t> {
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - names.begin()));
  };
  const auto require = [&](std::string_view name) {
    if (const auto column = find(name)) return *column;
    throw DataError(file.string() + ":1",
                    fmt::format("column {} is missing; the columns are: {}", name, fmt::join(names, ", ")));
  };
  const auto name = require("name"), latitude = require("latitude_deg"), longitude = require("longitude_deg");
  const auto heading = find("heading_deg");
  for (const std::string& column : names) {
    if (column != "name" && column != "latitude_deg" && column != "longitude_deg" && column != "heading_deg") {
      throw DataError(file.string() + ":1",
                      fmt::format("unknown column `{}`; known are name, latitude_deg, longitude_deg, "
                                  "heading_deg",
                                  column));
    }
  }
  std::vector<Gate> gates;
  while (reader.next()) {
    if (reader.fields().size() != names.size()) {
      reader.fail(fmt::format("{} fields, but the header names {} columns; is the line cut?", reader.fields().size(),
                              names.size()),
                  RowFault::Kind::kFields);
    }
    Gate gate{.name = std::string(reader.fields()[name]),
              .place = {kDegree * reader.number(latitude), kDegree * reader.number(longitude), 0}};
    if (heading && !reader.fields()[*heading].empty()) gate.heading = kDegree * reader.number(*heading);
    gates.push_back(std::move(gate));
  }
  if (gates.size() < 2) throw DataError(file.string(), "two gates at least are needed: a start and a finish");
  return gates;
}

namespace {

// The laps of a run, and the plane in which they begin and end.
struct Laps {
  std::vector<Descent> runs;
  Gate start;
};

Laps find_laps(const Descent& run, const std::vector<Gate>& gates) {
  const EnuFrame frame(run.track.place.front());
  const double height = run.track.place.front().height;
  const CoursePath path = path_of(run, frame);
  if (CourseLine(path.position).length() < 2 * kShortestLap) return {};
  const CoursePlane start = gates.empty()
                                ? most_passed(path)
                                : placed_gates({gates.front()}, CourseLine(path.position), frame, height).front().plane;
  Laps laps;
  laps.start = {.name = gates.empty() ? "start" : gates.front().name,
                .place = frame.geodetic(start.place),
                .heading = std::atan2(start.direction.x(), start.direction.y())};
  const std::vector<std::size_t> begins = passes(path, start);
  std::vector<PlacedGate> placed;
  constexpr std::size_t kMore = 2;  // rows on either side, so that rounding loses no crossing
  for (std::size_t k = 0; k + 1 < begins.size(); ++k) {
    const std::size_t first = begins[k] - std::min<std::size_t>(begins[k], kMore - 1),
                      end = std::min(begins[k + 1] + 1 + kMore, path.time.size());
    Descent lap{.name = fmt::format("{}_{}", run.name, laps.runs.size() + 1),
                .track = rows_of(run.track, first, end),
                .replay = run.replay,
                .point = run.point,
                .first_row = run.first_row + first};
    const CoursePath of_lap = path_of(lap, frame);
    const CourseLine line(of_lap.position);
    if (line.length() < 2 * kShortestLap) continue;
    if (laps.runs.empty()) placed = placed_gates(gates, line, frame, height);
    const bool whole = std::all_of(placed.begin(), placed.end(),
                                   [&](const PlacedGate& gate) { return crossing(of_lap, gate.plane).has_value(); });
    if (whole) laps.runs.push_back(std::move(lap));
  }
  return laps;
}

// Gates of laps: the first one is where they begin, and the last one, `lap`, is the same line after the round.
std::vector<PlacedGate> around(std::vector<PlacedGate> placed, const Gate& start, bool is_first, const CourseLine& line,
                               const EnuFrame& frame, double height) {
  PlacedGate begin = placed_gates({start}, line, frame, height).front(), end = begin;
  const auto ahead = [&](double s) { return begin.plane.direction.dot(begin.plane.place - line.at(s)); };
  begin.distance = std::max(0.0, ahead(0));
  begin.plane.pass = CoursePlane::Pass::kFirst;
  end.name = "lap";
  end.distance = std::min(line.length(), line.length() + ahead(line.length()));
  end.plane.pass = CoursePlane::Pass::kLast;
  if (is_first) placed.erase(placed.begin());
  placed.insert(placed.begin(), std::move(begin));
  placed.push_back(std::move(end));
  return placed;
}

DescentReport compare(const std::vector<Descent>& runs, const std::vector<Gate>& gates, const DescentOptions& options,
                      const std::optional<Gate>& start) {
  DescentReport report;
  report.runs.reserve(runs.size());
  for (const Descent& run : runs) report.runs.push_back(run.name);
  const Geodetic& origin = runs.front().track.place.front();
  const EnuFrame frame(origin);
  std::vector<CoursePath> paths;
  paths.reserve(runs.size());
  for (const Descent& run : runs) paths.push_back(path_of(run, frame));
  const CourseLine line = line_of(runs, paths, options, report);
  std::vector<PlacedGate> placed = placed_gates(gates, line, frame, origin.height);
  if (start) placed = around(std::move(placed), *start, !gates.empty(), line, frame, origin.height);
  if (placed.size() < 2)
    throw DataError(runs.front().track.file, "fewer than two turns are found; name the gates: --gates FILE");

  std::vector<Crossed> at_gates, along;
  const double first = placed.front().distance, last = placed.back().distance;
  for (const PlacedGate& gate : placed) {
    at_gates.push_back(cross(runs, paths, gate.plane, gate.name, gate.distance - first, origin.height));
  }
  const auto steps = static_cast<int>(std::ceil((last - first) / options.step));
  for (int k = 0; k <= steps; ++k) {
    const double s = first + (last - first) * k / std::max(1, steps);
    CoursePlane plane{line.at(s), line.direction(s)};
    if (start) plane.pass = 2 * s < first + last ? CoursePlane::Pass::kFirst : CoursePlane::Pass::kLast;
    along.push_back(cross(runs, paths, plane, "", s - first, origin.height));
  }
  set_gained(at_gates);
  set_gained(along);

  std::vector<Sigmas2> sigmas(runs.size());
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (runs[r].replay) {
      sigmas[r] = set_replay_sigmas(runs[r], r, at_gates, along, options.common);
    } else {
      report.without_sigma.push_back(runs[r].name);
      set_folder_sigmas(runs[r], r, at_gates, options.common);
      set_folder_sigmas(runs[r], r, along, options.common);
    }
  }
  // Two runs are independent; two laps of one replay are not.
  std::vector<Sigmas2> laps(runs.size());
  for (std::size_t r = 1; r < runs.size(); ++r) {
    if (runs[r].replay && runs[r].replay == runs[0].replay) laps[r] = gained_between_laps(runs, r, at_gates, along);
  }
  const auto together = [&](std::size_t r, std::vector<double> Sigmas2::*of, std::size_t i) {
    if (r == 0) return 0.0;
    if (!(laps[r].*of).empty()) return std::sqrt((laps[r].*of)[i]);
    if (!runs[r].replay || !runs[0].replay) return kNaN;
    return std::sqrt((sigmas[0].*of)[i] + (sigmas[r].*of)[i]);
  };
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (std::size_t i = 0; i < at_gates.size(); ++i)
      at_gates[i].passage.runs[r].sigma_gained = together(r, &Sigmas2::gates, i);
    for (std::size_t i = 0; i < along.size(); ++i)
      along[i].passage.runs[r].sigma_gained = together(r, &Sigmas2::along, i);
  }
  for (std::size_t i = 1; i < at_gates.size(); ++i) {
    const Passage &from = at_gates[i - 1].passage, &to = at_gates[i].passage;
    Section section{from.name, to.name, to.distance - from.distance, {}, {}, {}};
    for (std::size_t r = 0; r < runs.size(); ++r) {
      section.duration.push_back(to.runs[r].time - from.runs[r].time);
      section.gained.push_back(section.duration[0] - section.duration[r]);
      section.sigma.push_back(together(r, &Sigmas2::sections, i - 1));
    }
    report.sections.push_back(std::move(section));
  }
  for (Crossed& c : at_gates) report.gates.push_back(std::move(c.passage));
  for (Crossed& c : along) report.along.push_back(std::move(c.passage));
  return report;
}

}  // namespace

std::vector<Descent> laps_of(const Descent& run, const std::vector<Gate>& gates) { return find_laps(run, gates).runs; }

DescentReport compare_descents(const std::vector<Descent>& runs, const std::vector<Gate>& gates,
                               const DescentOptions& options) {
  check_runs(runs);
  if (runs.size() > 1) return compare(runs, gates, options, std::nullopt);
  const Laps laps = find_laps(runs.front(), gates);
  if (laps.runs.size() < 2) {
    throw ConfigError("", fmt::format("two runs at least are compared, or the laps of one; `{}` does not pass its "
                                      "start{} three times and all gates in between",
                                      runs.front().name, gates.empty() ? "" : " `" + gates.front().name + "`"));
  }
  return compare(laps.runs, gates, options, laps.start);
}

}  // namespace piste
