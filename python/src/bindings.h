#pragma once
/// The parts of the module piste._piste, and their common types.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <string>
#include <vector>

#include "piste/io/config.h"

namespace piste::python {

namespace nb = nanobind;

using Numbers = nb::ndarray<nb::numpy, const double>;

/// A configuration, and the arrays that it names.
struct Configuration {
  Config config;
  nb::object arrays;
};

/// An array of numpy that owns `values`. `columns`: 0 for one dimension.
Numbers owned(std::vector<double>&& values, std::size_t columns = 0);

void bind_configuration(nb::module_& m);
void bind_recordings(nb::module_& m);
void bind_run(nb::module_& m);
void bind_filtering(nb::module_& m);
void bind_programs(nb::module_& m);

}  // namespace piste::python
