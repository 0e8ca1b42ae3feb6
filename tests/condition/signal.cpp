// The low-pass against scipy, against tones and against its own equations; and the page that tells of it.

#include "piste/condition/signal.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <tuple>

#include "io/csv.h"
#include "piste/sim/random.h"
#include "plot/svg.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

constexpr double kInf = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<Vector3d> causal(const LowPass& low_pass, std::span<const Vector3d> signal) {
  CausalLowPass filter(low_pass);
  std::vector<Vector3d> out;
  for (const Vector3d& sample : signal) out.push_back(filter.add(sample));
  return out;
}

std::vector<Vector3d> white_noise(std::size_t count) {
  RandomStream random(4, "low pass");
  std::vector<Vector3d> out(count);
  for (Vector3d& sample : out) sample = random.normal3();
  return out;
}

// Largest difference of any component.
double difference(std::span<const Vector3d> a, std::span<const Vector3d> b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    const double d = (a[k] - b[k]).cwiseAbs().maxCoeff();
    if (!(d <= largest)) largest = d;  // keeps a NaN
  }
  return largest;
}

struct OracleCase {
  int order = 0;
  double cutoff = 0, rate = 0, extension = 0;
  std::vector<double> input, causal, zero_phase;
};

std::vector<OracleCase> read_oracle() {
  CsvReader csv(test::source_folder() + "/tests/condition/signal_oracle.csv");
  const auto number = csv.column("case"), order = csv.column("order"), cutoff = csv.column("cutoff_hz"),
             rate = csv.column("rate_hz"), extension = csv.column("extension"), input = csv.column("input"),
             once = csv.column("causal"), both = csv.column("zero_phase");
  csv.finish_header();
  std::vector<OracleCase> cases;
  while (csv.next()) {
    if (static_cast<std::size_t>(csv[number]) == cases.size()) {
      cases.push_back({static_cast<int>(csv[order]), csv[cutoff], csv[rate], csv[extension], {}, {}, {}});
    }
    cases.back().input.push_back(csv[input]);
    cases.back().causal.push_back(csv[once]);
    cases.back().zero_phase.push_back(csv[both]);
  }
  return cases;
}

TEST(LowPass, EqualsScipy) {
  const std::vector<OracleCase> cases = read_oracle();
  ASSERT_EQ(cases.size(), 24U);
  for (const OracleCase& c : cases) {
    SCOPED_TRACE(fmt::format("order {}, {} Hz at {} Hz, {} samples", c.order, c.cutoff, c.rate, c.input.size()));
    const LowPass low_pass(c.cutoff, c.rate, c.order);
    EXPECT_EQ(std::min(std::ceil(low_pass.settling()), static_cast<double>(c.input.size() - 1)), c.extension);
    const Vector3d axes(1, -2, 0.5);
    const auto signal = [&](const std::vector<double>& values) {
      std::vector<Vector3d> out;
      for (const double value : values) out.emplace_back(value * axes);
      return out;
    };
    double largest = 0;
    for (const double value : c.input) largest = std::max(largest, 2 * std::abs(value));
    const auto input = signal(c.input);
    EXPECT_LT(difference(causal(low_pass, input), signal(c.causal)), 1e-9 * largest);
    EXPECT_LT(difference(zero_phase(low_pass, input), signal(c.zero_phase)), 1e-9 * largest);
  }
}

TEST(LowPass, IsAtMinus3DecibelsAtTheCutOffAndFallsEvermore) {
  for (int order = 1; order <= LowPass::kMaxOrder; ++order) {
    for (const double cutoff : {1e-6, 0.1, 12.0, 49.9}) {
      const LowPass low_pass(cutoff, 100, order);
      EXPECT_NEAR(std::norm(low_pass.response(cutoff)), 0.5, 1e-13) << order << " " << cutoff;
      EXPECT_EQ(low_pass.response(0), 1.0);
      EXPECT_LT(std::abs(low_pass.response(50)), 1e-12);
      double last = 1;
      for (int k = 1; k <= 100; ++k) {
        const double gain = std::abs(low_pass.response(0.5 * k));
        EXPECT_LE(gain, last * (1 + 1e-12));
        last = gain;
      }
    }
  }
}

