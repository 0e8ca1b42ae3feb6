// A sensor that piste does not know: the distance to a beacon. Its model is one function, which says what the sensor
// should have measured and how that depends on the state. With it the program does three things, in this order:
//
//   1. it holds the Jacobian against differences, so that no sign is wrong;
//   2. it asks whether the measurements fit what the filter believes: their normalised innovations should be 1;
//   3. it corrects the filter's position by them, and compares the sigmas.
//
// The ranges are simulated from the smoothed trajectory. To have the filter itself use such a sensor in every run, add
// the model to the library: docs/house.md says how.
//
//   own_sensor ../../config/ski_run.yaml

#include <piste/piste.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <random>

namespace {

using piste::Block;
using piste::Estimate;
using piste::Vector3d;

constexpr double kSigma = 0.005;  // m, of a range

struct Range {
  double time = 0, value = 0;
};

// The model: residual = measured − predicted, its variance, and the derivative of the prediction by the error of the
// position, in w. The lever arm of the sensor is left out: it sits in the IMU.
piste::Linearization linearize(double measured, const Vector3d& beacon, const Estimate& x) {
  const Vector3d way = x.p_wb - beacon;
  piste::Linearization lin;
  lin.rows = 1;
  lin.observes = Block::kPosition;
  lin.residual.x() = measured - way.norm();
  lin.covariance(0, 0) = kSigma * kSigma;
  piste::Matrix3d jacobian = piste::Matrix3d::Zero();
  jacobian.row(0) = way.normalized().transpose();
  lin.add(Block::kPosition, jacobian);
  return lin;
}

// The largest difference between the Jacobian and what happens to the residual when the estimate is off by a little.
double jacobian_error(const Vector3d& beacon, const Estimate& x) {
  constexpr double kStep = 1e-3;
  double worst = 0;
  for (int axis = 0; axis < 3; ++axis) {
    piste::FullError error = piste::FullError::Zero();
    error[piste::full_offset(Block::kPosition) + axis] = kStep;
    const double plus = linearize(0, beacon, piste::boxplus(x, error)).residual.x();
    const double minus = linearize(0, beacon, piste::boxplus(x, -error)).residual.x();
    const double stated = linearize(0, beacon, x).term(0).jacobian(0, axis);
    worst = std::max(worst, std::abs(stated + (plus - minus) / (2 * kStep)));  // the residual falls as it predicts more
  }
  return worst;
}

// Ranges to the beacon, ten a second, as the smoothed trajectory would give them.
std::vector<Range> simulate(const piste::Solution& truth, const Vector3d& beacon) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, kSigma);
  std::vector<Range> ranges;
  for (std::size_t row = 0; row < truth.size(); row += 10) {
    ranges.push_back({truth.time(row), (truth.estimate(row).p_wb - beacon).norm() + noise(random)});
  }
  return ranges;
}

// Feeds the filter sample by sample, and calls `each` after every epoch. A program in real time does the same.
template <class Each>
void filter_run(const piste::Replay& run, Each&& each) {
  const std::vector<piste::GnssFix>& fixes = run.log.gnss.front();
  piste::Filter filter(run.options, run.log.world, run.found.start);
  std::size_t next = 0;
  for (const piste::ImuSample& sample : run.log.imu) {
    if (sample.time <= run.found.start.time) continue;
    for (; next < fixes.size() && fixes[next].time <= sample.time + filter.look_ahead(); ++next) {
      if (fixes[next].time >= run.found.start.time) filter.add(0, fixes[next]);
    }
    if (filter.add(sample)) each(filter);
  }
}

bool check(const char* file) {
  const piste::ReplayConfig config = piste::read_replay_config(file);
  const piste::Replay run = piste::replay(config);
  const Vector3d beacon(40, -30, -5);  // north, east, down of the run's origin
  const std::vector<Range> ranges = simulate(run.solution(), beacon);

  double worst_jacobian = 0, nis = 0, before = 0, after = 0;
  std::size_t used = 0, next = 0;
  filter_run(run, [&](const piste::Filter& filter) {
    while (next < ranges.size() && ranges[next].time < filter.time() - 1e-6) ++next;
    if (next == ranges.size() || ranges[next].time > filter.time() + 1e-6) return;
    const Estimate& x = filter.estimate();
    worst_jacobian = std::max(worst_jacobian, jacobian_error(beacon, x));
    const piste::Linearization lin = linearize(ranges[next].value, beacon, x);
    const piste::Update update = piste::innovate(filter.covariance(), filter.layout(), lin);
    piste::Covariance corrected = filter.covariance();
    piste::update(corrected, update);
    const Vector3d along = (x.p_wb - beacon).normalized();
    before += std::sqrt(along.dot(filter.covariance().topLeftCorner<3, 3>() * along));
    after += std::sqrt(along.dot(corrected.topLeftCorner<3, 3>() * along));
    nis += update.nis;
    ++used;
  });
  if (used == 0) return false;
  const auto count = static_cast<double>(used);
  std::printf("%zu ranges; the Jacobian is right within %.1e; mean normalised innovation squared %.2f\n", used,
              worst_jacobian, nis / count);
  std::printf("sigma of the position towards the beacon: %.4f m before, %.4f m after\n", before / count, after / count);
  return worst_jacobian < 1e-6 && nis / count < 2 && after < before;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: own_sensor CONFIG\n");
    return 2;
  }
  try {
    return check(argv[1]) ? 0 : 1;
  } catch (const piste::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
