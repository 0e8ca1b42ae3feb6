// experiment harness
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

#include "piste/sim/random.h"
#include "piste/solve/rts.h"
#include "support/simulated_case.h"

namespace piste::test {
namespace {

struct Worst {
  double error = 0, ratio = 0, at = 0;
  void take(double e, double sigma, double t) {
    error = std::max(error, std::abs(e));
    if (std::abs(e) / sigma > ratio) {
      ratio = std::abs(e) / sigma;
      at = t;
    }
  }
};
struct Score {
  Worst position, velocity, euler;
  Vector3d last;
};

Score score(const Case& c, const Solution& s, const Log&, double from) {
  Score out;
  const Truth& truth = c.simulation.bodies[0];
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double t = s.time(i);
    if (t < from) continue;
    const TruthState x = truth.at(t);
    const Estimate e = s.estimate(i);
    const Sigmas sig = s.sigmas(i);
    const Geodetic g = truth.world().to_geodetic(x.p_wb);
    const Vector3d dp = e.p_wb - s.world().from_geodetic(g);
    const Matrix3d R = s.world().rotation_wn(e.p_wb).transpose() ;
    (void)R;
    const Vector3d dv = e.v_wb - x.v_wb;
    const Vector3d da = to_euler(e.q_wb) - to_euler(x.q_wb);
    for (int k = 0; k < 3; ++k) {
      out.position.take(dp(k), sig.position(k), t - c.under_way());
      out.velocity.take(dv(k), sig.velocity(k), t - c.under_way());
      out.euler.take(std::remainder(da(k), 360 * kDegree) / kDegree, sig.euler(k) / kDegree, t - c.under_way());
    }
    out.last = dp;
  }
  return out;
}

void run(const std::string& name, const Case& c, const Log& log, const Start& start) {
  const FilterRun filtered = run_filter(log, c.options, start, kCheckpointEvery);
  const Solution smoothed = smooth_rts(log, filtered);
  const Score f = score(c, filtered.solution, log, start.time), s = score(c, smoothed, log, start.time);
  std::map<std::string, std::array<int, 5>> counts;
  for (const Innovation& v : filtered.solution.innovations)
    ++counts[filtered.solution.sources[(std::size_t)v.source]][(std::size_t)v.outcome];
  std::string text;
  for (const auto& [k, v] : counts)
    if (k.starts_with("gnss")) text += fmt::format(" {}{}", k.back() == 'n' ? 'p' : 'v', fmt::format("{}/{}/{}/{}/{}", v[0], v[1], v[2], v[3], v[4]));
  const auto put = [](const Score& q) {
    return fmt::format("p {:6.2f} m {:5.1f}s @{:5.1f} v {:5.2f} {:5.1f}s a {:5.2f} {:5.1f}s end {:.2f}", q.position.error, q.position.ratio, q.position.at,
                       q.velocity.error, q.velocity.ratio, q.euler.error, q.euler.ratio, q.last.norm());
  };
  fmt::print("{:34s} {}{} F {} | S {} |{}\n", name, f.position.ratio > 5 ? 'X' : '.', s.position.ratio > 5 ? 'X' : '.', put(f), put(s), text);
  std::fflush(stdout);
}

using Change = std::function<void(Log&)>;

Change lie(double from, double length, Vector3d step, Vector3d rate, bool velocity) {
  return [=](Log& log) {
    for (GnssFix& f : log.gnss[0]) {
      const double t = f.time - from;
      if (t < 0 || t > length) continue;
      f.position += step + t * rate;
      if (velocity && f.velocity) f.velocity->value += rate;
    }
  };
}
Change outliers(double part, std::uint64_t seed, bool velocity_too = false) {
  return [=](Log& log) {
    RandomStream r(seed, "outliers");
    int i = 0;
    for (GnssFix& f : log.gnss[0]) {
      const double u = r.uniform(), size = 2 + 98 * r.uniform();
      const Vector3d d = r.normal3().normalized();
      if (i++ > 0 && u < part) { f.position += size * d; if (velocity_too && f.velocity) f.velocity->value += 0.1*size*d; }
    }
  };
}

TEST(Lie, Table) {
  const std::string which = std::getenv("MOTIONS") ? std::getenv("MOTIONS") : "ski bicycle giant_slalom";
  const int seeds = std::getenv("SEEDS") ? std::atoi(std::getenv("SEEDS")) : 1;
  const std::string only = std::getenv("ONLY") ? std::getenv("ONLY") : "";
  for (const std::string motion : {"ski", "bicycle", "giant_slalom"}) {
    if (which.find(motion) == std::string::npos) continue;
    for (const int receiver : {0, 1}) {
      if (std::getenv("REC") && std::atoi(std::getenv("REC")) != receiver) continue;
      for (const bool velocity : {true, false}) {
        if (std::getenv("VEL") && std::atoi(std::getenv("VEL")) != (velocity ? 1 : 0)) continue;
        for (int seed = 1; seed <= seeds; ++seed) {
          const Case c = [&] {
            Case k = make_case(motion, 40, (std::uint64_t)seed, [&](Scenario& s) {
              if (receiver == 1) {
                Scenario all = read_scenario(std::filesystem::path(PISTE_SOURCE_DIR) / "config" / "scenarios" / (motion + ".yaml"));
                s.gnss = {all.gnss[1]};
              }
              s.motion.run = 100;
              if (!velocity) s.gnss[0].velocity_noise.setZero();
            });
            k.options.gnss[0].use_velocity = velocity;
            k.options.gnss[0].drift = k.scenario.gnss[0].position_drift;
            if (std::getenv("NODRIFT") && receiver == 1) k.options.gnss[0].drift.reset();
            if (k.options.gnss[0].drift) k.options.estimate.push_back(Block::kGnssPositionDrift);
            return k;
          }();
          const Log clean = c.log();
          const Start start = find_start(clean, c.options, {}).start;
          const double t0 = c.under_way() + 40;
          const Vector3d d = Vector3d(0.6, -0.7, 0.39).normalized();
          const std::string prefix = fmt::format("{} L{} {} {} ", motion.substr(0, 3), receiver ? "1" : "2", velocity ? "pv" : "p ", seed);
          const auto go = [&](const std::string& name, const Change& change) {
            if (!only.empty() && name.find(only) == std::string::npos) return;
            Log log = clean;
            change(log);
            try {
              run(prefix + name, c, log, start);
            } catch (const std::exception& e) {
              fmt::print("{} THROWS {}\n", prefix + name, e.what());
            }
          };
          go("clean", [](Log&) {});
          go("outage30", [&](Log& l) { std::erase_if(l.gnss[0], [&](const GnssFix& f) { return f.time > t0 && f.time < t0 + 30; }); });
          go("outliers", outliers(0.1, seed));
          go("outliers pv", outliers(0.1, seed + 100, true));
          for (const double size : {2., 20., 50.}) go(fmt::format("step{}", size), lie(t0, 30, size * d, {0, 0, 0}, true));
          go("step20+outl", [&](Log& l) { lie(t0, 30, 2 * d, {0, 0, 0}, true)(l); outliers(0.1, seed)(l); });
          go("step20 for good", lie(t0, 300, 20 * d, {0, 0, 0}, true));
          go("step3 for good", lie(t0, 300, 3 * d, {0, 0, 0}, true));
          go("ramp0.5 pv", lie(t0, 30, {0, 0, 0}, 0.5 * d, true));
          go("ramp0.5 p", lie(t0, 30, {0, 0, 0}, 0.5 * d, false));
          go("step20ramp2 pv", lie(t0, 30, 20 * d, 2 * d, true));
          go("stale10", [&](Log& l) {
            const GnssFix* held = nullptr;
            for (GnssFix& f : l.gnss[0]) {
              if (f.time < t0 || f.time > t0 + 10) continue;
              if (!held) { held = &f; continue; }
              f.position = held->position; f.velocity = held->velocity;
            }
          });
          go("imu clock +0.2", [&](Log& l) {  // IMU stamps late from t0: a filled gap
            std::vector<ImuSample> out;
            for (ImuSample s : l.imu) {
              if (s.time > t0 && out.back().time < t0 + 1e-3 ) {
                for (int k = 1; k <= 20; ++k) { ImuSample g = s; g.gap = true; g.time = s.time - s.interval + 0.01 * k; g.interval = 0.01; out.push_back(g); }
              }
              if (s.time > t0) s.time += 0.2;
              out.push_back(s);
            }
            l.imu = out; for (auto& r : l.rest) if (r.start > t0) { r.start += 0.2; r.end += 0.2; }
          });
          go("imu lost 0.2 hidden", [&](Log& l) {  // 20 samples lost, stamps go on without them
            std::vector<ImuSample> out;
            for (ImuSample s : l.imu) {
              if (s.time > t0 && s.time < t0 + 0.2) continue;
              if (s.time > t0) s.time -= 0.2;
              out.push_back(s);
            }
            l.imu = out;
          });
        }
      }
    }
  }
}

TEST(Lie, Start) {
  const Case c = make_case("ski", 40, 1, [](Scenario& s) { s.motion.run = 60; });
  const Log log = c.log();
  Start start = find_start(log, c.options, {}).start;
  start.x.p_wb += Vector3d(60, -70, 39);
  start.covariance.topLeftCorner<3, 3>() = Matrix3d::Identity();
  run("start 100 m wrong", c, log, start);
}

}  // namespace
}  // namespace piste::test
