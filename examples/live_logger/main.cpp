// A logger that knows where it is: takes rows of an IMU and fixes of a receiver as they come, and prints the state once
// a second. The rows come from recorded logs here, in the order in which a device would have had them: each fix 0.2 s
// after it was measured. In your logger, call the two `add` from the loop that reads the ports.
//
//   live_logger ../../config/ski_run.yaml

#include <piste/piste.h>

#include <cstdio>
#include <exception>

namespace {

constexpr double kLatency = 0.2;  // s from a fix to its arrival

void print_state(const piste::LiveState& state) {
  std::printf("%10.2f s  north %6.2f  east %6.2f m/s  ± %.2f m  heading %7.2f ± %.2f deg%s\n", state.time,
              state.velocity.x(), state.velocity.y(), state.sigmas.position.head<2>().norm(),
              state.euler.z() * piste::kDegreesPerRadian, state.sigmas.euler.z() * piste::kDegreesPerRadian,
              state.heading_known ? "" : " (not known yet)");
}

// The session of a configuration: its receivers and its IMU. A session has no reference attitude, so blocks that only
// such a reference determines are left out.
piste::LiveOptions live_options(const piste::ReplayConfig& config) {
  piste::LiveOptions options;
  options.conditioning = config.conditioning;
  options.filter = config.filter;
  options.filter.attitude.clear();
  std::erase(options.filter.estimate, piste::Block::kBoresight);
  return options;
}

bool run(const char* file) {
  const piste::ReplayConfig config = piste::read_replay_config(file);
  const piste::Recording logs = piste::read_recording(config);
  const std::vector<piste::GeodeticFix>& fixes = logs.gnss.front().fixes;
  piste::Live live(live_options(config));

  std::size_t next_fix = 0;
  double next_line = logs.imu.time.front();
  bool heading_known = false;
  for (std::size_t row = 0; row < logs.imu.time.size(); ++row) {
    const double now = logs.imu.time[row];
    for (; next_fix < fixes.size() && fixes[next_fix].time + kLatency <= now; ++next_fix) live.add(0, fixes[next_fix]);
    live.add({now, logs.imu.gyro[row], logs.imu.accel[row]});
    if (now < next_line) continue;
    next_line += 1;
    if (const auto state = live.now()) {
      print_state(*state);
      heading_known = state->heading_known;
    }
  }
  std::printf("%zu fixes came too late\n", live.late());
  return heading_known;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: live_logger CONFIG\n");
    return 2;
  }
  try {
    return run(argv[1]) ? 0 : 1;
  } catch (const piste::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
