// Whose a disagreement is, residual by residual: no filter runs here.

#include "filter/fault_detection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace piste::test {
namespace {

constexpr int kPosition = 0, kVelocity = 1, kAttitude = 2, kRest = 3;  // of one receiver, one reference, and rest
constexpr double kBound = 16.27;                                       // chi-squared, 3 rows, 0.999

std::vector<MeasurementSource> sources(std::size_t receivers, std::size_t references) {
  FilterOptions options;
  options.gnss.resize(receivers);
  options.attitude.resize(references);
  return MeasurementSources(options).all();
}

class Fixes {
 public:
  /// A fix off by `offset` along north, where `sigma` an axis is expected; beyond 1 it is the filter's own.
  FaultDetection::Ruling fix(int source, double time, double offset, double sigma = 1, double claim = 1) {
    Linearization lin;
    lin.observes = source == kPosition ? Block::kPosition : source == kVelocity ? Block::kVelocity : Block::kAttitude;
    Update u;
    u.residual = {offset, 0, 0};
    u.S = sigma * sigma * Matrix3d::Identity();
    u.R = 0.7 * claim * claim * std::min(1.0, sigma * sigma) * Matrix3d::Identity();
    u.nis = offset * offset / (sigma * sigma);
    return trust.rule(source, time, lin, u, kBound, {}, P);
  }
  Outcome outcome(int source, double time, double offset, double sigma = 1) {
    return fix(source, time, offset, sigma).outcome;
  }

  FaultDetection trust{sources(1, 1), {.readmit_after = 5, .distrust = 40}};
  Covariance P = 1e-4 * Covariance::Identity(9, 9);
};

TEST(FaultDetection, TheSourcesOfItsTestsAreThoseOfTheList) {
  const std::vector<MeasurementSource> all = sources(1, 1);
  EXPECT_EQ(all[kPosition].name, "gnss[0].position");
  EXPECT_EQ(all[kVelocity].name, "gnss[0].velocity");
  EXPECT_EQ(all[kAttitude].name, "attitude[0]");
  EXPECT_EQ(all[kRest].name, "rest.velocity");
}

TEST(FaultDetection, WhatLiesWithinTheGateIsUsed) {
  Fixes f;
  const FaultDetection::Ruling first = f.fix(kPosition, 10, 3);
  EXPECT_EQ(first.outcome, Outcome::kUsed);
  EXPECT_TRUE(std::isinf(first.lapse));
  EXPECT_EQ(f.fix(kPosition, 10.1, 0).lapse, 0.5);
  EXPECT_EQ(f.fix(kPosition, 13.1, 0).lapse, 3);
}

// What somebody else has found to be wrong is compared, and never used, however long it lasts.
TEST(FaultDetection, WhatIsExcludedIsNotUsed) {
  Fixes f;
  f.fix(kPosition, 10, 0);
  Linearization lin;
  lin.observes = Block::kPosition;
  lin.excluded = true;
  Update u;
  u.residual.setZero();
  u.S = u.R = Matrix3d::Identity();
  for (int i = 1; i < 100; ++i) {
    u.nis = i % 2 == 0 ? 1 : 100;
    const FaultDetection::Ruling ruling = f.trust.rule(kPosition, 10 + i, lin, u, kBound, {}, f.P);
    EXPECT_EQ(ruling.outcome, i % 2 == 0 ? Outcome::kDisputed : Outcome::kRejected);
    EXPECT_EQ(ruling.lapse, i);
  }
  EXPECT_EQ(f.outcome(kPosition, 110, 0), Outcome::kUsed) << "and it leaves no suspicion";
}

TEST(FaultDetection, AFilterThatWasNeverRightGivesWayAfterFive) {
  for (const int source : {kPosition, kVelocity, kAttitude}) {
    Fixes f;
    for (int i = 0; i < 5; ++i) EXPECT_EQ(f.outcome(source, i, 100), Outcome::kRejected) << i;
    const FaultDetection::Ruling sixth = f.fix(source, 5, 100);
    EXPECT_EQ(sixth.outcome, Outcome::kReadmitted);
    EXPECT_FALSE(sixth.parted);
    EXPECT_EQ(f.outcome(source, 6, 0), Outcome::kUsed);
  }
}

// After fixes that claimed 1 m, as float solutions, those that claim far less disagree with them by what they claimed.
TEST(FaultDetection, BetterFixesAreBelievedWithinWhatTheFormerClaimed) {
  const auto outcome_of = [](double claim, double offset) {
    Fixes f;
    for (int i = 0; i < 50; ++i) EXPECT_EQ(f.outcome(kPosition, 0.3 * i, 0), Outcome::kUsed);
    FaultDetection::Ruling last;
    for (int i = 0; i < 6; ++i) last = f.fix(kPosition, 15 + 0.3 * i, offset, 0.2, claim);
    return last.outcome;
  };
  EXPECT_EQ(outcome_of(0.1, 2.5), Outcome::kReadmitted) << "within three of their sigmas";
  EXPECT_EQ(outcome_of(0.1, 9), Outcome::kRejected) << "a jump that they do not explain";
  EXPECT_EQ(outcome_of(3, 2.5), Outcome::kRejected) << "a fix that claims no more than they did";
}

TEST(FaultDetection, HowLongNobodyIsBelievedIsAnOption) {
  Fixes f;
  f.trust = FaultDetection(sources(1, 1), {.readmit_after = 2});
  for (int i = 0; i < 2; ++i) EXPECT_EQ(f.outcome(kAttitude, i, 100), Outcome::kRejected) << i;
  EXPECT_EQ(f.outcome(kAttitude, 2, 100), Outcome::kReadmitted);
  f.trust = FaultDetection(sources(1, 1), {.distrust = 10});
  f.fix(kPosition, 0, 0);
  for (int t = 1; t <= 10; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50), Outcome::kRejected) << t;
  EXPECT_EQ(f.outcome(kPosition, 11, 50), Outcome::kReadmitted);
  f.trust = FaultDetection(sources(1, 1), {.slight = 100});
  f.fix(kPosition, 0, 0);
  for (int t = 1; t <= 3; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50), Outcome::kRejected) << t;
  EXPECT_EQ(f.outcome(kPosition, 4, 50), Outcome::kReadmitted) << "50 m are slight where a slight jump is 100 m";
}

