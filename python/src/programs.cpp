/// The other programs: inspect, simulate, montecarlo, align, compare, evaluate, study, tune, allan.

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>

#include "bindings.h"
#include "interruptible.h"
#include "math/gps_time.h"
#include "piste/batch.h"
#include "piste/configuration/sensor_file.h"
#include "piste/core/version.h"
#include "piste/piste.h"
#include "recordings.h"

namespace piste::python {
namespace {

using Texts = std::vector<std::pair<std::string, std::string>>;

ProgressCallback part(Told& told, std::string_view stage) {
  return [&told, stage](double done) { told(stage, done); };
}

double share(std::size_t done, std::size_t all) {
  return static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(all, 1));
}

void write_into(const std::optional<std::string>& folder, const std::function<void(OutputFolder&)>& write) {
  if (!folder) return;
  OutputFolder output(*folder);
  write(output);
  output.commit();
}

struct Inspected {
  std::vector<std::string> files;
  std::vector<std::optional<std::string>> contents;  // of logs in memory; `found` refers to them
  Inspection found;
  std::optional<std::string> config(const std::string& folder) const {
    return ready_config(found, folder, "sensor.yaml");
  }
};

std::unique_ptr<Inspected> inspected(std::vector<std::string> files, std::vector<std::optional<std::string>> contents,
                                     const nb::object& progress) {
  return interruptible(progress, [&](Told& told) {
    auto all = std::make_unique<Inspected>(Inspected{std::move(files), std::move(contents), {}});
    std::vector<LogSource> logs;
    for (std::size_t i = 0; i < all->files.size(); ++i) {
      const auto& content = all->contents.at(i);
      logs.push_back({all->files[i], content ? std::optional<std::string_view>(*content) : std::nullopt});
    }
    all->found = inspect(logs, [&](std::string_view stage, double done) { told(stage, done); });
    return all;
  });
}

// Alignment and, for `compare`, findings of each IMU, as JSON.
std::vector<std::tuple<std::string, std::string, std::string>> aligned(const Configuration& configuration,
                                                                       bool compares,
                                                                       const std::optional<std::string>& folder,
                                                                       const nb::object& progress) {
  return interruptible(progress, [&](Told& told) {
    const AlignConfig config = read_align_config(configuration.config);
    std::vector<std::tuple<std::string, std::string, std::string>> out;
    std::optional<OutputFolder> output;
    if (folder) output.emplace(*folder);
    for_each_pair(
        config, [&](std::size_t done, std::size_t all) { told("align", share(done, all)); },
        [&](const AlignedPair& pair) {
          if (output) write_alignment(*output, config, pair);
          std::string found;
          if (compares) {
            found = findings_json(findings_of(config, pair), pair.alignment);
            if (output) output->write(pair.folder + "findings.json", found);
          }
          out.emplace_back(pair.imu.name, alignment_json(pair.alignment), std::move(found));
        });
    if (output) output->commit();
    return out;
  });
}

struct Simulated {
  Scenario scenario;
  std::uint64_t seed;
  Simulation simulation;
};

std::unique_ptr<Simulated> simulated(const Configuration& configuration, std::optional<std::uint64_t> seed,
                                     const nb::object& progress) {
  return interruptible(progress, [&](Told& told) {
    Scenario scenario = read_scenario(configuration.config);
    const std::uint64_t used = seed.value_or(scenario.seed);
    Simulation simulation =
        simulate(scenario, used, [&](std::size_t done, std::size_t all) { told("simulating", share(done, all)); });
    return std::make_unique<Simulated>(Simulated{std::move(scenario), used, std::move(simulation)});
  });
}

// Recordings by the names of their files.
template <class Recordings>
nb::dict tables_of(const Recordings& recordings) {
  nb::dict tables;
  for (const auto& recording : recordings) tables[recording.file.c_str()] = table_of(recording);
  return tables;
}

nb::bytes bytes_of(const std::string& text) { return nb::bytes(text.data(), text.size()); }
std::string_view view_of(const nb::bytes& bytes) { return {static_cast<const char*>(bytes.data()), bytes.size()}; }

Scenario ensemble_scenario(const Configuration& configuration) {
  Scenario scenario = read_scenario(configuration.config);
  if (scenario.gnss.empty()) {
    throw ConfigError(scenario.file, "names no receiver under `gnss:`; a replay needs one");
  }
  return scenario;
}

std::unique_ptr<Ensemble> begun(const Configuration& configuration, std::size_t first) {
  return std::make_unique<Ensemble>(ensemble_scenario(configuration), batch_solver(), first);
}

void run_trials(Ensemble& ensemble, std::size_t runs, std::size_t jobs, const nb::object& progress) {
  interruptible(progress, [&](Told& told) {
    ensemble.run(runs, jobs, [&](const Ensemble& so_far) { told("montecarlo", share(so_far.size(), runs)); });
  });
}

constexpr double kProbability = 0.999;  // of the bands, as in the program

ConsistencyReport report_of(const Ensemble& ensemble) {
  ConsistencyReport report = ensemble.sums().report(kProbability);
  if (report.runs == 0) {
    throw DataError("montecarlo",
                    "no run could be replayed" + (report.failures.empty() ? "" : "; " + report.failures.front().what));
  }
  return report;
}

}  // namespace

