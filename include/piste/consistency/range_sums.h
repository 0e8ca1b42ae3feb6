#pragma once
/// The sums over a range of runs, the same to the last bit however the range was cut into parts.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "piste/consistency/consistency.h"

namespace piste {

/// Sums of neighbouring runs are added pairwise (pairwise summation, Higham 2002, section 4.2). In a block of 2, 4, 8,
/// … runs that begins at a multiple of its length, the two halves are always added first. So the order of all additions
/// follows from the numbers of the runs alone. Parts that were computed on several machines merge to the same bytes. At
/// most two blocks of each length are kept.
class RangeSums {
 public:
  /// An empty range that begins with run `first`.
  explicit RangeSums(const EpochGrid& grid, std::size_t first = 0) : grid_(grid), first_(first) {}

  std::size_t first() const { return first_; }
  std::size_t size() const { return size_; }
  /// The number of the run that comes next.
  std::size_t end() const { return first_ + size_; }

  /// Adds the next run: `one` has nothing else. Throws DataError if it estimates other blocks than those before.
  void add(Consistency one);
  /// Adds the runs that follow. Throws DataError if `later` begins elsewhere than at end(), or is of another scenario.
  void append(const RangeSums& later);

  /// The sums of all runs.
  Consistency total() const;

  /// Saves them as bytes, and restores them on the same kind of machine. Throws DataError if the bytes are not from
  /// `save`.
  std::string save() const;
  static RangeSums restore(std::string_view bytes);

 private:
  struct Part {
    std::size_t first, size;  ///< the size is a power of 2, of which `first` is a multiple
    Consistency sums;
  };
  void push(Part part);

  EpochGrid grid_;
  std::size_t first_, size_ = 0;
  std::vector<Part> parts_;
};

}  // namespace piste
