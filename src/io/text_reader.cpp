#include "io/text_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <system_error>

#include "math/numbers.h"
#include "math/time.h"
#include "piste/core/error.h"
#include "piste/math/interruption.h"

namespace piste {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_gap(char c) { return is_blank(c) || c == ',' || c == ';'; }

// Whether commas separate no fields.
bool may_be_decimal_comma(TextReader::Separator separator) {
  return separator == TextReader::Separator::kSemicolon || separator == TextReader::Separator::kTab;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// Without blanks around it, and without the quotes around it.
std::string_view unquoted(std::string_view text) {
  text = trimmed(text);
  const bool has = text.size() > 1 && text.starts_with('"') && text.ends_with('"');
  return has ? trimmed(text.substr(1, text.size() - 2)) : text;
}

}  // namespace

std::string RowSource::where() const {
  static constexpr std::array<std::string_view, 3> kBetween{":", ": byte ", ": row "};
  return fmt::format("{}{}{}", file_, kBetween[static_cast<std::size_t>(counts_)], place);
}

void RowSource::fail(const std::string& what, RowFault::Kind kind) const {
  throw RowError(where(), {kind, place, what});
}

MappedFile::MappedFile(const std::string& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  const bool readable = descriptor >= 0 && ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  const int reason = errno;
  void* data = nullptr;
  if (readable && status.st_size > 0) {
    data = ::mmap(nullptr, static_cast<std::size_t>(status.st_size), PROT_READ, MAP_PRIVATE, descriptor, 0);
  }
  if (descriptor >= 0) ::close(descriptor);
  if (!readable || data == MAP_FAILED) {
    throw DataError(file, fmt::format("cannot be read ({}); give the path of a text file",
                                      descriptor < 0 ? std::system_category().message(reason) : "no ordinary file"));
  }
  mapped_ = data != nullptr;
  if (mapped_) text_ = {static_cast<const char*>(data), static_cast<std::size_t>(status.st_size)};
  passed_ = text_.data();
}

MappedFile::~MappedFile() {
  if (mapped_) ::munmap(const_cast<char*>(text_.data()), text_.size());
}

void MappedFile::give_back(const char* place) {
  const std::ptrdiff_t page = ::sysconf(_SC_PAGESIZE), whole = (place - passed_) / page * page;
  ::madvise(const_cast<char*>(passed_), static_cast<std::size_t>(whole), MADV_DONTNEED);
  passed_ += whole;
}

TextReader::TextReader(const std::string& file, Separator separator, std::optional<std::string_view> content)
    : RowSource(file, Counts::kLines),
      mapped_(content ? MappedFile(*content) : MappedFile(file)),
      separator_(separator),
      rest_(mapped_.text()) {
  if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);  // byte-order mark
}

bool TextReader::next() {
  check_interruption();
  while (!rest_.empty()) {
    mapped_.pass(rest_.data());
    const std::size_t end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++place;
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    if (trimmed(line_).empty()) continue;
    split(line_);
    return true;
  }
  return false;
}

void TextReader::split(std::string_view text) {
  fields_.clear();
  const char* p = text.data();
  const char* const end = p + text.size();
  const auto field = [](const char* from, const char* to) {
    return std::string_view(from, static_cast<std::size_t>(to - from));
  };
  if (separator_ != Separator::kSpaces) {
    const char separator = separator_ == Separator::kTab ? '\t' : separator_ == Separator::kComma ? ',' : ';';
    const bool quotes = text.find('"') != std::string_view::npos;
    bool quoted = false;
    for (const char* start = p;; ++p) {
      if (quotes && p != end && *p == '"') quoted = !quoted;
      if (p != end && (*p != separator || quoted)) continue;
      fields_.push_back(quotes ? unquoted(field(start, p)) : trimmed(field(start, p)));
      if (p == end) return;
      start = p + 1;
    }
  }
  while (p != end) {
    while (p != end && is_gap(*p)) ++p;
    const char* const start = p;
    while (p != end && !is_gap(*p)) ++p;
    if (p != start) fields_.push_back(field(start, p));
  }
}

std::optional<double> number_in(std::string_view text, TextReader::Separator separator) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = read_number(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return std::nullopt;
  if (end == text.data() + text.size()) return value;
  if (*end != ',' || !may_be_decimal_comma(separator)) return std::nullopt;
  std::string with_point(text);
  with_point[static_cast<std::size_t>(end - text.data())] = '.';
  return number_in(with_point, TextReader::Separator::kComma);
}

double TextReader::number(std::size_t i, std::string_view column) const {
  const auto number = number_in(fields_[i], separator_);
  if (!number) {
    fail(fmt::format("field {}, `{}`, is no number{}", i + 1, fields_[i],
                     column.empty() ? "" : fmt::format("; column `{}` needs one", column)),
         RowFault::Kind::kText);
  }
  const double value = *number;
  if (!std::isfinite(value)) {
    fail(fmt::format("field {}, `{}`, must be finite; leave out rows without a value", i + 1, fields_[i]),
         RowFault::Kind::kNotFinite);
  }
  return value;
}

std::pair<std::int64_t, double> TextReader::parts(std::size_t i) const {
  const std::string_view text = fields_[i];
  std::int64_t whole = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, whole);
  if (error == std::errc{} && end == last) return {whole, 0};
  const bool point = error == std::errc{} && (*end == '.' || (*end == ',' && may_be_decimal_comma(separator_)));
  if (point && end != text.data()) {
    std::string digits(end, last);
    digits.front() = '.';
    const auto rest = number_in(digits, Separator::kComma);
    if (rest && *rest < 1) return {whole, text.starts_with('-') ? -*rest : *rest};
  }
  const double value = number(i);
  constexpr double kLargest = 9e18;
  if (!(std::abs(value) < kLargest)) fail(fmt::format("field {}, `{}`, is too large", i + 1, text));
  whole = static_cast<std::int64_t>(value);
  return {whole, value - static_cast<double>(whole)};
}

double IncreasingTime::next(double seconds_of_week, const RowSource& row) {
  double rolled = started_ && seconds_of_week + week_ < last_ - kWeek / 2 ? kWeek : 0;
  // A row out of order may stand before the end of the week that its neighbours have passed.
  if (order_ == TimeOrder::kAny && started_ && seconds_of_week + week_ > last_ + kWeek / 2) rolled = -kWeek;
  const double time = later(seconds_of_week + week_ + rolled, row);
  week_ += rolled;
  return time;
}

double IncreasingTime::later(double time, const RowSource& row) {
  const bool wrong = order_ == TimeOrder::kIncreasing ? !(time > last_) : order_ == TimeOrder::kShared && time < last_;
  if (started_ && wrong) {
    row.fail(fmt::format("time {:.6f} s does not increase, the row before is at {:.6f} s; sort the rows and keep each "
                         "time once, or let piste do so: `repair: true`",
                         time, last_),
             time == last_ ? RowFault::Kind::kTimeRepeated : RowFault::Kind::kTimeBack);
  }
  started_ = true;
  last_ = time;
  return time;
}

}  // namespace piste