void bind_programs(nb::module_& m) {
  m.attr("cores") = std::max(1U, std::thread::hardware_concurrency());
  m.def(
      "gps_time",
      [](double unix_seconds) {
        constexpr double kSecondsOfDay = 86400;
        const double day = std::floor(unix_seconds / kSecondsOfDay);
        const std::chrono::sys_days date{std::chrono::days(static_cast<int>(day))};
        const GpsTime time = gps_time(date, unix_seconds - day * kSecondsOfDay, TimeSystem::kUtc);
        return std::pair(time.week, time.seconds);
      },
      nb::arg("unix_seconds"), "GPS week and seconds of it, of seconds since 1970 in UTC.");

  nb::class_<Inspected>(m, "Inspected")
      .def("text", [](const Inspected& i) { return inspection_text(i.found, i.config(".")); })
      .def("page", [](const Inspected& i) { return inspection_page(i.found, i.config("."), version()); })
      .def("config", &Inspected::config, nb::arg("folder"))
      .def("suspicions",
           [](const Inspected& i) {
             std::vector<std::string> what;
             for (const Suspicion& s : i.found.suspicions) what.push_back(s.what);
             return what;
           })
      .def("write", [](Inspected& i, const std::string& folder) {
        write_into(folder, [&](OutputFolder& output) {
          for (std::size_t k = 0; k < i.files.size(); ++k) {
            if (i.contents[k]) output.write(i.files[k], *i.contents[k]);
          }
          write_inspection(output, i.found);
        });
      });
  m.def("inspect", &inspected, nb::arg("files"), nb::arg("contents"), nb::arg("progress") = nb::none(),
        "Inspects logs: files, or those of which `contents` has what a file of that name would hold.");

  m.def("align", &aligned, nb::arg("configuration"), nb::arg("compares"), nb::arg("folder").none(),
        nb::arg("progress") = nb::none());

  nb::class_<Simulated>(m, "Simulated")
      .def_ro("seed", &Simulated::seed)
      .def("imus",
           [](const Simulated& s) {
             nb::dict tables;
             for (const SimulatedImu& imu : s.simulation.imus)
               tables[imu.recording.file.c_str()] = table_of(imu.recording);
             return tables;
           })
      .def("gnss", [](const Simulated& s) { return tables_of(s.simulation.gnss); })
      .def("attitude", [](const Simulated& s) { return tables_of(s.simulation.attitude); })
      .def("truth",
           [](const Simulated& s, std::size_t imu) {
             return truth_csv(s.simulation.bodies.at(imu), s.simulation.imus.at(imu).gps_time, s.scenario.truth_every);
           })
      .def("errors", [](const Simulated& s) { return truth_json(s.scenario, s.simulation, s.seed); })
      .def("write", [](const Simulated& s, const std::string& folder) {
        write_into(folder,
                   [&](OutputFolder& output) { write_simulation(output, "", s.scenario, s.simulation, s.seed); });
      });
  m.def("simulate", &simulated, nb::arg("configuration"), nb::arg("seed").none(), nb::arg("progress") = nb::none());

  nb::class_<Ensemble>(m, "Ensemble")
      .def_static("begin", &begun, nb::arg("configuration"), nb::arg("first") = 0)
      .def("run", &run_trials, nb::arg("runs"), nb::arg("jobs"), nb::arg("progress") = nb::none())
      .def("__len__", &Ensemble::size)
      .def_prop_ro("first", &Ensemble::first)
      .def("save", [](const Ensemble& e) { return bytes_of(e.save()); })
      .def("resume", [](Ensemble& e, const nb::bytes& bytes) { return e.resume(view_of(bytes)); })
      .def("append", [](Ensemble& e, const nb::bytes& bytes) { e.append(view_of(bytes)); })
      .def(
          "runs_within",
          [](const Ensemble& e, double band) {
            const double states = report_of(e).layout.size();
            double runs = 1;
            const auto narrow = [&] {
              const Band b = chi_squared_band(kProbability, states, runs);
              return std::max(1 - b.low, b.high - 1) <= band;
            };
            while (!narrow()) runs *= 2;
            for (double step = runs / 2; step >= 1; step /= 2) {
              runs -= step;
              if (!narrow()) runs += step;
            }
            return static_cast<std::size_t>(runs);
          },
          nb::arg("band"), "The fewest runs for which the band of the mean NEES of all states is within 1 ± `band`.")
      .def("report", [](const Ensemble& e, const std::string& title) { return consistency_json(report_of(e), title); })
      .def("text", [](const Ensemble& e) { return consistency_text(report_of(e)); })
      .def("write", [](const Ensemble& e, const Configuration& configuration, const std::string& folder,
                       const std::string& title) {
        write_into(folder, [&](OutputFolder& output) {
          output.write("ensemble.state", e.save());
          write_consistency(output, report_of(e), title, configuration.config.source());
        });
      });

  m.def(
      "evaluate",
      [](const std::string& estimate, const std::string& reference, const std::string& align,
         const std::vector<std::string>& rpe, const std::string& at, const std::string& time_offset,
         const std::optional<std::string>& folder) {
        return interruptible(nb::none(), [&](Told&) {
          EvaluationOptions options{.align = alignment_kind(align), .steps = {}};
          for (const std::string& step : rpe) options.steps.push_back(relative_step(step));
          set_time_offset(options, time_offset);
          const Evaluation found =
              evaluate(read_trajectory({.path = estimate, .at = at}), read_trajectory({.path = reference}), options);
          write_into(folder, [&](OutputFolder& output) { write_evaluation(output, found); });
          return Texts{{"json", evaluation_json(found)},
                       {"text", evaluation_text(found)},
                       {"page", evaluation_page(found, version())}};
        });
      },
      nb::arg("estimate"), nb::arg("reference"), nb::arg("align"), nb::arg("rpe"), nb::arg("at"),
      nb::arg("time_offset"), nb::arg("folder").none());

  m.def(
      "export",
      [](const std::string& folder, const std::string& format, std::optional<int> week, const std::string& file) {
        const ExportRun run = read_export_run(folder, week);
        const std::filesystem::path path(file);
        const std::vector<ExportedFile> files = exported(run, export_format(format));
        OutputFolder output(path.has_parent_path() ? path.parent_path() : ".");
        for (std::size_t i = files.size(); i-- > 0;) {
          output.write(i == 0 ? path.filename().string() : path.stem().string() + files[i].ending, files[i].content);
        }
        output.commit();
      },
      nb::arg("folder"), nb::arg("format"), nb::arg("week").none(), nb::arg("file"));
  m.def("export_extension", [](const std::string& format) { return std::string(extension_of(export_format(format))); });

  m.def(
      "descents",
      [](const std::vector<std::pair<std::string, std::string>>& runs, const std::string& gates,
         const std::string& line, double common, const std::string& at, const std::optional<std::string>& folder) {
        return interruptible(nb::none(), [&](Told&) {
          std::vector<Descent> all;
          for (const auto& [name, run] : runs) {
            all.push_back(std::filesystem::is_directory(run) ? descent_of(std::filesystem::path(run), at, name)
                                                             : descent_of(read_replay_config(run), at, name));
          }
          const DescentReport found = compare_descents(all, gates.empty() ? std::vector<Gate>{} : read_gates(gates),
                                                       {.line = line, .common = common});
          write_into(folder, [&](OutputFolder& output) { write_descents(output, found); });
          return Texts{{"json", descents_json(found)},
                       {"sections", sections_csv(found)},
                       {"gained", gained_csv(found)},
                       {"text", descents_text(found)},
                       {"page", descents_page(found, version())}};
        });
      },
      nb::arg("runs"), nb::arg("gates"), nb::arg("line"), nb::arg("common"), nb::arg("at"), nb::arg("folder").none());

  m.def(
      "tune",
      [](const Configuration& configuration, std::size_t jobs, double hold_out,
         const std::optional<std::string>& folder, const nb::object& progress) {
        return interruptible(progress, [&](Told& told) {
          const ReplayConfig config = read_replay_config(configuration.config);
          TuneOptions how{.jobs = jobs, .hold_out = hold_out};
          for (const LogFile& log : config.gnss) how.stated.push_back(stated_before(log.sigma_scales));
          const Tuning found = tune(read_recording(config), replay_options(config), how, part(told, "tuning"));
          write_into(folder, [&](OutputFolder& output) { write_tune(output, config, found); });
          return Texts{{"json", tune_json(found)}, {"text", tuning_text(found)}, {"page", tune_page(config, found)}};
        });
      },
      nb::arg("configuration"), nb::arg("jobs"), nb::arg("hold_out"), nb::arg("folder").none(),
      nb::arg("progress") = nb::none());

  m.def(
      "study",
      [](const Configuration& configuration, std::size_t jobs, const std::optional<std::string>& folder,
         const nb::object& progress) {
        return interruptible(progress, [&](Told& told) {
          const StudyConfig config = read_study_config(configuration.config);
          StudyOptions options;
          options.jobs = jobs;
          const Study study =
              run_study(config, options, [&](std::size_t done, std::size_t all) { told("study", share(done, all)); });
          write_into(folder, [&](OutputFolder& output) { write_study(output, config, study); });
          return std::pair(study_json(study), study_html(study, version(), config.echo));
        });
      },
      nb::arg("configuration"), nb::arg("jobs"), nb::arg("folder").none(), nb::arg("progress") = nb::none());

  m.def(
      "allan",
      [](const std::vector<std::string>& files, bool robust, bool at_rest, std::size_t jobs,
         const std::optional<std::string>& folder, const nb::object& progress) {
        return interruptible(progress, [&](Told& told) {
          AllanRequest request = read_allan_request(files);
          request.options.robust = request.options.robust || robust;
          request.options.at_rest = request.options.at_rest || at_rest;
          request.options.jobs = jobs;
          const AllanFindings found = find_noise(request, part(told, "allan"));
          write_into(folder, [&](OutputFolder& output) { write_allan(output, found); });
          const std::string sensor = sensor_text(found.sensor);
          return Texts{{"json", allan_json(found)},
                       {"text", allan_text(found)},
                       {"sensor", sensor},
                       {"page", allan_page(found, sensor, version())}};
        });
      },
      nb::arg("files"), nb::arg("robust"), nb::arg("at_rest"), nb::arg("jobs"), nb::arg("folder").none(),
      nb::arg("progress") = nb::none());
}

}  // namespace piste::python
