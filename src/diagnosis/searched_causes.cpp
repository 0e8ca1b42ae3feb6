// Causes whose value is searched for: noise of the IMU, sigmas of the fixes, coloured errors.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "diagnosis/cause_support.h"
#include "diagnosis/most_likely_factor.h"
#include "math/words.h"
#include "piste/consistency/verdict.h"
#include "piste/math/statistics.h"
#include "tune/white_noise_range.h"

namespace piste {
namespace {

std::string direction(double factor) {
  return factor > 1 ? "too small by " + plain(factor, 2) : "too large by " + plain(1 / factor, 2);
}

// ---- Noise of the IMU ----

struct Noise {
  std::string_view name, unit;
  double factor;  // from SI to that unit
  TriadErrors ImuSensor::*triad;
  double WhiteNoise::*white;
};
constexpr std::array kNoises{
    Noise{"gyroscope", "deg/s", kDegreesPerRadian, &ImuSensor::gyro, &WhiteNoise::gyro},
    Noise{"accelerometer", "ug", 1e6 / kStandardGravity, &ImuSensor::accel, &WhiteNoise::accel},
};

Cause white_noise(const Noise& noise) {
  return [noise](const FilterInput& input, const Evidence& base, double end) {
    // The samples themselves would be as noisy.
    const double most = white_noise_range(input.log).most.*noise.white / (input.options.sensor.*noise.triad).noise;
    const Factor f = most_likely_factor([&](double factor) {
      if (factor > std::max(1.0, most)) return -std::numeric_limits<double>::infinity();
      FilterOptions options = input.options;
      (options.sensor.*noise.triad).noise *= factor;
      return lasting_gain(filter_again(input.log, options, input.start, end), base);
    });
    const double file = (input.options.sensor.*noise.triad).noise * noise.factor;
    return searched(f.gain,
                    fmt::format("{} noise ({} {}/sqrt(Hz) is likelier than the file's {}; `tune` finds it)", noise.name,
                                plain(file * f.value, 2), noise.unit, plain(file, 2)),
                    [noise, by = f.value](StatedModel& m) { (m.options.sensor.*noise.triad).noise *= by; });
  };
}

void scale(DriftProcess& process, double factor) {
  process.sigma *= factor;
  process.density *= factor;
}

Cause drift(const Noise& noise) {
  return [noise](const FilterInput& input, const Evidence& base, double end) {
    const Factor f = most_likely_factor([&](double factor) {
      FilterOptions options = input.options;
      scale((options.sensor.*noise.triad).drift, factor);
      return lasting_gain(filter_again(input.log, options, input.start, end), base);
    });
    return searched(f.gain, fmt::format("{} drift (the file's is {}; `tune` finds it)", noise.name, direction(f.value)),
                    [noise, by = f.value](StatedModel& m) { scale((m.options.sensor.*noise.triad).drift, by); });
  };
}

// ---- Sigmas of the fixes ----

void scale_positions(FilterInput& input, std::size_t receiver, double factor) {
  for (GnssFix& fix : input.log.gnss[receiver]) fix.sigma_position *= factor;
  if (auto& coloured = input.options.gnss[receiver].drift) coloured->follow(factor);
}
void scale_velocities(FilterInput& input, std::size_t receiver, double factor) {
  for (GnssFix& fix : input.log.gnss[receiver]) {
    if (fix.velocity) fix.velocity->sigma *= factor;
  }
}
void scale_attitudes(FilterInput& input, std::size_t source, double factor) {
  for (AttitudeFix& fix : input.log.attitude[source]) fix.covariance *= factor * factor;
  if (auto& coloured = input.options.attitude[source].drift) coloured->sigma *= factor;
}

// Of wheels, a barometer or two antennas: one sensor each.
template <auto Log::*kFixes>
void scale_fixes(FilterInput& input, std::size_t, double factor) {
  for (auto& fix : input.log.*kFixes) {
    fix.sigma *= factor;
    if constexpr (requires { fix.sigma_pitch; }) fix.sigma_pitch *= factor;
  }
}

// Positions of a receiver whose fixes differ by `part` of what it states from one to the next: `gain` with that part.
TestedCause slow_part(std::size_t receiver, double part, const std::optional<PositionDrift>& drift, double gain) {
  const double stated_share = drift && drift->of_stated ? drift->sigma.head<2>().mean() : 0;
  const double white = part * std::sqrt(1 - square(stated_share)), share = std::sqrt(1 - white * white),
               time = drift ? drift->correlation_time : kSlowTime;
  return searched(gain,
                  fmt::format("slow error of gnss[{0}].position (fixes differ by {1} of what is stated; "
                              "`drift: {{share: {2}, correlation_time: {3:g} s}}` takes the rest for an error that "
                              "lasts)",
                              receiver, plain(white, 2), plain(share, 2), time),
                  [=](StatedModel& m) {
                    m.options.gnss[receiver].drift = PositionDrift::of_share(Vector3d::Constant(share), time);
                  });
}

Cause sigmas_of_positions(std::size_t receiver) {
  return [receiver](const FilterInput& input, const Evidence& base, double end) {
    const Factor f = most_likely_factor([&](double factor) {
      FilterInput changed = input;
      scale_positions(changed, receiver, factor);
      return lasting_gain(filter_again(changed.log, changed.options, input.start, end), base);
    });
    const GnssOptions& options = input.options.gnss[receiver];
    const std::string source = fmt::format("gnss[{}].position", receiver);
    if (f.value < 1 && may_be_slow(input.options.gnss, source)) {
      return slow_part(receiver, f.value, options.drift, f.gain);
    }
    return searched(f.gain, fmt::format("noise of {} (its sigmas are {})", source, direction(f.value)),
                    [receiver, by = f.value](StatedModel& m) {
                      m.scales[receiver].position *= by;
                      if (auto& slow = m.options.gnss[receiver].drift) slow->follow(by);
                    });
  };
}

// `factor_of`: the factor of a model that states the same, or null.
Cause sigmas(const std::string& source, void (*scale)(FilterInput&, std::size_t, double), std::size_t index,
             double SigmaScales::*factor_of = nullptr) {
  return [=](const FilterInput& input, const Evidence& base, double end) {
    const Factor f = most_likely_factor([&](double factor) {
      FilterInput changed = input;
      scale(changed, index, factor);
      return lasting_gain(filter_again(changed.log, changed.options, input.start, end), base);
    });
    Change change;
    if (factor_of != nullptr) change = [=, by = f.value](StatedModel& m) { m.scales[index].*factor_of *= by; };
    return searched(f.gain, fmt::format("noise of {} (its sigmas are {})", source, direction(f.value)),
                    std::move(change));
  };
}

// ---- Velocities ----

Cause averaged_velocities(std::size_t receiver) {
  return [receiver](const FilterInput& input, const Evidence& base, double end) {
    Factor best;
    for (const double time : kAveragingTimes) {
      FilterOptions options = input.options;
      options.gnss[receiver].velocity_averaging = time;
      const double g = lasting_gain(filter_again(input.log, options, input.start, end), base);
      if (g > best.gain) best = {time, g};
    }
    return searched(
        best.gain,
        fmt::format("velocities of gnss[{0}] (they are means over some {1:g} s; "
                    "`velocity_averaging: {1:g} s`)",
                    receiver, best.value),
        [receiver, time = best.value](StatedModel& m) { m.options.gnss[receiver].velocity_averaging = time; });
  };
}

// ---- Coloured errors ----

double median_sigma(const std::vector<GnssFix>& fixes) {
  std::vector<double> all;
  all.reserve(fixes.size());
  for (const GnssFix& fix : fixes) all.push_back(fix.sigma_position.head<2>().mean());
  return all.empty() ? 0 : median(std::move(all));
}

// A Gauss-Markov error of `factor` sigmas. Below one sigma it is a part of the error that the fixes state; above, it is
// added to that error.
void colour(FilterInput& input, std::size_t receiver, double factor, double correlation_time) {
  Vector3d sigma = Vector3d::Zero();
  for (const GnssFix& fix : input.log.gnss[receiver]) sigma += fix.sigma_position;
  sigma *= factor / static_cast<double>(std::max<std::size_t>(1, input.log.gnss[receiver].size()));
  input.options.gnss[receiver].drift = GaussMarkov{sigma, correlation_time};
  input.options.estimate.push_back(position_drift_block(static_cast<int>(receiver), false));
  if (factor < 1) return;
  for (GnssFix& fix : input.log.gnss[receiver])
    fix.sigma_position = (fix.sigma_position.cwiseAbs2() + sigma.cwiseAbs2()).cwiseSqrt();
}

Cause coloured(std::size_t receiver) {
  return [receiver](const FilterInput& input, const Evidence& base, double end) {
    constexpr double kUsual = 30, kPart = 0.95;  // s; of the sigmas
    const auto gain = [&](double factor, double time) {
      FilterInput changed = input;
      colour(changed, receiver, factor, time);
      return lasting_gain(filter_again(changed.log, changed.options, input.start, end), base);
    };
    Factor f;
    const auto keep = [&](double factor) {
      if (const double g = gain(factor, kUsual); g > f.gain) f = {factor, g};
    };
    for (const double factor : {kPart, 3., 10., 30., 100., 300.}) keep(factor);
    if (f.value > kFactorStep) {
      const double found = f.value, root = std::sqrt(kFactorStep);
      keep(found * root);
      keep(found / root);
    }
    double time = kUsual;
    for (const double other : {3., 10., 100.}) {
      if (f.gain <= 0) break;
      if (const double g = gain(f.value, other); g > f.gain) {
        f.gain = g;
        time = other;
      }
    }
    return searched(
        f.gain,
        fmt::format("coloured error of gnss[{}].position (some {} m over some {:.0f} s; key `drift`)", receiver,
                    plain(f.value * median_sigma(input.log.gnss[receiver]), 2), time),
        [receiver, by = f.value, time](StatedModel& m) {
          const double whole = std::max(1.0, std::hypot(1, by));
          m.options.gnss[receiver].drift = PositionDrift::of_share(Vector3d::Constant(by < 1 ? by : by / whole), time);
          if (by >= 1) m.scales[receiver].position *= whole;
        },
        2);
  };
}

}  // namespace

Cause swaying_antenna(std::size_t receiver) {
  return [receiver](const FilterInput& input, const Evidence& base, double end) {
    const auto gain = [&](double sigma, double time) {
      FilterInput changed = input;
      changed.options.gnss[receiver].lever_arm_sway = GaussMarkov{Vector3d::Constant(sigma), time};
      changed.options.estimate.push_back(lever_arm_sway_block(static_cast<int>(receiver)));
      return lasting_gain(filter_again(changed.log, changed.options, input.start, end), base);
    };
    // What helmets and packs allow, from a tremble to a swing, then nearer to the best of these.
    double sigma = 0, time = 0, best = 0;
    const auto attempt = [&](double s, double t) {
      const double g = gain(s, t);
      if (g <= best) return;
      best = g;
      sigma = s;
      time = t;
    };
    for (const double s : {0.02, 0.06}) {
      for (const double t : {0.1, 0.3, 0.9}) attempt(s, t);
    }
    if (best > 0) {
      const double s = sigma, root = std::sqrt(kFactorStep);
      for (const double by : {root, 1 / root}) attempt(s * by, time);
      const double t = time;
      for (const double by : {root, 1 / root}) attempt(sigma, t * by);
    }
    return searched(
        best,
        fmt::format("antenna of gnss[{}] (it moves on the body, by some {} cm over {} s; "
                    "`lever_arm_sway: {{sigma: {} m, correlation_time: {} s}}`)",
                    receiver, plain(100 * sigma, 2), plain(time, 2), plain(sigma, 2), plain(time, 2)),
        [=](StatedModel& m) {
          m.options.gnss[receiver].lever_arm_sway = GaussMarkov{Vector3d::Constant(sigma), time};
        },
        2);
  };
}

bool may_sway(const FilterOptions& options, std::size_t receiver) {
  return options.gnss[receiver].use_position && !options.gnss[receiver].lever_arm_sway && receiver < kDriftingReceivers;
}

std::vector<Cause> searched_causes(const FilterInput& input) {
  std::vector<Cause> causes;
  const FilterOptions& options = input.options;
  for (const Noise& noise : kNoises) {
    causes.push_back(white_noise(noise));
    if (options.estimates(noise.triad == &ImuSensor::gyro ? Block::kGyroDrift : Block::kAccelDrift))
      causes.push_back(drift(noise));
  }
  for (std::size_t i = 0; i < options.gnss.size(); ++i) {
    if (options.gnss[i].use_position) causes.push_back(sigmas_of_positions(i));
    if (!has_velocities(input, i)) continue;
    if (options.gnss[i].velocity_averaging == 0) causes.push_back(averaged_velocities(i));
    causes.push_back(sigmas(fmt::format("gnss[{}].velocity", i), scale_velocities, i, &SigmaScales::velocity));
  }
  for (std::size_t i = 0; i < options.attitude.size(); ++i)
    causes.push_back(sigmas(fmt::format("attitude[{}]", i), scale_attitudes, i));
  if (!input.log.speed.empty()) causes.push_back(sigmas("odometer", scale_fixes<&Log::speed>, 0));
  if (!input.log.height.empty()) causes.push_back(sigmas("barometer", scale_fixes<&Log::height>, 0));
  if (!input.log.heading.empty()) causes.push_back(sigmas("heading", scale_fixes<&Log::heading>, 0));
  for (std::size_t i = 0; i < options.gnss.size(); ++i) {
    const GnssOptions& receiver = options.gnss[i];
    if (receiver.use_position && !receiver.drift && i < kDriftingReceivers) causes.push_back(coloured(i));
    if (may_sway(options, i)) causes.push_back(swaying_antenna(i));
  }
  return causes;
}

}  // namespace piste
