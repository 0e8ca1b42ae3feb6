#include "tune/evidence.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace piste::test {
namespace {

// One position a second. Each value is what one stretch of ten seconds takes from the log-likelihood.
Evidence of_stretches(const std::vector<double>& losses) {
  Evidence run;
  run.sources = {"gnss[0].position"};
  for (std::size_t k = 0; k < losses.size(); ++k) {
    for (int i = 0; i < 10; ++i) {
      Innovation v{.residual = Vector3d::Zero(), .sigma = Vector3d::Ones()};
      v.time = 1000 + 10 * static_cast<double>(k) + i;
      v.nis = 2 * losses[k] / 10;
      run.innovations.push_back(v);
    }
  }
  run.likelihood = log_likelihood(run.innovations, run.sources);
  return run;
}

const std::vector<double> kBase(20, 20.0);

TEST(LastingGain, IsWithoutTheTenthThatGainsMost) {
  std::vector<double> granted(20, 18.0);
  EXPECT_NEAR(lasting_gain(of_stretches(granted), of_stretches(kBase)), 18 * 2, 1e-9);
  granted[3] = 1;
  granted[11] = 6;
  EXPECT_NEAR(lasting_gain(of_stretches(granted), of_stretches(kBase)), 18 * 2, 1e-9);
  granted[12] = 25;  // losses count in full
  EXPECT_NEAR(lasting_gain(of_stretches(granted), of_stretches(kBase)), 17 * 2 - 5, 1e-9);
}

TEST(LastingGain, IsNoneOfAnEpisode) {
  std::vector<double> granted = kBase;
  granted[7] = 0;
  EXPECT_NEAR(lasting_gain(of_stretches(granted), of_stretches(kBase)), 0, 1e-9);
}

}  // namespace
}  // namespace piste::test
