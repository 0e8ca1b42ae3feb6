#pragma once
/// Lines of numbers from a text file, strictly: what is no number is a RowError `FILE:LINE: …`.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/io/row_fault.h"

namespace piste {

/// Bytes of a file, mapped into memory; or bytes that are there already.
class MappedFile {
 public:
  /// Throws DataError where the file cannot be read.
  explicit MappedFile(const std::string& file);
  /// Bytes that another keeps.
  explicit MappedFile(std::string_view content) : text_(content) {}
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::string_view text() const { return text_; }

 private:
  std::string_view text_;
  bool mapped_ = false;
};

/// Goes through a file line by line and cuts each into fields. Empty lines are passed over; LF and CRLF both end one.
class TextReader : public RowSource {
 public:
  enum class Separator {
    kComma,   ///< one comma, spaces around it ignored
    kTab,     ///< one tab, spaces around it ignored
    kSpaces,  ///< any run of spaces, tabs, commas and semicolons
  };
  /// Throws DataError where the file cannot be read. With `content`, that is read and `file` only names it.
  TextReader(const std::string& file, Separator separator, std::optional<std::string_view> content = {});

  /// Goes to the next line that is not empty; false at the end of the file.
  bool next();
  /// The line without its end, and its fields.
  std::string_view line() const { return line_; }
  const std::vector<std::string_view>& fields() const { return fields_; }
  /// Cuts another text into fields than the whole line: a part of it.
  void split(std::string_view text);
  /// Field i as a finite number; a leading `+` is taken.
  double number(std::size_t i) const;

  std::size_t line_number() const { return place; }

 private:
  MappedFile mapped_;
  Separator separator_;
  std::string_view rest_, line_;
  std::vector<std::string_view> fields_;
};

/// Times of one file: refuses one that does not increase.
class IncreasingTime {
 public:
  /// Seconds of week, as seconds of the week that the file begins in: continues past 604800 where the week rolls over.
  /// Throws RowError of the row.
  double next(double seconds_of_week, const RowSource& row);
  /// The same of a time that counts on already.
  double later(double time, const RowSource& row);

 private:
  double last_ = 0, week_ = 0;
  bool started_ = false;
};

}  // namespace piste
