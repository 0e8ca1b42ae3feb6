#include "column_units.h"

namespace piste {
namespace {

std::string unit_named(const ColumnTable& table, std::size_t column, const Dimension& dimension) {
  const SampledColumn& c = table.columns[column];
  for (std::string unit : {c.cell.unit, unit_spelt(words_of(c.cell.unit)), c.unit}) {
    if (measures(unit, dimension)) return unit;
  }
  return {};
}

}  // namespace

bool has_known_brackets(const ColumnTable& table, std::size_t column, const Dimension& dimension) {
  return table.header && !table.by_number && measures(table.columns[column].cell.unit, dimension);
}

bool has_unit(const ColumnTable& table, std::size_t column, const Dimension& dimension) {
  return has_known_brackets(table, column, dimension) || !unit_named(table, column, dimension).empty();
}

std::string unit_of(const ColumnTable& table, std::size_t column, const Dimension& dimension,
                    const std::string& else_unit) {
  if (has_known_brackets(table, column, dimension)) return {};
  std::string named = unit_named(table, column, dimension);
  return named.empty() ? else_unit : named;
}

}  // namespace piste