// Order, cut-off and rate [Hz].
class LowPassOf : public testing::TestWithParam<std::tuple<int, double, double>> {
 protected:
  LowPass low_pass_{std::get<1>(GetParam()), std::get<2>(GetParam()), std::get<0>(GetParam())};
  double cutoff_ = std::get<1>(GetParam()), rate_ = std::get<2>(GetParam());
  std::size_t settled_ = static_cast<std::size_t>(1.5 * low_pass_.settling());

  Complex tone(double frequency, std::size_t k) const {
    return std::polar(1.0, 2 * pi * std::fmod(frequency / rate_ * static_cast<double>(k), 1.0));
  }
  // A tone e^(iωk) as two axes, real and imaginary; `ramp` makes its amplitude rise from 0 to 1.
  std::vector<Vector3d> tones(double frequency, std::size_t count, bool ramp) const {
    std::vector<Vector3d> out;
    for (std::size_t k = 0; k < count; ++k) {
      const Complex z = (ramp ? static_cast<double>(k) / static_cast<double>(count) : 1.0) * tone(frequency, k);
      out.emplace_back(z.real(), z.imag(), 0);
    }
    return out;
  }
  static Complex complex(const Vector3d& sample) { return {sample.x(), sample.y()}; }
};
INSTANTIATE_TEST_SUITE_P(Designs, LowPassOf,
                         testing::Values(std::tuple(1, 12.0, 100.0), std::tuple(2, 40.0, 100.0),
                                         std::tuple(3, 12.0, 100.0), std::tuple(4, 12.0, 100.0),
                                         std::tuple(4, 5.0, 512.0), std::tuple(8, 12.0, 100.0),
                                         std::tuple(8, 1.0, 1000.0), std::tuple(12, 20.0, 200.0)));

TEST_P(LowPassOf, TonesComeOutAsTheResponseSays) {
  for (const double ratio : {0.0, 0.1, 0.5, 0.9, 1.0, 1.1, 2.0}) {
    const double frequency = ratio * cutoff_;
    if (frequency >= rate_ / 2) continue;
    const auto out = causal(low_pass_, tones(frequency, settled_ + 50, false));
    for (std::size_t k = settled_; k < out.size(); ++k) {
      const Complex measured = complex(out[k]) / tone(frequency, k);
      EXPECT_LT(std::abs(measured - low_pass_.response(frequency)), 1e-8) << ratio;
    }
  }
}

TEST_P(LowPassOf, ForwardAndBackwardKeepsThePhaseOfTones) {
  for (const double ratio : {0.0, 0.1, 0.5, 1.0, 1.1}) {
    const double frequency = ratio * cutoff_;
    const auto out = zero_phase(low_pass_, tones(frequency, 4 * settled_, false));
    for (std::size_t k = 2 * settled_; k < 2 * settled_ + 50; ++k) {
      const Complex measured = complex(out[k]) / tone(frequency, k);
      EXPECT_NEAR(measured.real(), std::norm(low_pass_.response(frequency)), 1e-8) << ratio;
      EXPECT_NEAR(measured.imag(), 0, 1e-8) << ratio;
    }
  }
}

TEST_P(LowPassOf, RisingTonesComeLateByTheDelay) {
  // k e^(iωk) becomes e^(iωk) (k H − Σ m h_m e^(−iωm)), whose second term over H has the group delay as real part.
  const CausalLowPass filter(low_pass_);
  for (const double ratio : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    const double frequency = ratio * cutoff_;
    const std::size_t count = settled_ + 50, k = count - 1;
    const auto out = causal(low_pass_, tones(frequency, count, true));
    const Complex level =
        complex(out[k]) * static_cast<double>(count) / (tone(frequency, k) * low_pass_.response(frequency));
    const double delay = static_cast<double>(k) - level.real();
    EXPECT_NEAR(delay / rate_, filter.delay(frequency), 1e-6 * filter.delay(frequency)) << ratio;
  }
}

