#pragma once
/// What an inspection found, in words: for a terminal, and for the page.

#include <optional>
#include <string>
#include <vector>

#include "piste/inspect/inspection.h"

namespace piste {

/// One log, or two beside one another: a title, and facts under their names.
struct InspectionSheet {
  struct Fact {
    std::string name, text;
  };
  std::string title;
  std::vector<Fact> facts;
};

/// A sheet for every log in their order, then for every match.
std::vector<InspectionSheet> inspection_sheets(const Inspection& inspection);

/// All sheets, the ready configuration, and the list of what looks wrong, worst first.
std::string inspection_text(const Inspection& inspection, const std::optional<std::string>& config);

}  // namespace piste