TEST(FaultDetection, ALeapIsTheReceiversUntilItComesBack) {
  Fixes f;
  f.fix(kPosition, 0, 0);
  for (int t = 1; t <= 20; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50 + 0.1 * t), Outcome::kRejected) << t;
  EXPECT_EQ(f.outcome(kPosition, 21, 1), Outcome::kUsed);
  EXPECT_EQ(f.outcome(kPosition, 22, 0), Outcome::kUsed);
}

TEST(FaultDetection, ALeapIsBelievedInTheEnd) {
  Fixes f;
  f.fix(kPosition, 0, 0);
  for (int t = 1; t <= 40; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50), Outcome::kRejected) << t;
  const FaultDetection::Ruling last = f.fix(kPosition, 41, 50);
  EXPECT_EQ(last.outcome, Outcome::kReadmitted);
  EXPECT_TRUE(last.parted);
  EXPECT_EQ(last.lapse, 41);
}

TEST(FaultDetection, AGateThatWidensDoesNotMakeALieTrue) {
  Fixes f;
  f.fix(kPosition, 0, 0);
  EXPECT_EQ(f.outcome(kPosition, 1, 50), Outcome::kRejected);
  for (int t = 2; t <= 9; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50), Outcome::kRejected) << t;
  for (int t = 10; t <= 30; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50, 20), Outcome::kDisputed) << t;
  EXPECT_EQ(f.outcome(kPosition, 31, 0, 20), Outcome::kUsed);
}

TEST(FaultDetection, CentimetresAreNotCoastedFor) {
  Fixes f;
  f.fix(kPosition, 0, 0, 0.02);
  for (const double t : {0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0}) {
    EXPECT_EQ(f.outcome(kPosition, t, 0.4, 0.02), Outcome::kRejected) << t;
  }
  EXPECT_EQ(f.outcome(kPosition, 3.2, 0.4, 0.02), Outcome::kReadmitted);
}