TEST_P(LowPassOf, DelayIsTheSlopeOfThePhase) {
  for (const double ratio : {0.0, 0.3, 0.8, 1.0, 1.2}) {
    const double frequency = ratio * cutoff_, step = 1e-4 * cutoff_;
    if (frequency >= rate_ / 2) continue;
    const double turn = std::arg(low_pass_.response(frequency + step) / low_pass_.response(frequency - step));
    EXPECT_NEAR(low_pass_.delay(frequency), -turn / (4 * pi * step), 1e-6 * low_pass_.delay(frequency)) << ratio;
  }
}

TEST_P(LowPassOf, ConstantPassesToTheBitAndALineToOneInABillion) {
  const Vector3d level(1.0 / 3, -9.81, 1e-7), slope(0.01, -2, 1e3);
  const std::vector<Vector3d> constant(200, level);
  EXPECT_EQ(causal(low_pass_, constant), constant);
  EXPECT_EQ(zero_phase(low_pass_, constant), constant);
  std::vector<Vector3d> line;
  for (std::size_t k = 0; k < settled_; ++k) {
    line.emplace_back(level + static_cast<double>(k) / static_cast<double>(settled_) * slope);
  }
  EXPECT_LT(difference(zero_phase(low_pass_, line), line), 1e-9 * slope.norm());
}

TEST_P(LowPassOf, CommutesWithRotation) {
  const auto noise = white_noise(300);
  const Quaterniond q = so3_exp({0.3, -2, 1});
  const auto rotated = [&](std::vector<Vector3d> signal) {
    for (Vector3d& sample : signal) sample = q * sample;
    return signal;
  };
  EXPECT_LT(difference(zero_phase(low_pass_, rotated(noise)), rotated(zero_phase(low_pass_, noise))), 1e-13);
  EXPECT_LT(difference(causal(low_pass_, rotated(noise)), rotated(causal(low_pass_, noise))), 1e-13);
}

TEST(LowPass, KeepsItsDigitsFarBelowTheRate) {
  const LowPass low_pass(0.05, 1000, 8);
  const auto settled = static_cast<int>(1.2 * low_pass.settling());
  CausalLowPass filter(low_pass);
  Vector3d out = Vector3d::Zero();
  Complex tone;
  for (int k = 0; k < settled; ++k) {
    tone = std::polar(1.0, 2 * pi * (k % 20000) / 20000);
    out = filter.add({tone.real(), tone.imag(), 1.0 / 3});
  }
  EXPECT_LT(std::abs(Complex(out.x(), out.y()) / tone - low_pass.response(0.05)), 1e-9);
  EXPECT_EQ(out.z(), 1.0 / 3);
}

TEST(ZeroPhase, CorrelatesBestAtLagZero) {
  const LowPass low_pass(12, 100);
  const auto noise = white_noise(20000);
  const auto best = [&](const std::vector<Vector3d>& out) {
    int lag = 0;
    double peak = 0;
    for (int candidate = -50; candidate <= 50; ++candidate) {
      double sum = 0;
      for (std::size_t k = 50; k + 50 < noise.size(); ++k) sum += out[k + candidate].dot(noise[k]);
      if (sum > peak) peak = sum, lag = candidate;
    }
    return lag;
  };
  EXPECT_EQ(best(zero_phase(low_pass, noise)), 0);
  EXPECT_GT(best(causal(low_pass, noise)), 2) << "a delay would be seen";
}

