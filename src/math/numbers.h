#pragma once
/// Reads numbers in text, equally with every standard library.

#include <charconv>

namespace piste {

/// Reads a double as std::from_chars does, which libc++ lacks for it: no blank and no `+` before it, no hexadecimal
/// digits; `value` stays where the result has an error.
std::from_chars_result read_number(const char* first, const char* last, double& value);

/// The same by strtod in the locale "C", for standard libraries without from_chars of a double.
std::from_chars_result read_number_by_strtod(const char* first, const char* last, double& value);

}  // namespace piste
