#include <algorithm>
#include <numeric>
#include <vector>

#include "core/recording.h"
#include "core/taken_rows.h"

namespace piste {
namespace {

// The rows to keep, in the order of time. Of rows of one time the first in the file is kept.
std::vector<std::size_t> rows_in_order(const std::vector<double>& time, RepairedRows& repaired) {
  std::vector<std::size_t> rows(time.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  for (std::size_t i = 1, latest = 0; i < time.size(); ++i) {
    if (time[i] < time[latest]) ++repaired.sorted;
    if (time[i] > time[latest]) latest = i;
  }
  std::stable_sort(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) { return time[a] < time[b]; });
  rows.erase(std::unique(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) { return time[a] == time[b]; }),
             rows.end());
  repaired.dropped += time.size() - rows.size();
  return rows;
}

template <class Recorded>
void repair_fixes(Recorded& recorded) {
  std::vector<double> time;
  time.reserve(recorded.fixes.size());
  for (const auto& fix : recorded.fixes) time.push_back(fix.time);
  take_rows(recorded.fixes, rows_in_order(time, recorded.repaired));
}

}  // namespace

void repair_rows(ImuRecording& imu) { take_rows(imu, rows_in_order(imu.time, imu.repaired)); }

void repair_rows(GnssRecording& gnss) { repair_fixes(gnss); }
void repair_rows(AttitudeRecording& attitude) { repair_fixes(attitude); }
void repair_rows(FixRecording<SpeedFix>& speed) { repair_fixes(speed); }
void repair_rows(FixRecording<HeightFix>& height) { repair_fixes(height); }
void repair_rows(FixRecording<HeadingFix>& heading) { repair_fixes(heading); }

}  // namespace piste
