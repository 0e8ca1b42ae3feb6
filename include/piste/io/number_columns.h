#pragma once
/// Columns of numbers in memory of the caller, which a reader of CSV takes in place of a file.

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace piste {

/// One column: `rows` of its table, `stride` doubles apart.
struct NumberColumn {
  std::string name;  ///< with its unit, as in the header of a csv (log_io.h)
  const double* first = nullptr;
  std::ptrdiff_t stride = 1;

  double at(std::size_t row) const { return first[static_cast<std::ptrdiff_t>(row) * stride]; }
};

/// A table. The caller keeps the numbers in place until it has been read.
struct NumberColumns {
  std::vector<NumberColumn> columns;
  std::size_t rows = 0;
};

/// Tables by the names with which a configuration calls them: `file: NAME` is then no file.
using NamedColumns = std::map<std::string, NumberColumns, std::less<>>;

}  // namespace piste
