#pragma once
/// Collects suspicions of one file.

#include <string>
#include <utility>
#include <vector>

#include "piste/inspect/suspicion.h"

namespace piste {

/// A function (fault, what, remedy) that adds a suspicion of `file` to `found`. @pre both outlive it
inline auto adding_to(std::vector<Suspicion>& found, const std::string& file) {
  return [&found, &file](LogFault fault, std::string what, std::string remedy) {
    found.push_back({fault, file, std::move(what), std::move(remedy)});
  };
}

}  // namespace piste
