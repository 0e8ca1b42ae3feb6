#pragma once
/// Text inside markup.

#include <string>
#include <string_view>

namespace piste {

/// `text` as character data or a quoted attribute of HTML, SVG and KML: & < > " ' are escaped, and control
/// characters that XML forbids become U+FFFD.
std::string escape_markup(std::string_view text);

/// `value` as print has it: "−0.250" with a real minus sign, and never "−0".
std::string decimal(double value, int decimals);

}  // namespace piste
