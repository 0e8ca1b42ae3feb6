#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "core/recording.h"
#include "core/taken_rows.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kLong = 1.5;  // times the usual interval: rows are missing before the next stamp

std::vector<double> spread(const std::vector<double>& time) {
  std::vector<std::size_t> begins;  // of the rows of each stamp
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (i == 0 || time[i] != time[i - 1]) begins.push_back(i);
  }
  if (begins.size() < 2 || begins.size() == time.size()) return time;
  begins.push_back(time.size());
  const std::size_t stamps = begins.size() - 1;
  const auto count = [&](std::size_t s) { return static_cast<double>(begins[s + 1] - begins[s]); };
  std::vector<double> intervals;
  for (std::size_t s = 0; s + 1 < stamps; ++s) {
    const double step = time[begins[s + 1]] - time[begins[s]];
    if (step > 0) intervals.push_back(step / count(s));
  }
  if (intervals.empty()) return time;
  const double usual = median(std::move(intervals));
  std::vector<double> even = time;
  for (std::size_t s = 0; s < stamps; ++s) {
    const double start = time[begins[s]], rows = count(s);
    const bool last = s + 1 == stamps;
    const double room = last ? 0 : time[begins[s + 1]] - start;
    const bool sparse = last || !(room > 0) || room / rows > kLong * usual;
    const double step = sparse ? usual : room / rows;
    const double first = s == 0 && sparse && !last ? start + room - rows * usual : start;
    for (std::size_t i = begins[s]; i < begins[s + 1]; ++i) even[i] = first + static_cast<double>(i - begins[s]) * step;
  }
  return even;
}

// Rows of one stamp must stand together.
void sort_rows(ImuRecording& imu) {
  if (std::is_sorted(imu.time.begin(), imu.time.end())) return;
  std::vector<std::size_t> rows(imu.time.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  std::stable_sort(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) { return imu.time[a] < imu.time[b]; });
  take_rows(imu, rows);
}

}  // namespace

void spread_stamps(ImuRecording& imu) {
  sort_rows(imu);
  imu.time = spread(imu.time);
}

void spread_stamps(GnssRecording& gnss) {
  std::stable_sort(gnss.fixes.begin(), gnss.fixes.end(),
                   [](const GeodeticFix& a, const GeodeticFix& b) { return a.time < b.time; });
  std::vector<double> time;
  time.reserve(gnss.fixes.size());
  for (const GeodeticFix& fix : gnss.fixes) time.push_back(fix.time);
  time = spread(time);
  for (std::size_t i = 0; i < time.size(); ++i) gnss.fixes[i].time = time[i];
}

}  // namespace piste
