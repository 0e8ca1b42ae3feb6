#include "piste/consistency/range_sums.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <utility>

#include "piste/core/error.h"

namespace piste {
namespace {

constexpr std::string_view kRangeMagic = "piste range 1\n";

void put_number(std::string& bytes, std::size_t value) {
  const auto wide = static_cast<std::uint64_t>(value);
  bytes.append(reinterpret_cast<const char*>(&wide), sizeof wide);
}

std::size_t take_number(std::string_view& bytes) {
  std::uint64_t wide = 0;
  if (bytes.size() < sizeof wide) throw DataError("ensemble", "the saved range is cut short");
  std::memcpy(&wide, bytes.data(), sizeof wide);
  bytes.remove_prefix(sizeof wide);
  return wide;
}

}  // namespace

void RangeSums::push(Part part) {
  parts_.push_back(std::move(part));
  while (parts_.size() > 1) {
    Part& left = parts_[parts_.size() - 2];
    const Part& right = parts_.back();
    if (left.size != right.size || left.first % (2 * left.size) != 0) return;
    left.sums.append(right.sums);
    left.size *= 2;
    parts_.pop_back();
  }
}

void RangeSums::add(Consistency one) {
  push({end(), 1, std::move(one)});
  ++size_;
}

void RangeSums::append(const RangeSums& later) {
  if (later.first_ != end()) {
    const std::string there =
        size_ == 0 ? "no run is there" : fmt::format("runs {} to {} are there", first_, end() - 1);
    throw DataError("ensemble",
                    fmt::format("{}; the next part must begin with run {}, and not {}", there, end(), later.first_));
  }
  for (const Part& part : later.parts_) {
    push(part);
    size_ += part.size;
  }
}

Consistency RangeSums::total() const {
  Consistency sums(grid_);
  for (const Part& part : parts_) sums.append(part.sums);
  return sums;
}

std::string RangeSums::save() const {
  std::string bytes(kRangeMagic);
  put_number(bytes, first_);
  put_number(bytes, parts_.size());
  for (const Part& part : parts_) {
    const std::string sums = part.sums.save();
    put_number(bytes, part.size);
    put_number(bytes, sums.size());
    bytes += sums;
  }
  return bytes;
}

RangeSums RangeSums::restore(std::string_view bytes) {
  if (!bytes.starts_with(kRangeMagic)) throw DataError("ensemble", "these are no saved runs");
  bytes.remove_prefix(kRangeMagic.size());
  RangeSums out(EpochGrid{}, take_number(bytes));
  const std::size_t blocks = take_number(bytes);
  for (std::size_t i = 0; i < blocks; ++i) {
    const std::size_t size = take_number(bytes), length = take_number(bytes);
    const bool whole = size > 0 && (size & (size - 1)) == 0 && out.end() % size == 0;
    if (!whole || length > bytes.size()) throw DataError("ensemble", "the saved range does not fit together");
    Consistency sums = Consistency::restore(bytes.substr(0, length));
    bytes.remove_prefix(length);
    if (sums.size() != size) throw DataError("ensemble", "the saved range does not fit together");
    out.grid_ = sums.grid();
    out.push({out.end(), size, std::move(sums)});
    out.size_ += size;
  }
  if (!bytes.empty()) throw DataError("ensemble", "the saved range goes on where it should end");
  return out;
}

}  // namespace piste
