#include "alignment_epochs.h"

#include <algorithm>
#include <cmath>

#include "piste/math/statistics.h"

namespace piste {

std::vector<AlignmentEpoch> epochs_in_common(const SignalPair& signals, const FilteredPair& pair,
                                             const AlignmentState& x) {
  const std::vector<double>& time = pair.body.time;
  const ReferenceIntegrals& reference = signals.integrals;
  const double margin = pair.margin + 2 * pair.body.step;
  std::vector<AlignmentEpoch> epochs;
  for (std::size_t k = 0; k < time.size(); k += pair.stride) {
    const double m = time[k], t = x.reference_time(m, time.front());
    if (m - margin < time.front() || m + margin > time.back()) continue;
    if (t - margin < reference.start() || t + margin > reference.end()) continue;
    if (reference.silent(t - margin, t + pair.margin)) continue;
    epochs.push_back({.sample = k, .usable = pair.body.usable[k]});
  }
  return epochs;
}

void mark_motion(const FilteredPair& pair, const AlignmentState& x, std::vector<AlignmentEpoch>& epochs) {
  constexpr double kAround = 1, kLively = 0.2, kLiveliest = 0.95;
  if (epochs.empty()) return;
  std::vector<double> squares{0};
  for (const AlignmentEpoch& e : epochs) {
    const double t = x.reference_time(pair.body.time[e.sample], pair.body.time.front());
    squares.push_back(squares.back() + pair.reference.at(t).signal.gyro.squaredNorm());
  }
  const auto around = static_cast<std::size_t>(kAround / (pair.body.step * static_cast<double>(pair.stride))) + 1;
  std::vector<double> rms;
  for (std::size_t i = 0; i < epochs.size(); ++i) {
    const std::size_t from = i > around ? i - around : 0, to = std::min(epochs.size(), i + around + 1);
    rms.push_back(std::sqrt((squares[to] - squares[from]) / static_cast<double>(to - from)));
  }
  const double limit = kLively * quantile(rms, kLiveliest);
  for (std::size_t i = 0; i < epochs.size(); ++i) epochs[i].moving = rms[i] > limit;
}

}  // namespace piste
