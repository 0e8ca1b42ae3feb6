/// The filter and the live session, sample by sample or in batches.

#include <fmt/format.h>
#include <nanobind/eigen/dense.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>

#include "bindings.h"
#include "core/fix_faults.h"
#include "piste/core/error.h"
#include "piste/live/live.h"
#include "piste/model/measurement_list.h"
#include "piste/replay/replay.h"
#include "run.h"

namespace piste::python {
namespace {

using Times = nb::ndarray<const double, nb::ndim<1>, nb::device::cpu>;
using Three = std::array<double, 3>;
using Triples = nb::ndarray<const double, nb::shape<-1, 3>, nb::device::cpu>;

Vector3d row(const Triples& of, std::size_t i) { return {of(i, 0), of(i, 1), of(i, 2)}; }

void require_rows(const char* what, std::size_t rows, std::initializer_list<std::size_t> others) {
  for (const std::size_t other : others) {
    if (other == rows) continue;
    throw DataError(what, fmt::format("`time` has {} rows, and another array {}; all need as many", rows, other));
  }
}

std::string type_of(const nb::handle value) { return nb::cast<std::string>(value.type().attr("__name__")); }

[[noreturn]] void refuse(const char* what, const char* name, const char* expected, const nb::handle value) {
  throw DataError(what, fmt::format("`{}`: {} expected, not {}", name, expected, type_of(value)));
}

// Numbers of any type as an array of float64, converted by numpy. float32 resolves times of a week to 0.03 s only.
template <class Array>
Array array_of(const char* what, const char* name, const nb::handle value, bool is_time = false) {
  constexpr bool kTriples = std::is_same_v<Array, Triples>;
  Array array;
  if (nb::try_cast(value, array, false)) return array;
  try {
    const nb::module_ numpy = nb::module_::import_("numpy");
    const nb::object given = numpy.attr("asarray")(value);
    const auto kind = nb::cast<std::string>(given.attr("dtype").attr("kind"));
    const auto bytes = nb::cast<int>(given.attr("dtype").attr("itemsize"));
    if (is_time && kind == "f" && bytes < 8) {
      throw DataError(what, fmt::format("`{}` is float{}, which tells times of a week to 0.03 s or worse; make it "
                                        "float64",
                                        name, 8 * bytes));
    }
    const bool numbers = kind == "f" || kind == "i" || kind == "u";
    if (numbers && nb::try_cast(given.attr("astype")("float64"), array, false)) return array;
  } catch (nb::python_error& e) {  // not convertible to an array
    if (!e.matches(PyExc_Exception)) throw;
  }
  refuse(what, name,
         kTriples ? "three numbers, or an array with a row of three for each time, are"
                  : "a number, or an array of numbers with one dimension, is",
         value);
}

// A number. An array of length one is no number.
std::optional<double> number_in(const nb::handle value) {
  double number = 0;
  if (nb::hasattr(value, "__len__") || !nb::try_cast(value, number)) return std::nullopt;
  return number;
}

Three triple_of(const char* what, const char* name, const nb::handle value) {
  Three three;
  if (nb::try_cast(value, three)) return three;
  refuse(what, name, "three numbers are", value);
}

double number_of(const char* what, const char* name, const nb::handle value) {
  if (const auto number = number_in(value)) return *number;
  refuse(what, name, "a number is", value);
}

// Calls add(row) for each row. The interpreter's lock is held, so that threads which share a filter or a session take
// turns. Between pieces other threads run, and Ctrl-C is handled.
template <class Add>
void for_each_row(std::size_t rows, const Add& add) {
  constexpr std::size_t kPiece = 1000;
  for (std::size_t i = 0; i < rows; ++i) {
    if (i > 0 && i % kPiece == 0) {
      { const nb::gil_scoped_release release; }
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
    }
    add(i);
  }
}

Vector3d three(const Three& values) { return {values[0], values[1], values[2]}; }

// degrees and metres
Geodetic place(const Three& degrees) { return {kDegree * degrees[0], kDegree * degrees[1], degrees[2]}; }

nb::dict state(double time, const Navigation& n, const Sigmas& s) {
  nb::dict out;
  out["time_s"] = time;
  out["latitude_deg"] = kDegreesPerRadian * n.position.latitude;
  out["longitude_deg"] = kDegreesPerRadian * n.position.longitude;
  out["height_m"] = n.position.height;
  out["velocity_m_s"] = n.velocity;
  out["euler_deg"] = Vector3d(kDegreesPerRadian * n.euler);
  out["sigma_position_m"] = s.position;
  out["sigma_velocity_m_s"] = s.velocity;
  out["sigma_euler_deg"] = Vector3d(kDegreesPerRadian * s.euler);
  return out;
}

void require_start(bool right, const char* key, const char* what) {
  if (!right) throw ConfigError(key, what);
}

// A start in the frame w whose origin is `position`.
Start start_at(double time, const Geodetic& position, const Three& velocity, const Three& euler,
               const Three& sigma_position, const Three& sigma_velocity, const Three& sigma_euler) {
  require_start(std::isfinite(time), "time", "must be finite; GPS seconds of week are expected");
  if (const std::string fault = fault_of(position); !fault.empty()) throw ConfigError("position", fault);
  require_start(three(velocity).allFinite(), "velocity", "must be finite");
  require_start(three(euler).allFinite(), "euler", "must be finite");
  for (const Three* sigma : {&sigma_position, &sigma_velocity, &sigma_euler}) {
    require_start(are_sigmas(three(*sigma)) && three(*sigma).allFinite(), "sigma", "must be finite and above zero");
  }
  Start start;
  start.time = time;
  start.x.v_wb = three(velocity);
  start.x.q_wb = from_euler(kDegree * three(euler));
  // For small changes of roll, pitch and heading, the rotation vector along the local level is the sum of the changes
  // times their axes.
  const Matrix3d axes = euler_axes(kDegree * three(euler));
  const Vector3d angles = (kDegree * three(sigma_euler)).cwiseAbs2();
  start.covariance = Covariance::Zero(9, 9);
  start.covariance.block<3, 3>(0, 0) = three(sigma_position).cwiseAbs2().asDiagonal();
  start.covariance.block<3, 3>(3, 3) = three(sigma_velocity).cwiseAbs2().asDiagonal();
  start.covariance.block<3, 3>(6, 6) = axes * angles.asDiagonal() * axes.transpose();
  return start;
}

void add_samples(Filter& filter, const nb::object& time, const nb::object& interval, const nb::object& dtheta,
                 const nb::object& dvel) {
  constexpr const char* kWhat = "samples";
  const auto add = [&filter](double t, double dt, const Vector3d& turn, const Vector3d& change) {
    ImuSample sample;
    sample.time = t;
    sample.interval = dt;
    sample.dtheta = turn;
    sample.dvel = change;
    filter.add(sample);
    filter.clear_innovations();
  };
  if (const auto t = number_in(time)) {
    add(*t, number_of(kWhat, "interval", interval), three(triple_of(kWhat, "dtheta", dtheta)),
        three(triple_of(kWhat, "dvel", dvel)));
    return;
  }
  const auto times = array_of<Times>(kWhat, "time", time, true),
             intervals = array_of<Times>(kWhat, "interval", interval);
  const auto turns = array_of<Triples>(kWhat, "dtheta", dtheta), changes = array_of<Triples>(kWhat, "dvel", dvel);
  const std::size_t rows = times.shape(0);
  require_rows(kWhat, rows, {intervals.shape(0), turns.shape(0), changes.shape(0)});
  for_each_row(rows, [&](std::size_t i) { add(times(i), intervals(i), row(turns, i), row(changes, i)); });
}

void add_rows(Live& live, const nb::object& time, const nb::object& gyro, const nb::object& accel) {
  constexpr const char* kWhat = "imu";
  if (const auto t = number_in(time)) {
    live.add(ImuRow{*t, three(triple_of(kWhat, "gyro", gyro)), three(triple_of(kWhat, "accel", accel))});
    return;
  }
  const auto times = array_of<Times>(kWhat, "time", time, true);
  const auto rates = array_of<Triples>(kWhat, "gyro", gyro), forces = array_of<Triples>(kWhat, "accel", accel);
  const std::size_t rows = times.shape(0);
  require_rows(kWhat, rows, {rates.shape(0), forces.shape(0)});
  for_each_row(rows, [&](std::size_t i) { live.add(ImuRow{times(i), row(rates, i), row(forces, i)}); });
}

GeodeticFix fix_of(const nb::object& time, const nb::object& position, const nb::object& sigma,
                   const nb::object& velocity, const nb::object& sigma_velocity) {
  constexpr const char* kWhat = "gnss";
  GeodeticFix fix;
  fix.time = number_of(kWhat, "time", time);
  fix.position = place(triple_of(kWhat, "position", position));
  fix.sigma_position = three(triple_of(kWhat, "sigma", sigma));
  if (velocity.is_none()) return fix;
  if (sigma_velocity.is_none()) throw DataError(kWhat, "a velocity needs its sigma; give `sigma_velocity`");
  fix.velocity = FixVelocity{three(triple_of(kWhat, "velocity", velocity)),
                             three(triple_of(kWhat, "sigma_velocity", sigma_velocity))};
  return fix;
}

// The signature for type checkers of functions that take numbers, sequences and arrays.
#define PISTE_ARRAY "numpy.typing.ArrayLike"
constexpr const char* kAddGnss =
    "def add_gnss(self, time: float, position: " PISTE_ARRAY ", sigma: " PISTE_ARRAY ", velocity: " PISTE_ARRAY
    " | None = None, sigma_velocity: " PISTE_ARRAY " | None = None, receiver: int = 0) -> None";
constexpr const char* kAddSamples = "def add(self, time: " PISTE_ARRAY ", interval: " PISTE_ARRAY
                                    ", dtheta: " PISTE_ARRAY ", dvel: " PISTE_ARRAY ") -> None";
constexpr const char* kAddRows =
    "def add(self, time: " PISTE_ARRAY ", gyro: " PISTE_ARRAY ", accel: " PISTE_ARRAY ") -> None";
#undef PISTE_ARRAY

FilterOptions filter_options(const Configuration& configuration) {
  return read_replay_config(configuration.config).filter;
}

LiveOptions live_options(const Configuration& configuration) {
  const ReplayConfig config = read_replay_config(configuration.config);
  LiveOptions options;
  options.conditioning = config.conditioning;
  options.filter = config.filter;
  options.heading = config.initial;
  return options;
}

std::optional<nb::dict> live_state(const std::optional<LiveState>& s) {
  if (!s) return std::nullopt;
  nb::dict out = state(s->time, {s->position, s->velocity, s->euler}, s->sigmas);
  out["heading_known"] = s->heading_known;
  return out;
}

}  // namespace

void bind_filtering(nb::module_& m) {
  nb::class_<Filter>(m, "Filter")
      .def(
          "__init__",
          [](Filter* self, const Configuration& configuration, double time, const Three& position,
             const Three& velocity, const Three& euler, const Three& sigma_position, const Three& sigma_velocity,
             const Three& sigma_euler) {
            const FilterOptions options = filter_options(configuration);
            Start start = start_at(time, place(position), velocity, euler, sigma_position, sigma_velocity, sigma_euler);
            set_known(start.x, options);
            new (self) Filter(options, World(place(position)), start);
          },
          nb::arg("configuration"), nb::arg("time"), nb::arg("position"), nb::arg("velocity"), nb::arg("euler"),
          nb::arg("sigma_position"), nb::arg("sigma_velocity"), nb::arg("sigma_euler"),
          "A filter with its start: GPS seconds of week; degrees and m; m/s north, east, down; degrees; and sigmas.")
      .def_static(
          "of", [](const Run& run) { return Filter(run.replay.options, run.replay.log.world, run.replay.found.start); },
          nb::arg("run"), "A filter at the start of a run, with its options.")
      .def("add", &add_samples, nb::sig(kAddSamples), nb::arg("time").none(), nb::arg("interval").none(),
           nb::arg("dtheta").none(), nb::arg("dvel").none(),
           "A sample, or arrays of samples one after the other: the time at the end of each (GPS seconds of week), the "
           "interval before it "
           "(s), and "
           "over it the rotation (rad) and the change of velocity (m/s), body axes, forward, right, down.")
      .def(
          "add_gnss",
          [](Filter& filter, const nb::object& time, const nb::object& position, const nb::object& sigma,
             const nb::object& velocity, const nb::object& sigma_velocity, int receiver) {
            const std::size_t receivers = filter.options().gnss.size();
            if (receiver < 0 || static_cast<std::size_t>(receiver) >= receivers) {
              throw DataError("gnss", fmt::format("there is no receiver {}; there are {}, the first of which is 0",
                                                  receiver, receivers));
            }
            const GeodeticFix fix = fix_of(time, position, sigma, velocity, sigma_velocity);
            if (const std::string fault = fault_of(fix); !fault.empty()) {
              throw DataError(fmt::format("gnss: t = {:.3f} s", fix.time), fault);
            }
            filter.add(receiver,
                       GnssFix{fix.time, filter.world().from_geodetic(fix.position), fix.sigma_position, fix.velocity});
          },
          nb::sig(kAddGnss), nb::arg("time").none(), nb::arg("position").none(), nb::arg("sigma").none(),
          nb::arg("velocity").none() = nb::none(), nb::arg("sigma_velocity").none() = nb::none(),
          nb::arg("receiver") = 0,
          "A fix: GPS seconds of week; latitude and longitude in degrees, height in m; m/s; sigmas north, east, down. "
          "Those of a "
          "receiver come in the order of their times.")
      .def("finish", &Filter::finish,
           "Processes the last sample, after which nothing may be added. False if there was none.")
      .def_prop_ro("time", &Filter::time, "GPS seconds of week of the last sample.")
      .def_prop_ro("late", &Filter::late, "The number of fixes that came too late to be used.")
      .def_prop_ro(
          "covariance", [](const Filter& f) { return Eigen::MatrixXd(f.covariance()); },
          "Covariance of the errors of `blocks`, SI and radians, in the frame w (piste.h).")
      .def_prop_ro(
          "blocks",
          [](const Filter& f) {
            std::vector<std::string> names;
            for (const Block b : f.layout().blocks()) names.emplace_back(info(b).name);
            return names;
          },
          "The blocks of the state, in the order of the covariance.")
      .def(
          "state",
          [](const Filter& f) {
            return state(f.time(), navigation_of(f.world(), f.estimate()),
                         sigmas_of(f.world(), f.estimate(), f.layout(), f.covariance()));
          },
          "Time, position, velocity, attitude and their sigmas, with the units in the names.");

  nb::class_<Live>(m, "Live")
      .def(
          "__init__",
          [](Live* self, const Configuration& configuration) { new (self) Live(live_options(configuration)); },
          nb::arg("configuration"))
      .def("add", &add_rows, nb::sig(kAddRows), nb::arg("time").none(), nb::arg("gyro").none(), nb::arg("accel").none(),
           "A raw row, or arrays of rows, at the sensor's own clock and along its own axes: s, rad/s and m/s^2. Three "
           "numbers for a row, or an array with a row of three for each time.")
      .def(
          "add_gnss",
          [](Live& live, const nb::object& time, const nb::object& position, const nb::object& sigma,
             const nb::object& velocity, const nb::object& sigma_velocity,
             int receiver) { live.add(receiver, fix_of(time, position, sigma, velocity, sigma_velocity)); },
          nb::sig(kAddGnss), nb::arg("time").none(), nb::arg("position").none(), nb::arg("sigma").none(),
          nb::arg("velocity").none() = nb::none(), nb::arg("sigma_velocity").none() = nb::none(),
          nb::arg("receiver") = 0,
          "A fix: GPS seconds of week; latitude and longitude in degrees, height in m; m/s; sigmas north, east, down. "
          "Those of a "
          "receiver come in the order of their times.")
      .def_prop_ro("late", &Live::late, "The number of fixes that came too late to be used.")
      .def(
          "state", [](const Live& live) { return live_state(live.state()); },
          "The state as far as samples are conditioned, 1.5 s behind the newest row; None before the start.")
      .def(
          "now", [](const Live& live) { return live_state(live.now()); },
          "The state at the newest row; None before the start. It costs as much as filtering 1.5 s.");
}

}  // namespace piste::python
