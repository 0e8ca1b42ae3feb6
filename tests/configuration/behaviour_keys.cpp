// The keys that change how gaps, spikes, rest, the start and distrust are treated.

#include "configuration/behaviour_keys.h"

#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "piste/core/error.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;

BehaviourOptions behaviour_of(const std::string& text) {
  const Config config = Config::parse("first: line\n" + text, "run.yaml");
  config.text("first");
  BehaviourOptions options = read_behaviour(config);
  if (const auto initial = config.find_map("initial")) {
    read_heading_search(*initial, initial->text("heading", "auto") == "auto", options.start);
  }
  config.finish();
  return options;
}

TEST(BehaviourKeys, AreRead) {
  const BehaviourOptions b = behaviour_of(
      "gate: 0.99\n"
      "rest: {detect: false, sigma_velocity: 2 cm/s, sigma_rate: 1 deg/s, correlation_time: 4 s, interval: 1 s,\n"
      "  sway: 0.1 m/s, resolved: 0.2 m/s, sway_distance: 1 m, turn: 8 deg, shortest: 2 s, gyro_quiet: 3 deg/s,\n"
      "  force_quiet: 0.5 m/s^2}\n"
      "initial: {heading: auto, hypotheses: 24, listened: 60 s, look_back: 20 s}\n"
      "trust: {readmit_after: 8, distrust: 20 s}\n"
      "gaps: {longest: 60 s}\n"
      "spikes: {mend: false}\n");
  EXPECT_EQ(b.trust.gate, 0.99);
  EXPECT_FALSE(b.rest.detect);
  EXPECT_DOUBLE_EQ(b.rest.sigma_velocity, 0.02);
  EXPECT_DOUBLE_EQ(b.rest.sigma_rate, kDegree);
  EXPECT_EQ(b.rest.correlation_time, 4);
  EXPECT_EQ(b.rest.interval, 1);
  EXPECT_EQ(b.rest.sway, 0.1);
  EXPECT_EQ(b.rest.resolved, 0.2);
  EXPECT_EQ(b.rest.sway_distance, 1);
  EXPECT_DOUBLE_EQ(b.rest.turn, 8 * kDegree);
  EXPECT_EQ(b.rest.shortest, 2);
  EXPECT_DOUBLE_EQ(b.rest.gyro_quiet, 3 * kDegree);
  EXPECT_EQ(b.rest.force_quiet, 0.5);
  EXPECT_EQ(b.start.hypotheses, 24);
  EXPECT_EQ(b.start.listened, 60);
  EXPECT_EQ(b.start.look_back, 20);
  EXPECT_EQ(b.trust.readmit_after, 8);
  EXPECT_EQ(b.trust.distrust, 20);
  EXPECT_EQ(b.gaps.longest, 60);
  EXPECT_FALSE(b.spikes.mend);
}

TEST(BehaviourKeys, WhatIsNotNamedStaysAsItWas) {
  const BehaviourOptions b = behaviour_of("rest: {turn: 8 deg}\ntrust: {distrust: 20 s}\n"), usual;
  EXPECT_TRUE(b.rest.detect);
  EXPECT_EQ(b.rest.sway, usual.rest.sway);
  EXPECT_EQ(b.trust.readmit_after, usual.trust.readmit_after);
  EXPECT_EQ(b.gaps.longest, usual.gaps.longest);
  EXPECT_TRUE(b.spikes.mend);
}

TEST(BehaviourKeys, OutOfRangeAreRefusedWithTheRange) {
  const std::tuple<std::string, std::string, std::string> cases[] = {
      {"gate: 2", "run.yaml:2: gate", "between 0 and 1"},
      {"rest: {sigma_rate: 0 deg/s}", "run.yaml:2: rest", "above zero"},
      {"rest: {sway: 0 m/s}", "run.yaml:2: sway: must be", "0.001 to 0.5 m/s"},
      {"rest: {sway: 0.6 m/s}", "run.yaml:2: sway: must be", "`0.06 m/s`"},
      {"rest: {resolved: 1 m/s}", "run.yaml:2: resolved: must be", "0.001 to 0.5 m/s"},
      {"rest: {sway_distance: 200 m}", "run.yaml:2: sway_distance: must be", "100 m"},
      {"rest: {turn: 0 deg}", "run.yaml:2: turn: must be", "180 deg"},
      {"rest: {shortest: 0 s}", "run.yaml:2: shortest: must be", "0.5 to 600 s"},
      {"rest: {gyro_quiet: 90 deg/s}", "run.yaml:2: gyro_quiet: must be", "60 deg/s"},
      {"rest: {force_quiet: 0 m/s^2}", "run.yaml:2: force_quiet: must be", "10 m/s^2"},
      {"initial: {hypotheses: 3}", "run.yaml:2: hypotheses: must be", "4 to 72"},
      {"initial: {hypotheses: 73}", "run.yaml:2: hypotheses: must be", "4 to 72"},
      {"initial: {listened: 0 s}", "run.yaml:2: listened: must be", "1 to 600 s"},
      {"initial: {look_back: -1 s}", "run.yaml:2: look_back: must be", "0 to 600 s"},
      {"initial: {heading: from_attitude, hypotheses: 8}", "run.yaml:2: hypotheses: only a heading", "heading: auto"},
      {"trust: {readmit_after: 0}", "run.yaml:2: readmit_after: must be", "1 to 1000"},
      {"trust: {distrust: -1 s}", "run.yaml:2: distrust: must be", "0 to 3600 s"},
      {"trust: {distrust: 40}", "run.yaml:2: distrust: `40` has no unit", "s"},
      {"trust: {patience: 3 s}", "run.yaml:2: unknown key `patience`", "known here are: "},
      {"gaps: {longest: 0 s}", "run.yaml:2: longest: must be", "0.01 to 3600 s"},
      {"spikes: {mend: maybe}", "run.yaml:2: mend: `maybe` is none of", "true, false"},
  };
  for (const auto& [text, problem, remedy] : cases) {
    const std::string message = message_of<ConfigError>([yaml = text] { behaviour_of(yaml + "\n"); });
    EXPECT_TRUE(contains(message, problem)) << text << ": " << message;
    EXPECT_TRUE(contains(message, remedy)) << text << ": " << message;
  }
}

}  // namespace
}  // namespace piste
