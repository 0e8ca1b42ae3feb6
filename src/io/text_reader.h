#pragma once
/// Reads lines of numbers from a text file. Text where a number is expected is a RowError `FILE:LINE: …`.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/io/row_fault.h"

namespace piste {

/// The bytes of a file, mapped into memory; or bytes that are in memory already.
class MappedFile {
 public:
  /// Throws DataError if the file cannot be read.
  explicit MappedFile(const std::string& file);
  /// Bytes in memory, which must outlive this object.
  explicit MappedFile(std::string_view content) : text_(content) {}
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::string_view text() const { return text_; }
  /// Releases the memory before `place`, which will hardly be read again. It can still be read.
  void pass(const char* place) {
    constexpr std::ptrdiff_t kPiece = std::ptrdiff_t{1} << 24;
    if (mapped_ && place - passed_ > kPiece) give_back(place);
  }

 private:
  void give_back(const char* place);
  std::string_view text_;
  const char* passed_ = nullptr;
  bool mapped_ = false;
};

/// Goes through a file line by line and splits each line into fields. Empty lines are skipped. A line ends with LF or
/// CRLF.
class TextReader : public RowSource {
 public:
  enum class Separator {
    kComma,      ///< one comma, spaces around it ignored
    kSemicolon,  ///< one semicolon, spaces around it ignored
    kTab,        ///< one tab, spaces around it ignored
    kSpaces,     ///< any run of spaces, tabs, commas and semicolons
  };
  /// Throws DataError if the file cannot be read. If `content` is given, it is read instead of the file, and `file` is
  /// only its name in errors.
  TextReader(const std::string& file, Separator separator, std::optional<std::string_view> content = {});

  /// Goes to the next line that is not empty; false at the end of the file.
  bool next();
  /// The line without its end, and its fields.
  std::string_view line() const { return line_; }
  const std::vector<std::string_view>& fields() const { return fields_; }
  /// Splits a part of the line into fields instead of the whole line.
  void split(std::string_view text);
  /// Field i as a finite number. A leading `+` is allowed. `column`: its name, where a header gives it one.
  double number(std::size_t i, std::string_view column = {}) const;
  /// The same as a whole number and its remainder: nanoseconds since 1970 keep their digits.
  std::pair<std::int64_t, double> parts(std::size_t i) const;

  std::size_t line_number() const { return place; }
  /// The text that is still to be read.
  std::string_view rest() const { return rest_; }
  /// From the next line on.
  void set_separator(Separator separator) { separator_ = separator; }

 private:
  MappedFile mapped_;
  Separator separator_;
  std::string_view rest_, line_;
  std::vector<std::string_view> fields_;
};

/// A text as a number, with or without a leading `+`. Where commas do not separate fields, as between semicolons and
/// tabs, a comma may be the decimal sign. Nothing if it is no number.
std::optional<double> number_in(std::string_view text, TextReader::Separator separator);

/// Checks that the times of a file are in the order that is asked of them.
class IncreasingTime {
 public:
  explicit IncreasingTime(TimeOrder order = TimeOrder::kIncreasing) : order_(order) {}
  /// Takes the next time as seconds of week, and returns it as seconds of the week in which the file begins: after a
  /// week rollover it continues past 604800. Throws RowError if it does not increase.
  double next(double seconds_of_week, const RowSource& row);
  /// The same for a time that does not start again with each week.
  double later(double time, const RowSource& row);

 private:
  double last_ = 0, week_ = 0;
  bool started_ = false;
  TimeOrder order_;
};

}  // namespace piste
