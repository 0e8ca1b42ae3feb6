/// Configurations: files, or text together with the arrays that it names.

#include <nanobind/stl/map.h>

#include <map>
#include <string>

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
          [](const std::string& text, const std::string& name, const nb::dict& tables,
             const std::map<std::string, std::string>& spelled) {
            NamedColumns named;
            for (const auto& [key, table] : tables) {
              const auto called = nb::cast<std::string>(key);
              named[called] = columns_of(called, nb::cast<nb::dict>(table));
            }
            const auto keyword = [name, spelled](const std::string& path) {
              if (path.empty()) return name;
              const auto other = spelled.find(path);
              if (other != spelled.end()) return other->second + '=';
              return path.find_first_of(".[") == std::string::npos ? path + '=' : path;
            };
            return Configuration{Config::parse(text, name, std::move(named), keyword), tables};
          },
          nb::arg("text"), nb::arg("name"), nb::arg("tables"), nb::arg("spelled"),
          "Reads a configuration from text that was made of keywords, by which errors call its keys. `tables` has "
          "columns of numbers by the names that stand at `file`, and `spelled` the keywords of keys by their paths, "
          "where these differ.");
}

}  // namespace piste::python
