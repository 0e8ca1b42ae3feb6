/// Replays, and their solutions as arrays that share the memory of the library.

#include "run.h"

#include <nanobind/stl/pair.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <ctime>
#include <memory>

#include "bindings.h"
#include "interruptible.h"
#include "piste/batch.h"
#include "piste/piste.h"

namespace piste::python {
namespace {

using Names = std::vector<std::string>;

// A view of numbers that are `bytes` apart in memory that `owner` keeps. `size`: 1, or the numbers of a row.
template <class T>
nb::object view(const T* first, std::size_t rows, std::size_t size, std::size_t bytes, nb::handle owner) {
  const auto stride = static_cast<std::int64_t>(bytes / sizeof(T));
  if (size == 1) return nb::cast(nb::ndarray<nb::numpy, const T>(first, {rows}, owner, {stride}));
  return nb::cast(nb::ndarray<nb::numpy, const T>(first, {rows, size}, owner, {stride, 1}));
}

nb::dict stored(const nb::handle self) {
  const auto& solution = nb::cast<const Solution&>(self);
  nb::dict columns;
  for (const StoredColumn& c : solution.columns()) {
    columns[c.name.c_str()] =
        view(solution.rows().data() + c.offset, solution.size(), c.size, solution.stride() * sizeof(double), self);
  }
  return columns;
}

nb::dict innovations(const nb::handle self) {
  const auto& all = nb::cast<const Solution&>(self).innovations;
  const Innovation none;
  const Innovation& first = all.empty() ? none : all.front();
  const auto doubles = [&](const double* member, std::size_t size) {
    return view(member, all.size(), size, sizeof(Innovation), self);
  };
  static_assert(sizeof(Innovation) % sizeof(double) == 0 && sizeof(Outcome) == sizeof(int));
  nb::dict columns;
  columns["time_s"] = doubles(&first.time, 1);
  columns["source"] = view(&first.source, all.size(), 1, sizeof(Innovation), self);
  columns["dof"] = view(&first.dof, all.size(), 1, sizeof(Innovation), self);
  columns["residual"] = doubles(first.residual.data(), 3);
  columns["sigma"] = doubles(first.sigma.data(), 3);
  columns["nis"] = doubles(&first.nis, 1);
  columns["gate"] = doubles(&first.gate, 1);
  columns["outcome"] = view(reinterpret_cast<const int*>(&first.outcome), all.size(), 1, sizeof(Innovation), self);
  return columns;
}

// The IMU samples of the filter.
nb::dict samples(const nb::handle self) {
  const std::vector<ImuSample>& imu = nb::cast<const Run&>(self).replay.log.imu;
  const ImuSample none;
  const ImuSample& first = imu.empty() ? none : imu.front();
  static_assert(sizeof(ImuSample) % sizeof(double) == 0);
  const auto doubles = [&](const double* member, std::size_t size) {
    return view(member, imu.size(), size, sizeof(ImuSample), self);
  };
  nb::dict columns;
  columns["time"] = doubles(&first.time, 1);
  columns["interval"] = doubles(&first.interval, 1);
  columns["dtheta"] = doubles(first.dtheta.data(), 3);
  columns["dvel"] = doubles(first.dvel.data(), 3);
  return columns;
}

std::pair<Names, Numbers> numbers(NumberTable table) {
  const std::size_t columns = table.names.size();
  return {std::move(table.names), owned(std::move(table.values), columns)};
}

std::unique_ptr<Run> replayed(const Configuration& configuration, bool judged, const nb::object& progress) {
  return interruptible(progress, [&](Told& told) {
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    auto run = std::make_unique<Run>();
    run->config = read_replay_config(configuration.config);
    run->replay = replay(
        run->config,
        [&](std::string_view stage, std::size_t done, std::size_t all) {
          told(stage, static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(all, 1)));
        },
        batch_solver(run->config.batch));
    const Replay& r = run->replay;
    const Solution& filtered = r.filtered.solution;
    const Solution* smoothed = r.smoothed ? &*r.smoothed : nullptr;
    run->verdict = judged ? diagnose(r.log, r.options, run->config.initial, r.found, filtered, smoothed,
                                     [&](double part) { told("verdict", part); })
                          : judge(r.log, r.options, filtered, smoothed);
    if (!run->config.needs_history()) run->replay.filtered.history.reset();
    const std::chrono::duration<double> wall_s = std::chrono::steady_clock::now() - wall;
    run->times = {static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC, wall_s.count()};
    return run;
  });
}

}  // namespace

void bind_run(nb::module_& m) {
  nb::class_<Solution>(m, "Solution")
      .def("__len__", &Solution::size)
      .def("stored", &stored, "Columns as the library stores them: SI, radians, the frame w. They share its memory.")
      .def("innovations", &innovations, "Columns of all innovations, which share the library's memory.")
      .def_ro("sources", &Solution::sources, "Names of the sources of innovations.")
      .def(
          "navigation", [](const Solution& s, double rate) { return numbers(navigation_table(s, rate)); },
          nb::arg("rate") = 0.0, "Names and rows of filtered.csv or smoothed.csv.")
      .def(
          "biases", [](const Solution& s, double rate) { return numbers(biases_table(s, rate)); },
          nb::arg("rate") = 0.0, "Names and rows of biases.csv.");

  nb::class_<Run>(m, "Run")
      .def_prop_ro(
          "filtered", [](const Run& run) -> const Solution& { return run.replay.filtered.solution; },
          nb::rv_policy::reference_internal)
      .def_prop_ro(
          "smoothed", [](const Run& run) { return run.replay.smoothed ? &*run.replay.smoothed : nullptr; },
          nb::rv_policy::reference_internal)
      .def_prop_ro("how", [](const Run& run) { return run.replay.found.how; })
      .def_prop_ro("verdict_line", [](const Run& run) { return verdict_line(run.verdict); })
      .def("samples", &samples, "The samples as the filter got them, in shared memory.")
      .def("warnings", [](const Run& run) { return replay_warnings(run.config, run.replay, run.verdict); })
      .def("summary",
           [](const Run& run) {
             const Replay& r = run.replay;
             return summary_json(r.log, r.filtered.solution, r.smoothed ? &*r.smoothed : nullptr, run.verdict,
                                 run.times, nullptr, gps_week(run.config, r.log.imu.front().time),
                                 replay_warnings(run.config, run.replay, run.verdict));
           })
      .def("page", [](const Run& run) { return replay_page(run.config, run.replay, run.verdict); })
      .def(
          "write",
          [](const Run& run, const std::string& folder, const nb::object& progress) {
            interruptible(progress, [&](Told& told) {
              OutputFolder output(folder);
              write_replay(
                  output, run.config, run.replay, run.verdict, [&] { return run.times; },
                  [&](double part) { told("writing", part); });
              output.commit();
            });
          },
          nb::arg("folder"), nb::arg("progress") = nb::none());

  m.def("replay", &replayed, nb::arg("configuration"), nb::arg("judged") = true, nb::arg("progress") = nb::none(),
        "Replays the logs of a configuration.");
}

}  // namespace piste::python
