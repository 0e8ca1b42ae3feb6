#pragma once
/// A copy of the shipped ski run that a test may spoil: `config/ski_run.yaml` with its sensor file and one minute of
/// its data, laid out as in the repository.

#include <functional>
#include <stdexcept>
#include <string>

#include "math/numbers.h"
#include "support/places.h"
#include "support/program.h"

namespace piste::test {

class SkiRun {
 public:
  static constexpr const char* kConfig = "config/ski_run.yaml";
  static constexpr const char* kImu = "data/ski_run/mt9a_1.csv";
  static constexpr const char* kGnss = "data/ski_run/gnss.csv";
  static constexpr const char* kGnssL1 = "data/ski_run/gnss_l1.csv";
  static constexpr const char* kAttitude = "data/ski_run/ln200_attitude.csv";
  static constexpr const char* kSensor = "config/sensors/xsens_mt9a.yaml";
  static constexpr double kBegin = 302435, kEnd = 302495;  ///< 25 s of rest, 35 s of skiing

  SkiRun() {
    for (const char* name : {kConfig, kSensor}) folder.write(name, read_text(kSource / name));
    for (const char* name : {kImu, kGnss, kGnssL1, kAttitude}) folder.write(name, minute_of(read_text(kSource / name)));
  }

  std::string text(const std::string& name) const { return read_text(folder / name); }
  void write(const std::string& name, const std::string& text) const { folder.write(name, text); }

  /// Replaces the first `from`, which must exist.
  void replace(const std::string& name, const std::string& from, const std::string& to) const {
    std::string all = text(name);
    const auto place = all.find(from);
    if (place == std::string::npos) throw std::logic_error(name + " has no " + from);
    write(name, all.replace(place, from.size(), to));
  }
  /// Changes one line, counted from 1, as editors and error messages do.
  void edit_line(const std::string& name, int number, const std::function<void(std::string&)>& change) const {
    const std::string all = text(name);
    std::size_t begin = 0;
    for (int i = 1; i < number; ++i) begin = all.find('\n', begin) + 1;
    const auto end = all.find('\n', begin);
    std::string line = all.substr(begin, end - begin);
    change(line);
    write(name, all.substr(0, begin) + line + all.substr(end));
  }
  /// Passes every row except the header through `change`, as fields.
  void edit_rows(const std::string& name, const std::function<void(std::vector<std::string>&)>& change) const {
    std::istringstream lines(text(name));
    std::string line, all;
    for (int number = 1; std::getline(lines, line); ++number) {
      std::vector<std::string> fields;
      std::istringstream row(line);
      for (std::string field; std::getline(row, field, ',');) fields.push_back(field);
      if (number > 1) change(fields);
      for (std::size_t i = 0; i < fields.size(); ++i) all += (i > 0 ? "," : "") + fields[i];
      all += '\n';
    }
    write(name, all);
  }

  Said replay(std::vector<std::string> words = {kConfig, "--output", "result", "--quiet"}) const {
    return run_program(program("replay"), words, folder);
  }

  TemporaryFolder folder;

 private:
  static std::string minute_of(const std::string& all) {
    std::string kept = all.substr(0, all.find('\n') + 1);
    for (std::size_t begin = kept.size(); begin < all.size();) {
      const auto end = all.find('\n', begin) + 1;
      double time = 0;
      read_number(all.data() + begin, all.data() + end, time);
      if (time >= kBegin && time <= kEnd) kept += all.substr(begin, end - begin);
      begin = end;
    }
    return kept;
  }
};

}  // namespace piste::test
