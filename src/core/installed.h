#pragma once
/// Where an installed piste keeps its files.

#include <filesystem>

namespace piste {

/// The folder with `sensors/`, `scenarios/` and `articles/`: that of the environment's `PISTE_SHARE`, if it is set;
/// else the one that piste was configured to be installed into, such as /usr/share/piste. It need not be there.
std::filesystem::path shared_folder();

}  // namespace piste
