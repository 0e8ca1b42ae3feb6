/// KF-GINS's navigation results, and the truth files of its data sets.

#include <fmt/format.h>

#include "io/text_reader.h"
#include "piste/math/units.h"
#include "trajectory/formats.h"

namespace piste::trajectory_formats {

bool is_kf_gins(const FileStart& start) { return start.numbers == 11 && !start.commas; }

Trajectory read_kf_gins(const std::string& file) {
  TextReader reader(file, TextReader::Separator::kSpaces);
  Trajectory track;
  IncreasingTime increasing;
  while (reader.next()) {
    if (reader.line().starts_with('#') || reader.line().starts_with('%')) continue;
    if (reader.fields().size() != 11) {
      reader.fail(fmt::format("{} fields; 11 are expected: week, t, latitude, longitude [deg], height, velocity n e d, "
                              "roll, pitch, yaw [deg]",
                              reader.fields().size()),
                  RowFault::Kind::kFields);
    }
    const auto number = [&](std::size_t i) { return reader.number(i); };
    track.time.push_back(increasing.next(number(1), reader));
    track.place.push_back({kDegree * number(2), kDegree * number(3), number(4)});
    track.velocity.emplace_back(number(5), number(6), number(7));
    track.attitude.push_back(from_euler(kDegree * Vector3d(number(8), number(9), number(10))));
  }
  return track;
}

}  // namespace piste::trajectory_formats
