#include "piste/condition/aligned_signals.h"

#include <algorithm>
#include <span>

#include "piste/condition/signal.h"

namespace piste {

std::vector<Stretch> usable_stretches(const AlignedImus& imus) {
  constexpr double kGap = 1.5;  // intervals
  std::vector<Stretch> out;
  for (std::size_t i = 0; i < imus.time.size(); ++i) {
    if (!imus.usable[i]) continue;
    const bool follows = !out.empty() && out.back().last == i && imus.time[i] - imus.time[i - 1] < kGap * imus.interval;
    if (!follows) out.push_back({i, i});
    out.back().last = i + 1;
  }
  return out;
}

AlignedImus low_passed(const AlignedImus& imus, double cutoff) {
  AlignedImus out = imus;
  out.low_pass = cutoff;
  if (cutoff == 0 || imus.time.empty()) return out;
  const LowPass filter(cutoff, 1 / imus.interval);
  for (const Stretch& s : usable_stretches(imus)) {
    if (static_cast<double>(s.size()) * imus.interval * cutoff < 2) {
      std::fill(out.usable.begin() + static_cast<std::ptrdiff_t>(s.first),
                out.usable.begin() + static_cast<std::ptrdiff_t>(s.last), std::uint8_t{0});
      continue;
    }
    for (const auto series :
         {&AlignedImus::gyro, &AlignedImus::accel, &AlignedImus::reference_gyro, &AlignedImus::reference_accel}) {
      const auto smooth = zero_phase(filter, std::span(imus.*series).subspan(s.first, s.size()));
      std::copy(smooth.begin(), smooth.end(), (out.*series).begin() + static_cast<std::ptrdiff_t>(s.first));
    }
  }
  return out;
}

}  // namespace piste
