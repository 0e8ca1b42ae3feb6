#include "piste/search/readings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "inspect/signed_permutations.h"
#include "math/words.h"
#include "piste/math/units.h"
#include "search/judged.h"

namespace piste {
namespace {

// What the keys of a configuration say, and makes an inspection say it, whatever it said before.
struct Reading {
  std::string keys;
  std::function<void(Inspection&)> say;
};

// A question, and its answers: the first is the one that was found.
struct Question {
  std::string what, key;
  std::vector<Reading> readings;
};

InspectedLog& body_of(Inspection& found) { return found.logs[*found.first(LogKind::kImu)]; }

// States the axes; nothing: those estimated from the motion. Lever arms are turned into them.
void say_axes(Inspection& found, const std::optional<Matrix3d>& axes) {
  const Matrix3d before = guess_conditioning(found).R_bs;
  found.axes = axes;
  const Matrix3d turn = guess_conditioning(found).R_bs * before.transpose();
  for (InspectedLog& log : found.logs) {
    if (!log.calibration) continue;
    log.calibration->lever_arm = turn * log.calibration->lever_arm;
    log.calibration->lever_arm_sigma = turn.cwiseAbs() * log.calibration->lever_arm_sigma;
  }
}

// If the motion does not determine the axes, gravity leaves four: forward is any horizontal axis. If the IMU sits
// askew, there are several nearest ones. Replays with them are equally likely, as the attitude is that of the body.
std::optional<Question> about_axes(const Inspection& found) {
  const Matrix3d R_bs = guess_conditioning(found).R_bs;
  const LogMatch* match = found.first_match();
  const bool known = match != nullptr && match->motion && !match->motion->mirrored;
  Question question{"which axes of the IMU point forward, right and down", "axes", {}};
  const auto add = [&](const Matrix3d& axes, const std::optional<Matrix3d>& stated) {
    question.readings.push_back({"axes: " + axes_text(axes), [stated](Inspection& said) { say_axes(said, stated); }});
  };
  add(R_bs, found.axes);
  for (const Matrix3d& axes : signed_permutations()) {
    if (axes == R_bs || axes.determinant() < 0) continue;
    const bool as_likely =
        known ? std::ranges::count(match->motion->as_likely, axes_text(axes)) > 0 : axes.row(2) == R_bs.row(2);
    if (as_likely) add(axes, axes);
  }
  if (question.readings.size() < 2) return std::nullopt;
  return question;
}

std::optional<Question> about_velocities(const Inspection& found) {
  const auto gnss = found.first(LogKind::kGnss);
  const Calibration* calibration = found.calibration();
  if (!gnss || calibration == nullptr || !calibration->velocities_contradict) return std::nullopt;
  const auto say = [gnss](bool contradict) {
    return [gnss, contradict](Inspection& said) { said.logs[*gnss].calibration->velocities_contradict = contradict; };
  };
  return Question{"whether the receiver's velocities agree with its positions",
                  "use",
                  {{"use: position", say(true)}, {"use: position velocity", say(false)}}};
}

// States the unit of the rates, and converts the estimated errors of the gyroscopes into it.
void say_unit(Inspection& found, const std::string& unit) {
  std::string& now = body_of(found).log.columns->uses.at("gyro").unit;
  if (now == unit) return;
  const double factor = now == "rad/s" ? kDegree : kDegreesPerRadian;
  now = unit;
  for (InspectedLog& log : found.logs) {
    if (!log.calibration) continue;
    TriadErrors& gyro = log.calibration->sensor.gyro;
    for (double* value : {&gyro.noise, &gyro.bias, &gyro.drift.sigma, &gyro.drift.density}) *value *= factor;
  }
}

std::optional<Question> about_rates(const Inspection& found) {
  const InspectedLog& body = found.logs[*found.first(LogKind::kImu)];
  if (!body.guess->guessed_rates || !body.log.columns || found.calibration() == nullptr) return std::nullopt;
  const ColumnUse* gyro = body.log.columns->find("gyro");
  if (gyro == nullptr) return std::nullopt;  // increments, as the motion has them
  const std::string unit = gyro->unit;
  if (unit != "rad/s" && unit != "deg/s") return std::nullopt;
  const auto reading = [](const std::string& of) {
    return Reading{fmt::format("gyro: {{unit: {}}}", of), [of](Inspection& said) { say_unit(said, of); }};
  };
  return Question{"in which unit the rates are", "gyro", {reading(unit), reading(unit == "rad/s" ? "deg/s" : "rad/s")}};
}

// ln p of each reading, over the innovations that all of them predict; nothing for those that do not run. `found` says
// the first again afterwards.
std::vector<std::optional<double>> weights(const Question& question, const Configured& configured, Inspection& found) {
  std::vector<std::optional<Likelihoods>> runs;
  for (const Reading& reading : question.readings) {
    reading.say(found);
    runs.push_back(weighed(found, configured));
  }
  question.readings.front().say(found);
  std::vector<std::optional<double>> all(runs.size());
  const auto any = std::ranges::find_if(runs, [](const auto& run) { return run.has_value(); });
  if (any == runs.end()) return all;
  const auto in_all = [&](const auto& row) {
    return std::ranges::all_of(runs, [&](const auto& run) { return !run || run->contains(row); });
  };
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i]) all[i] = 0;
  }
  for (const auto& [row, ln_p] : **any) {
    if (!in_all(row)) continue;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (runs[i]) *all[i] += runs[i]->at(row);
    }
  }
  return all;
}