TEST(FaultDetection, ASmallLeapThatGrowsIsNoLongerSlight) {
  Fixes f;
  f.fix(kPosition, 0, 0, 0.02);
  EXPECT_EQ(f.outcome(kPosition, 0.2, 0.9, 0.02), Outcome::kRejected);
  for (int t = 1; t <= 40; ++t) EXPECT_EQ(f.outcome(kPosition, t, 1 + t, 0.02), Outcome::kRejected) << t;
}

TEST(FaultDetection, WhatGrowsSlowlyIsTheFilters) {
  Fixes f;
  f.fix(kVelocity, 0, 0);
  // 0.9 m/s in a second: a filter may miss 1 m/s² unawares.
  for (int t = 1; t <= 5; ++t) EXPECT_EQ(f.outcome(kVelocity, t, 0.9, 0.2), Outcome::kRejected) << t;
  EXPECT_EQ(f.outcome(kVelocity, 6, 0.9, 0.2), Outcome::kReadmitted);
}

TEST(FaultDetection, APositionAloneIsTheReceivers) {
  Fixes with_velocities, without;
  with_velocities.fix(kPosition, 0, 0, 0.1);
  without.fix(kPosition, 0, 0, 0.1);
  with_velocities.fix(kVelocity, 0, 0, 0.1);
  for (int t = 1; t <= 6; ++t) {  // 0.45 m grew in a second: a filter may be wrong by as much
    const double offset = t < 3 ? 0.45 : 1.5;
    with_velocities.fix(kVelocity, t - 0.5, 0, 0.1);
    EXPECT_EQ(with_velocities.outcome(kPosition, t, offset, 0.1), Outcome::kRejected) << t;
    EXPECT_EQ(without.outcome(kPosition, t, offset, 0.1), t < 6 ? Outcome::kRejected : Outcome::kReadmitted) << t;
  }
}

TEST(FaultDetection, AVelocityThatJumpsTakesItsPositionAlong) {
  Fixes f;
  f.fix(kVelocity, 0, 0, 0.1);
  f.fix(kPosition, 1.5, 0);
  EXPECT_EQ(f.outcome(kVelocity, 1.9, 20, 0.1), Outcome::kRejected);
  for (int i = 1; i <= 10; ++i) EXPECT_EQ(f.outcome(kPosition, 1.5 + i, 4.1 * i), Outcome::kRejected) << i;
}

TEST(FaultDetection, AVelocityThatTheFilterMissedClearsItsPosition) {
  Fixes f;
  f.fix(kVelocity, 0, 0, 0.2);
  f.fix(kPosition, 0, 0, 0.1);
  EXPECT_EQ(f.outcome(kVelocity, 1, 0.9, 0.2), Outcome::kRejected);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(f.outcome(kPosition, 1 + 0.1 * i, 0.45, 0.1), Outcome::kRejected) << i;
  EXPECT_EQ(f.outcome(kPosition, 1.5, 0.45, 0.1), Outcome::kReadmitted);
}

TEST(FaultDetection, ALieThatFadesIsNotForgotten) {
  Fixes f;
  f.fix(kPosition, 0, 0);
  for (int t = 1; t <= 19; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50 - 2.5 * (t - 1)), Outcome::kRejected) << t;
  for (int t = 20; t <= 30; ++t) EXPECT_EQ(f.outcome(kPosition, t, 0), Outcome::kDisputed) << t;
}

TEST(FaultDetection, AFilterUnderSuspicionAccusesNobody) {
  Fixes f;
  f.fix(kPosition, 0, 0);
  f.trust.suspect_filter(0);
  for (int t = 1; t <= 5; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50), Outcome::kRejected) << t;
  EXPECT_EQ(f.outcome(kPosition, 6, 50), Outcome::kReadmitted);
  // And a readmission puts it under suspicion anew.
  EXPECT_EQ(f.outcome(kPosition, 11, 0), Outcome::kUsed);
  for (int t = 12; t <= 16; ++t) EXPECT_EQ(f.outcome(kPosition, t, -50), Outcome::kRejected) << t;
  EXPECT_EQ(f.outcome(kPosition, 17, -50), Outcome::kReadmitted);
}

