#pragma once
/// Prepares text and numbers for HTML, SVG and KML.

#include <string>
#include <string_view>

namespace piste {

/// `text` as character data or a quoted attribute of HTML, SVG and KML: & < > " ' are escaped, and control
/// characters that XML forbids become U+FFFD.
std::string escape_markup(std::string_view text);

/// `value` with `decimals` digits after the point and a typographic minus sign, such as "−0.250". Never "−0".
std::string decimal(double value, int decimals);

}  // namespace piste
