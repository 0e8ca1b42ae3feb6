/// The module piste._piste.

#include <nanobind/stl/string_view.h>

#include <exception>

#include "bindings.h"
#include "interruptible.h"
#include "piste/core/error.h"
#include "piste/core/version.h"

namespace piste::python {
namespace {

// Raises the class of piste.errors that has the name of the C++ class.
void raise(const char* name, const Error& error) {
  const nb::object raised = nb::module_::import_("piste.errors").attr(name)(error.what(), error.where());
  PyErr_SetObject(raised.type().ptr(), raised.ptr());
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const ConfigError& e) {
    raise("ConfigError", e);
  } catch (const DataError& e) {
    raise("DataError", e);
  } catch (const Error& e) {
    raise("Error", e);
  }
}

}  // namespace

Numbers owned(std::vector<double>&& values, std::size_t columns) {
  auto* kept = new std::vector<double>(std::move(values));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  if (columns == 0) return Numbers(kept->data(), {kept->size()}, owner);
  return Numbers(kept->data(), {kept->size() / columns, columns}, owner);
}

}  // namespace piste::python

NB_MODULE(_piste, m) {
  using namespace piste::python;
  m.doc() = "The bindings of piste; use the package piste.";
  m.attr("version") = piste::version();
  nb::register_exception_translator(translate);
  bind_configuration(m);
  bind_recordings(m);
  bind_run(m);
  bind_filtering(m);
  bind_programs(m);
}
