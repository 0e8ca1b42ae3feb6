#include "math/numbers.h"

#include <cerrno>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>
#include <version>
#if defined(__APPLE__)
#include <xlocale.h>
#endif

namespace piste {
namespace {

// Never freed: it is used until the program ends.
locale_t c_locale() {
  static const locale_t locale = newlocale(LC_ALL_MASK, "C", nullptr);
  return locale;
}

bool may_belong_to_a_number(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '+' || c == '-';
}

}  // namespace

std::from_chars_result read_number_by_strtod(const char* first, const char* last, double& value) {
  const char* end = first;
  while (end != last && may_belong_to_a_number(*end)) ++end;
  std::string text(first, end);  // strtod reads on to a zero
  // A hexadecimal number ends behind its 0 here; strtod would read it.
  if (const std::size_t x = text.find_first_of("xX"); x != std::string::npos) text.resize(x);
  if (text.empty() || text.front() == '+') return {first, std::errc::invalid_argument};
  char* stopped = nullptr;
  errno = 0;
  const double number = strtod_l(text.c_str(), &stopped, c_locale());
  if (stopped == text.c_str()) return {first, std::errc::invalid_argument};
  const char* const after = first + (stopped - text.c_str());
  if (errno == ERANGE && (number == 0 || std::isinf(number))) return {after, std::errc::result_out_of_range};
  value = number;
  return {after, std::errc{}};
}

std::from_chars_result read_number(const char* first, const char* last, double& value) {
#if defined(__cpp_lib_to_chars)
  return std::from_chars(first, last, value);
#else
  return read_number_by_strtod(first, last, value);
#endif
}

}  // namespace piste
