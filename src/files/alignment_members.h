#pragma once
/// The members of alignment.json, which findings.json begins with too.

#include "io/json.h"
#include "piste/condition/alignment.h"

namespace piste {

json::Members alignment_members(const Alignment& alignment);

}  // namespace piste
