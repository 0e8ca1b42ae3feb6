#pragma once

#include <string>

namespace piste {

/// The version of this library, such as 0.1.0.
std::string version();

}  // namespace piste
