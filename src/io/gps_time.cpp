#include "io/gps_time.h"

#include "math/time.h"

namespace piste::log_formats {

double WeekTime::next(const GpsTime& time, const RowSource& row) {
  const int first = first_week_.value_or(time.week);
  const double t = increasing_.later(time.seconds + (time.week - first) * kWeek, row);
  first_week_ = first;
  return t;
}

}  // namespace piste::log_formats
