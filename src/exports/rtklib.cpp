/// A solution of RTKLIB in latitude, longitude and height, with velocities.

#include <fmt/format.h>

#include "exports/formats.h"

namespace piste::export_formats {

std::vector<ExportedFile> rtklib(const ExportRun& run) {
  const Trajectory& track = run.track;
  const bool sigmas = !track.sigma_position.empty() && !track.sigma_velocity.empty();
  std::string text =
      "% program   : piste\n% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp)\n"
      "%  GPST                      latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)  "
      "sdne(m)  "
      "sdeu(m)  sdun(m) age(s)  ratio    vn(m/s)    ve(m/s)    vu(m/s)      sdvn     sdve     sdvu    sdvne    sdveu   "
      " "
      "sdvun\n";
  for (std::size_t i = 0; i < track.size(); ++i) {
    const CalendarTime t = calendar_time(gps_time_of(run, i), TimeSystem::kGps);
    const Geodetic& place = track.place[i];
    const Vector3d &v = track.velocity[i], none = Vector3d::Zero();
    const Vector3d &sp = sigmas ? track.sigma_position[i] : none, &sv = sigmas ? track.sigma_velocity[i] : none;
    fmt::format_to(std::back_inserter(text),
                   "{:04}/{:02}/{:02} {:02}:{:02}:{:02}.{:06} {:15.10f} {:15.10f} {:11.5f}   5   0 {:8.5f} {:8.5f} "
                   "{:8.5f}   0.0000   0.0000   0.0000   0.00    0.0 {:10.5f} {:10.5f} {:10.5f}   {:7.5f}  {:7.5f}  "
                   "{:7.5f}  0.00000  0.00000  0.00000\n",
                   t.year, t.month, t.day, t.hour, t.minute, t.second, t.microsecond,
                   kDegreesPerRadian * place.latitude, kDegreesPerRadian * place.longitude, place.height, sp.x(),
                   sp.y(), sp.z(), v.x(), v.y(), -v.z(), sv.x(), sv.y(), sv.z());
  }
  return {{".pos", std::move(text)}};
}

}  // namespace piste::export_formats
