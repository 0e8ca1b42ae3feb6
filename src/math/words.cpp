#include "math/words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "math/time.h"

namespace piste {

std::string with_decimals(double value, int decimals) {
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  const bool zero = text.find_first_of("123456789nif") == std::string::npos;
  return zero && text.front() == '-' ? text.substr(1) : text;
}

std::string plain(double value, int digits) {
  if (value == 0) return "0";
  if (!std::isfinite(value)) return fmt::format("{}", value);
  const int before = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;  // digits before the point
  const double unit = std::pow(10.0, digits - before);
  std::string text = fmt::format("{:.{}f}", std::round(value * unit) / unit, std::max(0, digits - before));
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string rounded(double value, double sigma) {
  if (!(sigma > 0) || !std::isfinite(sigma) || !std::isfinite(value)) return plain(value, 4);
  const int second = static_cast<int>(std::floor(std::log10(sigma))) - 1;  // power of ten of the sigma's second digit
  const double unit = std::pow(10.0, second);
  return with_decimals(std::round(value / unit) * unit, std::max(0, -second));
}

std::string measured(double value, double sigma) {
  return fmt::format("{} ± {}", rounded(value, sigma), rounded(sigma, sigma));
}

std::string time_text(double seconds) {
  const double size = std::abs(seconds);
  if (size < 0.1) return fmt::format("{} ms", plain(1e3 * seconds));
  if (size < kHour) return fmt::format("{:.3f} s", seconds);
  if (size < kDay) return fmt::format("{:.2f} h ({:.3f} s)", seconds / kHour, seconds);
  return fmt::format("{:.2f} days ({:.3f} s)", seconds / kDay, seconds);
}

std::string delay_text(double delay) {
  return fmt::format("{} {}", time_text(std::abs(delay)), delay < 0 ? "early" : "late");
}

}  // namespace piste
