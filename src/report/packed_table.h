#pragma once
/// Columns of numbers as a page carries them: whole numbers of a step, differences, deflate, base64.

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace piste::page {

/// A table of a page. Its script finds the columns by their names, and inflates them when they are asked for.
///
/// A value is stored as the whole number of steps nearest to it. Of the numbers, their differences and the differences
/// of these the table keeps what needs the fewest bits, in bytes of seven bits each. NaN is a value that is not there.
///
///     PackedTable table;
///     table.add("height_m", heights, step_below(sigmas, 1e-5));
///     table.add_sigma("sigma_down_m", sigmas);
class PackedTable {
 public:
  /// A column whose values are exact to half a step. @pre step > 0; all columns are equally long
  void add(std::string name, std::span<const double> values, double step);
  /// A column of sizes, exact to 0.25 %. What is not above zero is zero.
  void add_sigma(std::string name, std::span<const double> values);

  /// `{"rows", "columns": [{"name", "step", "log", "order", "at"}], "data"}`.
  std::string json() const;

 private:
  struct Column {
    std::string name;
    double step;
    bool log;
    int order;
    std::size_t at;
  };
  void store(std::string name, std::span<const std::int64_t> numbers, double step, bool log);
  std::vector<Column> columns_;
  std::string bytes_;
  std::size_t rows_ = 0;
};

/// Signals that alias if rows are left out: mean, least and largest value of each of at most some 12 000 equally long
/// groups of rows, in the columns `NAME`, `NAME_least` and `NAME_most`; single rows if these are not more.
class Envelope {
 public:
  /// `rows`: how many will be added.
  Envelope(std::vector<std::string> names, std::size_t rows);
  /// @pre as many values as names
  void add(double time, std::span<const double> values);
  /// The table, with the column `time_s`, the time of the last row of each group.
  std::string json();
  /// Whether there are the columns of least and largest values.
  bool has_extremes() const { return each_ > 1; }

 private:
  struct Signal {
    std::string name;
    double sum = 0, least = 0, most = 0;
    std::vector<double> means = {}, leasts = {}, mosts = {};
  };
  void close();
  std::size_t each_, count_ = 0;
  double last_ = 0;
  std::vector<double> time_;
  std::vector<Signal> signals_;
};

/// A step that is at most a hundred-and-fiftieth of each sigma above zero, and not below `finest`, the last decimal of
/// the files.
double step_below(std::span<const double> sigmas, double finest);

/// RFC 1951 (raw deflate) of some bytes.
std::string deflated(std::string_view bytes);

/// RFC 4648 of some bytes.
std::string base64(std::string_view bytes);

}  // namespace piste::page
