/// Configurations: files, or text with arrays under the names that it calls them by.

#include "bindings.h"

namespace piste::python {
namespace {

using Column = nb::ndarray<const double, nb::ndim<1>, nb::device::cpu>;

NumberColumns columns_of(const std::string& name, const nb::dict& table) {
  NumberColumns columns;
  bool first = true;
  for (const auto& [key, value] : table) {
    const auto column = nb::cast<Column>(value);
    if (!first && column.shape(0) != columns.rows) {
      throw nb::value_error((name + ": the columns are of different lengths").c_str());
    }
    first = false;
    columns.rows = column.shape(0);
    columns.columns.push_back({nb::cast<std::string>(key), column.data(), column.stride(0)});
  }
  return columns;
}

}  // namespace

void bind_configuration(nb::module_& m) {
  nb::class_<Configuration>(m, "Configuration")
      .def_static(
          "load",
          [](const std::string& file) {
            return Configuration{Config::load(file), nb::none()};
          },
          nb::arg("file"), "Reads a configuration file.")
      .def_static(
          "parse",
          [](const std::string& text, const std::string& name, const nb::dict& tables) {
            NamedColumns named;
            for (const auto& [key, table] : tables) {
              const auto called = nb::cast<std::string>(key);
              named[called] = columns_of(called, nb::cast<nb::dict>(table));
            }
            return Configuration{Config::parse(text, name, std::move(named)), tables};
          },
          nb::arg("text"), nb::arg("name"), nb::arg("tables"),
          "Reads a configuration from text; `tables` has columns of numbers by the names that stand at `file`.");
}

}  // namespace piste::python
