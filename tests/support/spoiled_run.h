#pragma once
/// Ways to spoil a ski run, and the message that a program must give.

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "support/ski_run.h"

namespace piste::test {

inline constexpr const char *kImu = SkiRun::kImu, *kGnss = SkiRun::kGnss, *kAttitude = SkiRun::kAttitude;
inline constexpr int kData = 1, kUsage = 2;  ///< exit codes

struct Fault {
  std::string name;
  std::function<void(const SkiRun&)> spoil;
  int code;
  std::vector<std::string> says;  ///< parts of the message: where, what, and how to correct it
};

inline void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

inline void set_field(std::string& line, std::size_t field, const std::string& value) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < field; ++i) begin = line.find(',', begin) + 1;
  line.replace(begin, std::min(line.find(',', begin), line.size()) - begin, value);
}

inline auto field(const char* file, int line, std::size_t index, const std::string& value) {
  return
      [=](const SkiRun& run) { run.edit_line(file, line, [&](std::string& text) { set_field(text, index, value); }); };
}

inline auto in_config(const std::string& from, const std::string& to) {
  return [=](const SkiRun& run) { run.replace(SkiRun::kConfig, from, to); };
}

inline auto in_sensor(const std::string& from, const std::string& to) {
  return [=](const SkiRun& run) { run.replace(SkiRun::kSensor, from, to); };
}

/// Place of this text in the shipped configuration, as errors name it.
inline std::string config_line(const std::string& text, int below = 0) {
  const std::string all = read_text(kSource / SkiRun::kConfig);
  return fmt::format("ski_run.yaml:{}: ", std::count(all.begin(), all.begin() + all.find(text), '\n') + 1 + below);
}

inline void shift_times(const SkiRun& run, const char* file, double by) {
  run.edit_rows(file, [&](std::vector<std::string>& row) {
    const double t = std::stod(row[0]) + by;
    row[0] = fmt::format("{:.6f}", t >= 604800 ? t - 604800 : t);
  });
}

/// Checks a refused run: one line of its message holds all of `fault.says`, and it leaves no outputs.
inline void expect_refusal(const SkiRun& run, const Fault& fault, const Said& said) {
  EXPECT_EQ(said.code, fault.code) << said.err;
  for (const std::string& part : fault.says) EXPECT_TRUE(contains(said.err, part));
  EXPECT_EQ(said.out, "");
  EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
  EXPECT_FALSE(std::filesystem::exists(run.folder / "result"));
}

/// Checks that no output of a run has a value that is not a number.
inline void expect_numbers(const SkiRun& run) {
  for (const char* name : {"filtered.csv", "smoothed.csv", "biases.csv", "biases_smoothed.csv", "innovations.csv"}) {
    const std::string text = read_text(run.folder / (std::string("result/") + name));
    EXPECT_NE(text, "") << name;
    EXPECT_EQ(text.find("nan"), std::string::npos) << name;
    EXPECT_EQ(text.find("inf"), std::string::npos) << name;
  }
  EXPECT_EQ(read_text(run.folder / "result/summary.json").find("null"), std::string::npos);
}

}  // namespace piste::test
