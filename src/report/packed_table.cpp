#include "report/packed_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/beast/zlib/deflate_stream.hpp>
#include <cmath>

#include "io/json.h"

namespace piste::page {
namespace {

constexpr std::int64_t kMissing = std::numeric_limits<std::int64_t>::min();
constexpr int kOrders = 3;
const double kSigmaStep = std::log(1.005);
constexpr double kLeastSigma = 1e-15;  // stands for zero

std::uint64_t zigzag(std::int64_t number) {
  return (static_cast<std::uint64_t>(number) << 1) ^ static_cast<std::uint64_t>(number >> 63);
}

// Differences of the numbers that are there. `order` 0: the numbers themselves.
class Differences {
 public:
  explicit Differences(int order) : order_(order) {}
  std::int64_t next(std::int64_t number) {
    std::int64_t left = number;
    for (int k = 0; k < order_; ++k) {
      const std::int64_t before = before_[static_cast<std::size_t>(k)];
      before_[static_cast<std::size_t>(k)] = left;
      left -= before;
    }
    return left;
  }

 private:
  int order_;
  std::array<std::int64_t, kOrders> before_{};
};

double bits_of(std::span<const std::int64_t> numbers, int order) {
  Differences differences(order);
  double bits = 0;
  for (const std::int64_t number : numbers) {
    if (number != kMissing) bits += std::log2(1 + static_cast<double>(zigzag(differences.next(number))));
  }
  return bits;
}

// 0 is a missing number, n + 1 the number n: seven bits a byte, the lowest first.
void append(std::string& bytes, std::uint64_t number) {
  constexpr std::uint64_t kSeven = 0x7f, kMore = 0x80;
  while (number > kSeven) {
    bytes += static_cast<char>((number & kSeven) | kMore);
    number >>= 7;
  }
  bytes += static_cast<char>(number);
}

}  // namespace

double step_below(std::span<const double> sigmas, double finest) {
  constexpr double kParts = 150;
  double least = std::numeric_limits<double>::infinity();
  for (const double s : sigmas) {
    if (s > 0) least = std::min(least, s);
  }
  return std::isfinite(least) ? std::max(least / kParts, finest) : finest;
}

void PackedTable::add(std::string name, std::span<const double> values, double step) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(values.size());
  for (const double v : values) numbers.push_back(std::isfinite(v) ? std::llround(v / step) : kMissing);
  store(std::move(name), numbers, step, false);
}

void PackedTable::add_sigma(std::string name, std::span<const double> values) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(values.size());
  for (const double v : values) {
    numbers.push_back(std::isfinite(v) ? std::llround(std::log(std::max(v, kLeastSigma)) / kSigmaStep) : kMissing);
  }
  store(std::move(name), numbers, kSigmaStep, true);
}

void PackedTable::store(std::string name, std::span<const std::int64_t> numbers, double step, bool log) {
  std::array<double, kOrders> bits{};
  for (int order = 0; order < kOrders; ++order) bits[static_cast<std::size_t>(order)] = bits_of(numbers, order);
  const auto order = static_cast<int>(std::min_element(bits.begin(), bits.end()) - bits.begin());
  rows_ = numbers.size();
  columns_.push_back({std::move(name), step, log, order, bytes_.size()});
  Differences differences(order);
  for (const std::int64_t number : numbers) {
    append(bytes_, number == kMissing ? 0 : zigzag(differences.next(number)) + 1);
  }
}

Envelope::Envelope(std::vector<std::string> names, std::size_t rows) {
  constexpr std::size_t kGroups = 12000;
  each_ = 1 + rows / kGroups;
  for (std::string& name : names) signals_.push_back({.name = std::move(name)});
}

void Envelope::add(double time, std::span<const double> values) {
  for (std::size_t k = 0; k < signals_.size(); ++k) {
    Signal& s = signals_[k];
    s.least = count_ == 0 ? values[k] : std::min(s.least, values[k]);
    s.most = count_ == 0 ? values[k] : std::max(s.most, values[k]);
    s.sum += values[k];
  }
  last_ = time;
  if (++count_ == each_) close();
}

void Envelope::close() {
  if (count_ == 0) return;
  time_.push_back(last_);
  for (Signal& s : signals_) {
    s.means.push_back(s.sum / static_cast<double>(count_));
    s.leasts.push_back(s.least);
    s.mosts.push_back(s.most);
    s.sum = 0;
  }
  count_ = 0;
}

std::string Envelope::json() {
  constexpr double kSteps = 50000, kFinest = 1e-7, kTimeStep = 1e-6;
  close();
  PackedTable table;
  table.add("time_s", time_, kTimeStep);
  for (const Signal& s : signals_) {
    if (s.means.empty()) continue;
    const double range = *std::ranges::max_element(s.mosts) - *std::ranges::min_element(s.leasts);
    const double step = std::isfinite(range) ? std::max(range / kSteps, kFinest) : kFinest;
    table.add(s.name, s.means, step);
    if (!has_extremes()) continue;
    table.add(s.name + "_least", s.leasts, step);
    table.add(s.name + "_most", s.mosts, step);
  }
  return table.json();
}

std::string PackedTable::json() const {
  std::vector<std::string> columns;
  for (const Column& c : columns_) {
    columns.push_back(json::object({{"name", json::string(c.name)},
                                    {"step", json::number(c.step, std::numeric_limits<double>::max_digits10)},
                                    {"log", json::boolean(c.log)},
                                    {"order", fmt::format("{}", c.order)},
                                    {"at", fmt::format("{}", c.at)}}));
  }
  return json::object({{"rows", fmt::format("{}", rows_)},
                       {"columns", json::array(columns)},
                       {"data", '"' + base64(deflated(bytes_)) + '"'}});
}

std::string deflated(std::string_view bytes) {
  namespace zlib = boost::beast::zlib;
  zlib::deflate_stream stream;
  stream.reset(6, 15, 9, zlib::Strategy::normal);
  std::string out(stream.upper_bound(bytes.size()) + 16, '\0');
  zlib::z_params z;
  z.next_in = bytes.data();
  z.avail_in = bytes.size();
  z.next_out = out.data();
  z.avail_out = out.size();
  boost::beast::error_code error;
  stream.write(z, zlib::Flush::finish, error);
  out.resize(z.total_out);
  return out;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    const std::size_t there = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      three = (three << 8) | (k < there ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) out += k <= there ? kDigits[(three >> (18 - 6 * k)) & 63U] : '=';
  }
  return out;
}

}  // namespace piste::page