TEST(ZeroPhase, EndsPassAsTheyAre) {
  // The point reflection makes the ends fixed points; whoever weighs samples leaves them out.
  const LowPass low_pass(12, 100);
  const auto noise = white_noise(500), out = zero_phase(low_pass, noise);
  EXPECT_LT((out.front() - noise.front()).norm(), 1e-8);
  EXPECT_LT((out.back() - noise.back()).norm(), 1e-8);
  // From the third sample on, white noise comes out as it does in the middle, within a tenth.
  const std::size_t count = 300;
  std::vector<double> variance(count, 0);
  for (std::size_t k = 0; k < count; ++k) {
    std::vector<Vector3d> pulse(count, Vector3d::Zero());
    pulse[k].x() = 1;
    const auto through = zero_phase(low_pass, pulse);
    for (std::size_t i = 0; i < count; ++i) variance[i] += through[i].squaredNorm();
  }
  const double middle = std::sqrt(variance[count / 2]);
  for (std::size_t i = 2; i + 2 < count; ++i) EXPECT_NEAR(std::sqrt(variance[i]), middle, 0.1 * middle) << i;
  EXPECT_NEAR(std::sqrt(variance[0]), 1, 1e-8);
}

TEST(ZeroPhase, TakesAnyLength) {
  const LowPass low_pass(12, 100);
  EXPECT_TRUE(zero_phase(low_pass, {}).empty());
  const auto noise = white_noise(200);
  for (std::size_t n = 1; n < noise.size(); ++n) {
    const auto out = zero_phase(low_pass, std::span(noise).first(n));
    ASSERT_EQ(out.size(), n);
    for (const Vector3d& sample : out) EXPECT_LT(sample.norm(), 10);
  }
  // So far below the rate that nothing settles: what is left is the steady state of the extension's first sample.
  const Vector3d first = 2 * noise.front() - noise.back();
  EXPECT_LT(difference(zero_phase(LowPass(1e-300, 100, 5), noise), std::vector(noise.size(), first)), 1e-12);
}

TEST(LowPass, RefusesWhatItCannotBe) {
  struct Refused {
    double cutoff, rate;
    int order;
    const char* part;
  };
  for (const Refused& r : {Refused{0, 100, 4, "0 Hz at a rate of 100 Hz"}, Refused{-12, 100, 4, "below half"},
                           Refused{50, 100, 4, "50 Hz at"}, Refused{60, 100, 4, "60 Hz at"},
                           Refused{kNan, 100, 4, "nan"}, Refused{12, kNan, 4, "nan"}, Refused{12, kInf, 4, "inf"},
                           Refused{12, 0, 4, "0 Hz"}, Refused{12, -100, 4, "-100"}, Refused{12, 100, 0, "order 0"},
                           Refused{12, 100, -1, "order -1"}, Refused{12, 100, 13, "1 to 12"}}) {
    EXPECT_TRUE(test::contains(test::message_of<ConfigError>([&] { LowPass(r.cutoff, r.rate, r.order); }), r.part));
  }
}

// docs/low_pass.md and its picture are what the code says. What they should be is left in the build tree.
class LowPassPage : public testing::Test {
 protected:
  static double decibels(double gain) { return 20 * std::log10(gain); }

  static void expect_holds(const std::string& page, const std::string& name, const std::string& wanted) {
    std::filesystem::create_directories(test::rendered_folder());
    const std::string file = test::rendered_folder() + "/" + name;
    std::ofstream(file, std::ios::binary) << wanted;
    EXPECT_TRUE(test::read_text(test::source_folder() + "/docs/" + page).find(wanted) != std::string::npos)
        << "docs/" << page << " is not up to date; " << file << " is what it should hold";
  }

  const LowPass low_pass_{12, 100, 4};
};