// Takes the most likely reading if it gains enough, and keeps those as likely as a doubt.
void answer(const Question& question, const Configured& configured, Inspection& found) {
  const std::vector<std::optional<double>> ln_p = weights(question, configured, found);
  const auto tried = static_cast<double>(std::ranges::count_if(ln_p, [](const auto& p) { return p.has_value(); }));
  if (tried == 0) return;
  const double bound = std::log(tried) + 3;
  const auto best = static_cast<std::size_t>(std::ranges::max_element(ln_p) - ln_p.begin());
  const bool runs = ln_p.front().has_value();  // with what was found
  const std::size_t taken = !runs || *ln_p[best] - *ln_p.front() > bound ? best : 0;
  question.readings[taken].say(found);
  InspectedDoubt doubt{.what = question.what, .key = question.key};
  for (std::size_t i = 0; i < ln_p.size(); ++i) {
    if (!ln_p[i] || *ln_p[best] - *ln_p[i] > bound) continue;
    const InspectedReading reading{.keys = question.readings[i].keys, .ln_p = *ln_p[i]};
    doubt.readings.insert(i == taken ? doubt.readings.begin() : doubt.readings.end(), reading);
  }
  const std::string file = body_of(found).log.file;
  if (doubt.readings.size() > 1) {
    found.suspicions.push_back({LogFault::kDoubt, file,
                                fmt::format("the logs do not tell {}: {}", doubt.what, doubt.readings_text()),
                                "the configuration has the first; keep the one that you know to be right"});
    found.doubts.push_back(std::move(doubt));
  } else if (taken != 0) {
    found.suspicions.push_back(
        {LogFault::kDoubt, file,
         fmt::format("the whole log tells {}: `{}`, {} `{}`", question.what, question.readings[taken].keys,
                     runs ? fmt::format("by {} of ln p likelier than", plain(*ln_p[taken] - *ln_p.front(), 3))
                          : "as no replay runs with",
                     question.readings.front().keys),
         "the configuration has it"});
  }
}

}  // namespace

void weigh_readings(Inspection& found, const std::function<ReplayConfig(const Inspection&)>& configured) {
  found.doubts.clear();
  if (!found.first(LogKind::kImu) || !found.first(LogKind::kGnss)) return;
  for (const auto& asked : {about_rates, about_axes, about_velocities}) {
    if (const auto question = asked(found)) answer(*question, configured, found);
  }
  rank(found.suspicions);
}

}  // namespace piste