// Of two IMUs one has a new offset: the filter follows their mean, and the receiver is right.
TEST(FaultDetection, ImusThatPartedAccuseNoReceiver) {
  for (const bool parted : {false, true}) {
    FilterOptions options;
    options.gnss.resize(1);
    options.imus.resize(2);
    Fixes f;
    f.trust = FaultDetection(MeasurementSources(options).all(), {.readmit_after = 5, .distrust = 40});
    const int parity = MeasurementSources(options).first<ImuParity>(0) + 1;
    f.fix(kPosition, 0, 0);
    for (int i = 1; i <= 2; ++i) {
      Linearization lin;
      lin.observes = parity_block(Block::kAccelDrift, 0);
      Update u;
      u.residual = {parted ? 10. : 0., 0, 0};
      u.nis = u.residual.squaredNorm();
      f.trust.rule(parity, 0.1 * i, lin, u, kBound, {}, f.P);
    }
    for (int t = 1; t <= 5; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50), Outcome::kRejected) << t;
    EXPECT_EQ(f.outcome(kPosition, 6, 50), parted ? Outcome::kReadmitted : Outcome::kRejected);
  }
}

TEST(FaultDetection, AfterAnOutageOfTheLiarTheFilterMayBeWrong) {
  Fixes f;
  f.fix(kPosition, 0, 0);
  EXPECT_EQ(f.outcome(kPosition, 1, 50), Outcome::kRejected);
  for (int t = 11; t <= 14; ++t) EXPECT_EQ(f.outcome(kPosition, t, 50), Outcome::kRejected) << t;
  EXPECT_EQ(f.outcome(kPosition, 15, 50), Outcome::kReadmitted);
}

TEST(FaultDetection, RestNeverForcesItself) {
  Fixes f;
  f.fix(kRest, 0, 0);
  for (int t = 1; t <= 100; ++t) EXPECT_EQ(f.outcome(kRest, t, 5), Outcome::kRejected) << t;
}

TEST(FaultDetection, AFixRepeatsInEveryDigit) {
  FaultDetection trust(sources(2, 0), {});
  GnssFix fix{
      .time = 1, .position = {1, 2, 3}, .sigma_position = {1, 1, 1}, .velocity = FixVelocity{{4, 5, 6}, {1, 1, 1}}};
  EXPECT_FALSE(trust.repeats<GnssReceivers>(0, fix));
  fix.time = 2;
  EXPECT_FALSE(trust.repeats<GnssReceivers>(2, fix));  // another receiver
  EXPECT_TRUE(trust.repeats<GnssReceivers>(0, fix));
  fix.velocity->value.x() += 1e-12;
  EXPECT_FALSE(trust.repeats<GnssReceivers>(0, fix));
  fix.velocity.reset();
  EXPECT_FALSE(trust.repeats<GnssReceivers>(0, fix));
  EXPECT_TRUE(trust.repeats<GnssReceivers>(0, fix));
  fix.position.z() += 1e-12;
  EXPECT_FALSE(trust.repeats<GnssReceivers>(0, fix));
}

// What a vehicle presumes is let go once it is seen not to hold, until it has held for a while, and never forced.
TEST(FaultDetection, AChannelWithAHoldIsLetGo) {
  FilterOptions options;
  options.vehicle.emplace();
  const MeasurementSources all(options);
  const int source = all.first<VehicleConstraint>(0);
  Fixes fixes;
  fixes.trust = FaultDetection(all.all(), {.readmit_after = 5, .distrust = 40});
  EXPECT_EQ(fixes.outcome(source, 0, 0.5), Outcome::kUsed);
  for (int k = 1; k < 20; ++k) EXPECT_EQ(fixes.outcome(source, k, 9), Outcome::kRejected) << k;
  EXPECT_EQ(fixes.outcome(source, 20, 0.5), Outcome::kDisputed);
  EXPECT_EQ(fixes.outcome(source, 19 + VehicleConstraint::kLetGo, 0.5), Outcome::kUsed);
}

}  // namespace
}  // namespace piste::test
