#include "io/csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "piste/core/error.h"
#include "piste/math/interruption.h"

namespace piste {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 18;  // bytes that go to a sink at once

// "00" to "99".
constexpr auto kPairs = [] {
  std::array<char, 200> pairs{};
  for (std::size_t i = 0; i < 100; ++i) {
    pairs[2 * i] = static_cast<char>('0' + i / 10);
    pairs[2 * i + 1] = static_cast<char>('0' + i % 10);
  }
  return pairs;
}();

}  // namespace

bool TableRows::next() {
  check_interruption();
  place = following_++;
  return place < table_.rows;
}

double TableRows::number(std::size_t column) const {
  const double value = table_.columns[column].at(place);
  if (!std::isfinite(value)) {
    fail(fmt::format("column `{}`, {}, must be finite; leave out rows without a value", table_.columns[column].name,
                     value),
         RowFault::Kind::kNotFinite);
  }
  return value;
}

CsvReader::CsvReader(const std::string& file, std::span<const std::string> ignore_columns)
    : CsvReader(LogFile{.file = file, .ignore_columns = {ignore_columns.begin(), ignore_columns.end()}}) {}

CsvReader::CsvReader(const LogFile& log) {
  if (log.table) {
    table_.emplace(log.file, *log.table);
    for (const NumberColumn& column : table_->columns()) names_.push_back(column.name);
  } else {
    text_.emplace(log.file, TextReader::Separator::kComma, log.content);
    if (!text_->next())
      throw DataError(log.file + ":1", "the file is empty; a header line that names the columns is expected");
    names_.assign(text_->fields().begin(), text_->fields().end());
  }
  take_header(log.ignore_columns);
}

void CsvReader::take_header(std::span<const std::string> ignore_columns) {
  for (auto name = names_.begin(); name != names_.end(); ++name) {
    if (std::find(names_.begin(), name, *name) != name) {
      fail(fmt::format("column `{}` stands twice in the header", *name));
    }
  }
  use_.assign(names_.size(), Use::kNone);
  values_.assign(names_.size(), 0);
  for (const std::string& name : ignore_columns) {
    const auto place = std::find(names_.begin(), names_.end(), name);
    if (place == names_.end()) {
      fail(fmt::format("there is no column `{}` to ignore; the columns are: {}", name, fmt::join(names_, ", ")));
    }
    use_[static_cast<std::size_t>(place - names_.begin())] = Use::kIgnored;
  }
}

void CsvReader::fail(const std::string& what) const {
  if (!in_rows_) throw DataError(table_ ? table_->file() : text_->where(), what);
  text().fail(what);
}

std::optional<std::size_t> CsvReader::find(std::string_view name) {
  asked_.emplace_back(name);
  const auto place = std::find(names_.begin(), names_.end(), name);
  if (place == names_.end()) return std::nullopt;
  const auto index = static_cast<std::size_t>(place - names_.begin());
  if (use_[index] == Use::kIgnored) return std::nullopt;
  use_[index] = Use::kClaimed;
  return index;
}

std::size_t CsvReader::column(std::string_view name) {
  if (const auto index = find(name)) return *index;
  fail(fmt::format("column `{}` is missing; the columns are: {}", name, fmt::join(names_, ", ")));
}

void CsvReader::finish_header(RowFaults* faults) {
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (use_[i] == Use::kNone && !is_for_use(faults)) {
      faults->unknown_columns.push_back(names_[i]);
    } else if (use_[i] == Use::kNone) {
      fail(fmt::format("unknown column `{}`; known are: {}; or name it in `ignore_columns`", names_[i],
                       fmt::join(asked_, ", ")));
    }
  }
}

bool CsvReader::next() {
  in_rows_ = true;
  const auto take = [this](const auto& number) {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (use_[i] == Use::kClaimed) values_[i] = number(i);
    }
    return true;
  };
  if (table_) return table_->next() && take([this](std::size_t i) { return table_->number(i); });
  if (!text_->next()) return false;
  const std::size_t found = text_->fields().size();
  if (found != names_.size()) {
    text_->fail(fmt::format("{} fields, but the header names {} columns; is the line cut?", found, names_.size()),
                RowFault::Kind::kFields);
  }
  return take([this](std::size_t i) { return text_->number(i, names_[i]); });
}

CsvWriter::CsvWriter(std::vector<CsvColumn> columns, TextSink sink, std::string_view text_column)
    : columns_(std::move(columns)), sink_(std::move(sink)) {
  for (const CsvColumn& c : columns_) text_ += (&c == columns_.data() ? "" : ",") + c.name;
  if (!text_column.empty()) (text_ += ',') += text_column;
  text_ += '\n';
}

namespace {

// Room for a number of append_fixed(), and for its comma.
constexpr std::size_t kLongest = 25;

// Writes a number so that it ends before `end`, and returns where it begins; null if it is beyond exact integers, or no
// number.
char* put_fixed(char* end, double value, int decimals) {
  static constexpr std::array<double, 13> kPowers{1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12};
  const double scaled = std::abs(value) * kPowers[static_cast<std::size_t>(decimals)];
  if (!(scaled < 9e15)) return nullptr;
  auto digits = static_cast<std::uint64_t>(scaled);
  if (scaled - static_cast<double>(digits) >= 0.5) ++digits;
  const bool negative = value < 0 && digits != 0;
  char* p = end;
  const auto pair = [&p, &digits] {
    p -= 2;
    std::memcpy(p, kPairs.data() + 2 * (digits % 100), 2);
    digits /= 100;
  };
  const auto single = [&p, &digits] {
    *--p = static_cast<char>('0' + digits % 10);
    digits /= 10;
  };
  int left = decimals;
  for (; left >= 2; left -= 2) pair();
  if (left > 0) single();
  if (decimals > 0) *--p = '.';
  while (digits >= 100) pair();
  do {
    single();
  } while (digits != 0);
  if (negative) *--p = '-';
  return p;
}

}  // namespace

// A row is written from its end to its beginning, as numbers are.
void CsvWriter::row(std::span<const double> values, std::string_view text) {
  row_.resize(kLongest * columns_.size() + 1);
  char* const end = row_.data() + row_.size();
  char* p = end;
  *--p = '\n';
  for (std::size_t i = columns_.size(); i-- > 0;) {
    p = put_fixed(p, values[i], columns_[i].decimals);
    if (p == nullptr) break;
    if (i > 0) *--p = ',';
  }
  if (p != nullptr) {
    text_.append(p, static_cast<std::size_t>(end - p));
  } else {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (i > 0) text_ += ',';
      append_fixed(text_, values[i], columns_[i].decimals);
    }
    text_ += '\n';
  }
  if (!text.empty()) {
    text_.back() = ',';
    (text_ += text) += '\n';
  }
  if (sink_ && text_.size() > kPiece) finish();
}

void CsvWriter::finish() {
  if (!sink_) return;
  sink_(text_);
  text_.clear();
}

void append_fixed(std::string& text, double value, int decimals) {
  std::array<char, kLongest> buffer;
  char* const end = buffer.data() + buffer.size();
  const char* const p = put_fixed(end, value, decimals);
  if (p == nullptr) {
    fmt::format_to(std::back_inserter(text), "{:.{}f}", value, decimals);
  } else {
    text.append(p, static_cast<std::size_t>(end - p));
  }
}

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace piste
