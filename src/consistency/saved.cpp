// Saves and restores the sums of an ensemble as bytes, so that it can continue where it was stopped.

#include <cstring>
#include <type_traits>
#include <utility>

#include "piste/consistency/consistency.h"
#include "piste/core/error.h"
#include "sums.h"

namespace piste {
namespace {

constexpr std::string_view kMagic = "piste consistency 2\n";

template <class T>
void put(std::string& bytes, const T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  } else {
    put(bytes, value.size());
    for (const auto& item : value) put(bytes, item);
  }
}

// Reads values in the order in which they were written.
template <class T>
void take(std::string_view& bytes, T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    if (bytes.size() < sizeof value) throw DataError("ensemble", "the saved sums are cut short");
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes.remove_prefix(sizeof value);
  } else {
    std::size_t size = 0;
    take(bytes, size);
    if (size > bytes.size()) throw DataError("ensemble", "the saved sums are cut short");
    value.resize(size);
    for (auto& item : value) take(bytes, item);
  }
}

}  // namespace

template <class Self, class Visitor>
void Consistency::visit(Self& self, Visitor&& visit) {
  visit(self.grid_.step), visit(self.grid_.first), visit(self.grid_.last);
  visit(self.grid_.cruise.start), visit(self.grid_.cruise.end), visit(self.grid_.arrival);
  visit(self.runs_);
  for (auto* s : {&self.filter_, &self.smoother_}) {
    for (auto* table :
         {&s->runs, &s->nees, &s->square, &s->bound, &s->claimed, &s->phase_runs, &s->mean, &s->mean_square, &s->errors,
          &s->within, &s->largest, &s->largest_seed, &s->ratio, &s->ratio_square}) {
      visit(*table);
    }
  }
  visit(self.sources_), visit(self.source_sums_), visit(self.heading_);
}

std::string Consistency::save() const {
  std::string bytes(kMagic);
  visit(*this, [&](const auto& value) { put(bytes, value); });
  put(bytes, layout_.blocks().size());
  for (const Block b : layout_.blocks()) put(bytes, index_of(b));
  put(bytes, failures_.size());
  for (const FailedRun& f : failures_) {
    put(bytes, f.seed);
    put(bytes, f.what);
  }
  return bytes;
}

Consistency Consistency::restore(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) throw DataError("ensemble", "these are no saved sums");
  bytes.remove_prefix(kMagic.size());
  Consistency out{EpochGrid{}};
  visit(out, [&](auto& value) { take(bytes, value); });
  std::vector<int> blocks;
  take(bytes, blocks);
  std::vector<Block> layout;
  for (const int b : blocks) {
    if (b < 0 || b >= kBlockCount) throw DataError("ensemble", "the saved sums name an unknown block");
    layout.push_back(static_cast<Block>(b));
  }
  if (out.runs_ > 0) {  // else nothing is allotted yet
    Consistency fitting(out.grid_);
    if (index(out.grid_.size()) == out.filter_.runs.size()) fitting.allot(StateLayout(layout), out.sources_);
    const auto sizes = [](const Consistency& of) {
      std::vector<std::size_t> all;
      visit(of, [&](const auto& value) {
        if constexpr (requires { value.size(); }) all.push_back(value.size());
      });
      return all;
    };
    if (sizes(out) != sizes(fitting)) throw DataError("ensemble", "the saved sums do not fit one another");
    out.layout_ = fitting.layout_;
    out.groups_ = fitting.groups_;
  }
  std::size_t failures = 0;
  take(bytes, failures);
  for (std::size_t i = 0; i < failures; ++i) {
    FailedRun failure;
    take(bytes, failure.seed);
    take(bytes, failure.what);
    out.failures_.push_back(std::move(failure));
  }
  if (!bytes.empty()) throw DataError("ensemble", "the saved sums go on where they should end");
  return out;
}

}  // namespace piste