TEST_F(LowPassPage, TableIsTheResponse) {
  std::string table =
      "| frequency / cut-off | frequency | causal | | delay | forward and backward | |\n"
      "|---|---|---|---|---|---|---|\n";
  const auto hundredths = [](double value) { return std::round(100 * value) / 100 + 0.0; };  // no −0.00
  for (const double ratio : {0.25, 0.5, 0.75, 1.0, 1.5, 2.0}) {
    const double gain = std::abs(low_pass_.response(12 * ratio)), both = gain * gain;
    table += fmt::format("| {:g} | {:g} Hz | {:.6f} | {:.2f} dB | {:.1f} ms | {:.6f} | {:.2f} dB |\n", ratio,
                         12 * ratio, gain, hundredths(decibels(gain)), 1e3 * low_pass_.delay(12 * ratio), both,
                         hundredths(decibels(both)));
  }
  expect_holds("low_pass.md", "table.md", table);
}

TEST_F(LowPassPage, NoiseBandwidthsAreThoseOfThePulseResponses) {
  // ∫ |H|² df over the band; the sum over one period of a smooth function is exact.
  double once = 0, both = 0;
  for (int k = 0; k < 1000; ++k) {
    const double power = std::norm(low_pass_.response(0.1 * k));
    once += 0.05 * power, both += 0.05 * power * power;
  }
  // And by Parseval: rate / 2 times the sum of squares.
  std::vector<Vector3d> pulse(801, Vector3d::Zero());
  pulse[400] = Vector3d::UnitX();
  const auto energy = [](const std::vector<Vector3d>& signal) {
    double sum = 0;
    for (const Vector3d& sample : signal) sum += sample.squaredNorm();
    return sum;
  };
  EXPECT_NEAR(50 * energy(causal(low_pass_, pulse)), once, 1e-9);
  EXPECT_NEAR(50 * energy(zero_phase(low_pass_, pulse)), both, 1e-9);
  expect_holds(
      "low_pass.md", "noise.md",
      fmt::format("White noise passes as through an ideal low-pass of {:.2f} Hz (causal) and {:.2f} Hz (forward and\n"
                  "backward): of its standard deviation at 100 Hz, {:.0f} % and {:.0f} % are left. After {:.2f} s "
                  "the filter has settled:\n1e-9 of a disturbance is left.\n",
                  once, both, 100 * std::sqrt(once / 50), 100 * std::sqrt(both / 50), low_pass_.settling() / 100));
}

TEST_F(LowPassPage, PictureIsTheResponseAndTonesAreOnIt) {
  Plot plot("Low-pass of 12 Hz at 100 Hz, order 4", {"frequency [Hz]"}, {"gain [dB]"},
            "Gain over frequency of the causal and of the forward and backward low-pass, with measured tones on both");
  std::vector<double> frequency, once, both;
  for (double f = 0; f <= 49.5; f += 0.25) {
    frequency.push_back(f);
    once.push_back(decibels(std::abs(low_pass_.response(f))));
    both.push_back(2 * once.back());
  }
  plot.line(frequency, both, 0, "forward and backward");
  plot.line(frequency, once, 1, "causal");
  std::vector<double> tone, tone_once, tone_both;
  for (double f = 2; f <= 28; f += 2) {
    std::vector<Vector3d> signal;
    for (int k = 0; k < 601; ++k) {
      signal.emplace_back(std::cos(2 * pi * f * (k - 300) / 100), std::sin(2 * pi * f * (k - 300) / 100), 0);
    }
    tone.push_back(f);
    tone_once.push_back(decibels(causal(low_pass_, signal)[300].norm()));
    tone_both.push_back(decibels(zero_phase(low_pass_, signal)[300].norm()));
  }
  plot.points(tone, tone_both, 3, "tones, measured");
  plot.points(tone, tone_once, 3, "");
  plot.mark(12, decibels(std::abs(low_pass_.response(12))), 1, "−3 dB");
  plot.mark(12, 2 * decibels(std::abs(low_pass_.response(12))), 0, "−6 dB");
  plot.limit_y(-80, 5);
  const std::string picture = plot.render();
  expect_holds("low_pass.svg", "low_pass.svg", picture);
  EXPECT_EQ(std::filesystem::file_size(test::source_folder() + "/docs/low_pass.svg"), picture.size());
}

}  // namespace
}  // namespace piste
