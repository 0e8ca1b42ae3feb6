#include "io/fix_quality.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

#include "io/lower_case.h"

namespace piste::log_formats {
namespace {

// A number from 1 as one of these; nothing beyond them.
template <std::size_t N>
std::optional<FixQuality> numbered(const std::array<FixQuality, N>& all, double number) {
  for (std::size_t i = 0; i < N; ++i) {
    if (number == static_cast<double>(i + 1) && all[i] != FixQuality::kUnknown) return all[i];
  }
  return std::nullopt;
}

}  // namespace

std::optional<FixQuality> quality_of_nmea(double indicator) {
  using enum FixQuality;  // 7 is a place that was typed in, 8 a simulator's; 9 is NovAtel's, with SBAS
  static constexpr std::array kAll{kSingle,       kDifferential, kPrecise, kFixed, kFloat,
                                   kDeadReckoned, kUnknown,      kUnknown, kSbas};
  return numbered(kAll, indicator);
}

std::optional<FixQuality> quality_of_rtklib(double q) {
  using enum FixQuality;
  static constexpr std::array kAll{kFixed, kFloat, kSbas, kDifferential, kSingle, kPrecise, kDeadReckoned};
  return numbered(kAll, q);
}

std::uint8_t satellites_of(double number) {
  constexpr double kMost = std::numeric_limits<std::uint8_t>::max();
  return number > 0 ? static_cast<std::uint8_t>(std::min(number, kMost)) : std::uint8_t{0};
}

std::optional<FixQuality> quality_of_word(std::string_view word) {
  using enum FixQuality;
  // The first that is in the word: `rtk float` before `rtk`.
  static constexpr std::array<std::pair<std::string_view, FixQuality>, 22> kParts{
      {{"dead", kDeadReckoned},   {"estimat", kDeadReckoned},
       {"reckon", kDeadReckoned}, {"no", kUnknown},
       {"invalid", kUnknown},     {"float", kFloat},
       {"sbas", kSbas},           {"waas", kSbas},
       {"egnos", kSbas},          {"ppp", kPrecise},
       {"dgps", kDifferential},   {"dgnss", kDifferential},
       {"diff", kDifferential},   {"single", kSingle},
       {"spp", kSingle},          {"autonom", kSingle},
       {"3d", kSingle},           {"2d", kSingle},
       {"gps", kSingle},          {"fix", kFixed},
       {"int", kFixed},           {"rtk", kFixed}}};
  const std::string lower = lower_case(word);
  for (const auto& [part, quality] : kParts) {
    if (lower.find(part) == std::string::npos) continue;
    return quality == kUnknown ? std::nullopt : std::optional(quality);
  }
  return std::nullopt;
}

}  // namespace piste::log_formats
