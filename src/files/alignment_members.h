#pragma once
/// The members of alignment.json. findings.json begins with the same members.

#include "io/json.h"
#include "piste/condition/alignment.h"

namespace piste {

json::Members alignment_members(const Alignment& alignment);

}  // namespace piste
