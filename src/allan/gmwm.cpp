#include "piste/allan/gmwm.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "math/linear_algebra.h"
#include "math/solve_least_squares.h"
#include "piste/core/error.h"
#include "piste/math/interruption.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Model = std::vector<NoiseProcess>;

constexpr double kShortestTime = 2;   // samples: shorter correlation is white
constexpr double kLongestPart = 0.2;  // of the longest stretch: a longer correlation is a random walk
constexpr double kTimeStep = 2;       // factor between the correlation times that are tried first
constexpr std::array kSimpleKinds{ProcessKind::kQuantisation, ProcessKind::kBiasInstability, ProcessKind::kRandomWalk,
                                  ProcessKind::kRamp};

int numbers_of(const Model& model) {
  int n = 0;
  for (const NoiseProcess& p : model) n += p.kind == ProcessKind::kGaussMarkov ? 2 : 1;
  return n;
}

std::string name_of(const Model& model) {
  std::string name;
  int gauss_markov = 0;
  for (const NoiseProcess& p : model) {
    if (p.kind == ProcessKind::kGaussMarkov) {
      ++gauss_markov;
      continue;
    }
    name += (name.empty() ? "" : " + ") + std::string(name_of(p.kind));
  }
  if (gauss_markov > 0) {
    name += fmt::format("{}{}{}", name.empty() ? "" : " + ", gauss_markov > 1 ? fmt::format("{} ", gauss_markov) : "",
                        name_of(ProcessKind::kGaussMarkov));
  }
  return name;
}

/// The curve with the weights of its scales.
struct Moments {
  const AllanCurve* curve;
  VectorXd variance;
  MatrixXd whitening;  // W with Wᵀ W = Ω

  Moments(const AllanCurve& c, VectorXd v) : curve(&c), variance(std::move(v)) {
    for (std::size_t i = 0; i < kProcessKinds.size(); ++i) {
      if (kProcessKinds[i] != ProcessKind::kGaussMarkov) unit_[i] = computed({kProcessKinds[i], 1, 0});
    }
  }

  VectorXd of(const Model& model) const {
    VectorXd nu = VectorXd::Zero(variance.size());
    for (const NoiseProcess& p : model) {
      if (p.kind == ProcessKind::kGaussMarkov) {
        nu += computed(p);
      } else {
        const auto kind = std::find(kProcessKinds.begin(), kProcessKinds.end(), p.kind) - kProcessKinds.begin();
        nu += square(p.size) * unit_[static_cast<std::size_t>(kind)];
      }
    }
    return nu;
  }
  VectorXd shape(ProcessKind kind, double time) const { return of({{kind, 1, time}}); }
  VectorXd residual(const Model& model) const { return whitening * (variance - of(model)); }
  double objective(const Model& model) const { return residual(model).squaredNorm(); }

 private:
  VectorXd computed(const NoiseProcess& p) const {
    return allan_variances(p, *curve, static_cast<std::size_t>(variance.size()));
  }

  std::array<VectorXd, kProcessKinds.size()> unit_;  // of each kind, with the size one
};

// W of a covariance whose scales differ by powers of ten.
MatrixXd whitening_of(const MatrixXd& V) {
  const VectorXd scale = V.diagonal().cwiseSqrt().cwiseInverse();
  const Eigensystem e = eigensystem(MatrixXd(scale.asDiagonal() * V * scale.asDiagonal()));
  const double least = 1e-9 * e.values.maxCoeff();
  const VectorXd root = e.values.cwiseMax(least).cwiseSqrt().cwiseInverse();
  return root.asDiagonal() * e.vectors.transpose() * scale.asDiagonal();
}

// x ≥ 0 for which |A x − b| is least, from AᵀA and Aᵀb (Lawson and Hanson 1974, chapter 23).
VectorXd nonnegative(const MatrixXd& gram, const VectorXd& right) {
  const Index n = right.size();
  VectorXd x = VectorXd::Zero(n);
  std::vector<bool> in(static_cast<std::size_t>(n), false);
  const double tiny = 1e-10 * right.cwiseAbs().maxCoeff();
  const auto solve = [&] {
    std::vector<Index> at;
    for (Index i = 0; i < n; ++i) {
      if (in[static_cast<std::size_t>(i)]) at.push_back(i);
    }
    const VectorXd part = solve_symmetric(MatrixXd(gram(at, at)), VectorXd(right(at)));
    VectorXd z = VectorXd::Zero(n);
    for (std::size_t i = 0; i < at.size(); ++i) z(at[i]) = part(static_cast<Index>(i));
    return z;
  };
  check_interruption();
  for (int round = 0; round < 3 * n + 3; ++round) {
    const VectorXd slope = right - gram * x;
    Index best = -1;
    for (Index i = 0; i < n; ++i) {
      if (!in[static_cast<std::size_t>(i)] && slope(i) > tiny && (best < 0 || slope(i) > slope(best))) best = i;
    }
    if (best < 0) break;
    in[static_cast<std::size_t>(best)] = true;
    VectorXd z = solve();
    for (int inner = 0; inner < n + 1; ++inner) {
      double step = 1;
      Index leaves = -1;
      for (Index i = 0; i < n; ++i) {
        if (!in[static_cast<std::size_t>(i)] || z(i) > 0) continue;
        const double part = x(i) / std::max(x(i) - z(i), 1e-300);
        if (part < step || leaves < 0) {
          step = std::min(step, part);
          leaves = i;
        }
      }
      if (leaves < 0) break;
      x += step * (z - x);
      x(leaves) = 0;
      in[static_cast<std::size_t>(leaves)] = false;
      z = solve();
    }
    x = z;
  }
  return x;
}

/// All shapes that a start is made of, and their products.
class Dictionary {
 public:
  explicit Dictionary(const Moments& moments) {
    const AllanCurve& curve = *moments.curve;
    const auto add = [&](ProcessKind kind, double time) { columns_.push_back({kind, 1, time}); };
    add(ProcessKind::kWhite, 0);
    for (const ProcessKind kind : kSimpleKinds) add(kind, 0);
    const double longest = kLongestPart * curve.longest_stretch();
    for (double t = 1.5 * kShortestTime * curve.interval; t < longest; t *= kTimeStep) {
      add(ProcessKind::kGaussMarkov, t);
    }
    MatrixXd A(moments.variance.size(), static_cast<Index>(columns_.size()));
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const auto at = static_cast<Index>(i);
      A.col(at) = moments.whitening * moments.of({columns_[i]});
      norms_.push_back(std::max(A.col(at).norm(), 1e-300));
      A.col(at) /= norms_.back();
    }
    const VectorXd b = moments.whitening * moments.variance;
    gram_ = A.transpose() * A;
    right_ = A.transpose() * b;
    square_ = b.squaredNorm();
  }

  struct Start {
    Model model;
    double objective = std::numeric_limits<double>::infinity();
  };

  std::size_t column_of(ProcessKind kind) const {
    std::size_t i = 0;
    while (columns_[i].kind != kind) ++i;
    return i;
  }
  std::size_t first_time() const { return 1 + kSimpleKinds.size(); }
  std::size_t size() const { return columns_.size(); }

  // The best non-negative sum of these columns; zero terms are removed, unless `all` must stay.
  Start best(const std::vector<std::size_t>& of, bool all = false) const {
    const std::vector<Index> at(of.begin(), of.end());
    const MatrixXd AtA = gram_(at, at);
    const VectorXd Atb = right_(at);
    const VectorXd x = nonnegative(AtA, Atb);
    Start start;
    start.objective = square_ - 2 * x.dot(Atb) + x.dot(AtA * x);
    const double floor = 1e-6 * x.maxCoeff();
    for (std::size_t i = 0; i < of.size(); ++i) {
      const double value = all ? std::max(x(static_cast<Index>(i)), floor) : x(static_cast<Index>(i));
      if (!(value > 0)) continue;
      NoiseProcess p = columns_[of[i]];
      p.size = std::sqrt(value / norms_[of[i]]);
      start.model.push_back(p);
    }
    return start;
  }

 private:
  std::vector<NoiseProcess> columns_;
  std::vector<double> norms_;
  MatrixXd gram_;
  VectorXd right_;
  double square_ = 0;
};

// Logarithms of the model's numbers, and back.
std::vector<double> logs_of(const Model& model) {
  std::vector<double> logs;
  for (const NoiseProcess& p : model) {
    logs.push_back(std::log(p.size));
    if (p.kind == ProcessKind::kGaussMarkov) logs.push_back(std::log(p.correlation_time));
  }
  return logs;
}

Model with_logs(Model model, const double* logs) {
  for (NoiseProcess& p : model) {
    p.size = std::exp(*logs++);
    if (p.kind == ProcessKind::kGaussMarkov) p.correlation_time = std::exp(*logs++);
  }
  return model;
}

// ∂ν/∂log of each number.
MatrixXd slopes(const Moments& moments, const Model& model) {
  constexpr double kStep = 1e-4;
  MatrixXd D(moments.variance.size(), numbers_of(model));
  Index column = 0;
  for (const NoiseProcess& p : model) {
    D.col(column++) = 2 * moments.of({p});
    if (p.kind != ProcessKind::kGaussMarkov) continue;
    NoiseProcess more = p, less = p;
    more.correlation_time *= std::exp(kStep);
    less.correlation_time *= std::exp(-kStep);
    D.col(column++) = (moments.of({more}) - moments.of({less})) / (2 * kStep);
  }
  return D;
}

class GmwmCost : public ceres::CostFunction {
 public:
  GmwmCost(const Moments& moments, const Model& model) : moments_(moments), model_(model) {
    set_num_residuals(static_cast<int>(moments.variance.size()));
    mutable_parameter_block_sizes()->push_back(numbers_of(model));
  }
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const Model model = with_logs(model_, parameters[0]);
    const VectorXd r = moments_.residual(model);
    if (!r.allFinite()) return false;
    Eigen::Map<VectorXd>(residuals, r.size()) = r;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      const MatrixXd J = -moments_.whitening * slopes(moments_, model);
      Eigen::Map<RowMajor>(jacobians[0], J.rows(), J.cols()) = J;
    }
    return true;
  }

 private:
  const Moments& moments_;
  const Model& model_;
};

// The minimum near a start; the start itself if the iteration leads to correlation times that the curve does not
// determine.
Model polished(const Moments& moments, const Model& start) {
  std::vector<double> logs = logs_of(start);
  ceres::Problem problem;
  problem.AddResidualBlock(new GmwmCost(moments, start), nullptr, logs.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 60;
  options.function_tolerance = 1e-9;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  solve_least_squares(options, problem, summary);
  Model model = with_logs(start, logs.data());
  const double longest = kLongestPart * moments.curve->longest_stretch();
  const bool kept = std::all_of(model.begin(), model.end(), [&](const NoiseProcess& p) {
    return std::isfinite(p.size) && p.size > 0 &&
           (p.kind != ProcessKind::kGaussMarkov ||
            (p.correlation_time > kShortestTime * moments.curve->interval && p.correlation_time < longest));
  });
  if (!kept || !(moments.objective(model) <= moments.objective(start))) model = start;
  std::stable_sort(model.begin(), model.end(), [](const NoiseProcess& a, const NoiseProcess& b) {
    return a.kind == b.kind ? a.correlation_time < b.correlation_time : a.kind < b.kind;
  });
  return model;
}

struct Candidate {
  Model model;
  double objective;
};

// Adds correlation times one by one, each the best in addition to the previous ones.
void add_times(const Dictionary& dictionary, std::vector<std::size_t> columns, int most, bool all,
               std::vector<Dictionary::Start>& starts) {
  starts.push_back(dictionary.best(columns, all && most == 0));
  for (int n = 0; n < most; ++n) {
    Dictionary::Start best;
    std::size_t which = 0;
    for (std::size_t i = dictionary.first_time(); i < dictionary.size(); ++i) {
      if (std::find(columns.begin(), columns.end(), i) != columns.end()) continue;
      columns.push_back(i);
      const Dictionary::Start start = dictionary.best(columns, all && n + 1 == most);
      if (start.objective < best.objective) {
        best = start;
        which = i;
      }
      columns.pop_back();
    }
    if (which == 0) return;
    columns.push_back(which);
    starts.push_back(best);
  }
}

// The admissible models, each fitted, the best first.
std::vector<Candidate> candidates(const Moments& moments, const GmwmOptions& options, double penalty) {
  const Dictionary dictionary(moments);
  std::vector<Dictionary::Start> starts;
  if (options.model.empty()) {
    for (unsigned set = 0; set < 1U << kSimpleKinds.size(); ++set) {
      std::vector<std::size_t> columns{dictionary.column_of(ProcessKind::kWhite)};
      for (std::size_t i = 0; i < kSimpleKinds.size(); ++i) {
        if ((set >> i & 1) != 0) columns.push_back(dictionary.column_of(kSimpleKinds[i]));
      }
      add_times(dictionary, columns, options.gauss_markov, false, starts);
    }
  } else {
    std::vector<std::size_t> columns;
    int times = 0;
    for (const ProcessKind kind : options.model) {
      if (kind == ProcessKind::kGaussMarkov) {
        ++times;
      } else {
        columns.push_back(dictionary.column_of(kind));
      }
    }
    add_times(dictionary, columns, times, true, starts);
    starts.erase(starts.begin(), starts.end() - 1);
  }
  const auto worth = [&](const Dictionary::Start& s) { return s.objective + penalty * numbers_of(s.model); };
  std::stable_sort(starts.begin(), starts.end(), [&](const auto& a, const auto& b) { return worth(a) < worth(b); });
  constexpr std::size_t kPolished = 24;
  std::map<std::string, Candidate> best;
  std::size_t tried = 0;
  for (const Dictionary::Start& start : starts) {
    if (start.model.empty() || tried++ == kPolished) continue;
    if (tried > kPolished) break;
    Candidate c{polished(moments, start.model), 0};
    c.objective = moments.objective(c.model);
    const auto [place, is_new] = best.try_emplace(name_of(c.model), c);
    if (!is_new && c.objective < place->second.objective) place->second = c;
  }
  std::vector<Candidate> found;
  found.reserve(best.size());
  for (auto& [name, c] : best) found.push_back(std::move(c));
  std::stable_sort(found.begin(), found.end(), [&](const Candidate& a, const Candidate& b) {
    return a.objective + penalty * numbers_of(a.model) < b.objective + penalty * numbers_of(b.model);
  });
  return found;
}

// Upper bound of a process in addition to the fitted ones: where the objective has risen by a one-sided χ².
double most_unseen(const Moments& moments, const Model& model, ProcessKind kind) {
  constexpr double kRise = 2.706;  // χ²₁ of 90 %: one-sided 95 %
  std::vector<VectorXd> columns;
  for (const NoiseProcess& p : model) columns.emplace_back(moments.whitening * moments.of({p}));
  const VectorXd b = moments.whitening * moments.variance, shape = moments.whitening * moments.shape(kind, 0);
  MatrixXd A(b.size(), static_cast<Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) A.col(static_cast<Index>(i)) = columns[i];
  const MatrixXd AtA = A.transpose() * A;
  const auto objective = [&](double square_size) {
    const VectorXd rest = b - square_size * shape;
    const VectorXd x = nonnegative(AtA, A.transpose() * rest);
    return (rest - A * x).squaredNorm();
  };
  const double least = objective(0);
  double high = 1 / std::max(shape.norm(), 1e-300), low = 0;
  while (objective(high) < least + kRise && high < 1e300) high *= 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (objective(middle) < least + kRise ? low : high) = middle;
  }
  return std::sqrt(high);
}

// Without the scales at which so few independent clusters are averaged that χ² is far from normal.
AllanCurve determined_scales(AllanCurve curve) {
  constexpr std::size_t kClusters = 4;  // beyond the first two: some five degrees of freedom
  std::erase_if(curve.scales, [](const AllanScale& s) { return s.terms < kClusters * s.samples; });
  return curve;
}

MatrixXd with_error(MatrixXd V, const VectorXd& variance, double error) {
  V.diagonal() += (error * variance).cwiseAbs2();
  return V;
}

}  // namespace

std::vector<NoiseProcess> GmwmFit::processes() const {
  std::vector<NoiseProcess> all;
  all.reserve(parts.size());
  for (const FittedProcess& p : parts) all.push_back(p.process);
  return all;
}

std::string GmwmFit::name() const { return name_of(processes()); }

const FittedProcess* GmwmFit::find(ProcessKind kind) const {
  for (const FittedProcess& p : parts) {
    if (p.process.kind == kind) return &p;
  }
  return nullptr;
}

GmwmFit fit_gmwm(const AllanCurve& whole, const GmwmOptions& options) {
  constexpr std::size_t kFewest = 4;
  const AllanCurve curve = determined_scales(whole);
  constexpr int kRounds = 4;
  constexpr double kRefused = 0.05, kMostError = 1;
  const std::size_t scales = curve.scales.size();
  if (scales < kFewest) {
    throw DataError(
        "", fmt::format("the curve has {} scales; a fit needs {}, which is {} samples", scales, kFewest, 1 << kFewest));
  }
  VectorXd measured(static_cast<Index>(scales));
  for (std::size_t i = 0; i < scales; ++i) {
    const double v = options.robust ? curve.scales[i].robust : curve.scales[i].variance;
    if (!(v > 0) || !std::isfinite(v)) throw DataError("", "the samples do not vary");
    measured(static_cast<Index>(i)) = v;
  }
  Moments moments(curve, measured);
  const double inflation = options.robust ? 1 / robust::efficiency() : 1;
  constexpr double penalty = kPenalty;

  // V by the model, the model by V. At first each scale as if it were alone.
  VectorXd alone(moments.variance.size());
  for (Index i = 0; i < alone.size(); ++i) {
    const AllanScale& s = curve.scales[static_cast<std::size_t>(i)];
    const double freedom = std::max(1.0, static_cast<double>(s.terms) / static_cast<double>(s.samples));
    alone(i) = 2 / freedom * square(moments.variance(i));
  }
  MatrixXd V = alone.asDiagonal();
  std::vector<Candidate> found;
  double error = 0;
  for (int round = 0; round < kRounds; ++round) {
    const auto with = [&](double e) {
      moments.whitening = whitening_of(with_error(V, moments.variance, e));
      return candidates(moments, options, penalty);
    };
    const auto refused = [&] {
      const double freedom = static_cast<double>(scales) - numbers_of(found.front().model);
      return chi_squared_above(found.front().objective, freedom) < kRefused;
    };
    error = 0;
    found = with(0);
    if (round > 0 && refused()) {
      double low = 0, high = kMostError;
      constexpr int kHalvings = 9;
      for (int i = 0; i < kHalvings; ++i) {
        const double middle = i == 0 ? 0.02 : low == 0 ? high / 4 : std::sqrt(low * high);
        found = with(middle);
        (refused() ? low : high) = middle;
      }
      error = high;
      found = with(error);
    }
    if (found.empty()) throw DataError("", "no model has any noise");
    const MatrixXd before = V;
    V = inflation * allan_covariance(found.front().model, curve);
    if (round > 0 && (V - before)
                             .cwiseAbs()
                             .cwiseQuotient(V.diagonal().cwiseSqrt() * V.diagonal().cwiseSqrt().transpose())
                             .maxCoeff() < 0.01)
      break;
  }
  moments.whitening = whitening_of(with_error(V, moments.variance, error));
  Model model = polished(moments, found.front().model);

  GmwmFit fit;
  fit.covariance = V;
  fit.model_error = error;
  fit.freedom = static_cast<double>(scales) - numbers_of(model);
  {
    Moments strict = moments;
    strict.whitening = whitening_of(V);
    const Model best = error > 0 ? polished(strict, model) : model;
    fit.objective = strict.objective(best);
    fit.p_value = chi_squared_above(fit.objective, fit.freedom);
  }
  for (const Candidate& c : found) fit.tried.push_back({name_of(c.model), c.objective, penalty * numbers_of(c.model)});
  const VectorXd nu = moments.of(model);
  fit.variance.assign(nu.data(), nu.data() + nu.size());
  fit.measured.assign(moments.variance.data(), moments.variance.data() + moments.variance.size());
  for (Index i = 0; i < nu.size(); ++i) {
    const double relative = V(i, i) / square(nu(i));
    const auto [low, high] =
        size_interval(std::sqrt(moments.variance(i)), std::sqrt(relative) / 2, options.probability);
    fit.low.push_back(square(low));
    fit.high.push_back(square(high));
    const double off = std::abs(std::sqrt(nu(i) / moments.variance(i)) - 1) - std::sqrt(relative);  // 2 sigmas of √
    if (off > fit.worst) {
      fit.worst = off;
      fit.worst_tau = curve.tau(static_cast<std::size_t>(i));
    }
  }
  // Covariance of the logarithms: (Dᵀ Ω D)⁻¹, as Ω is the inverse of the covariance.
  const MatrixXd WD = moments.whitening * slopes(moments, model);
  const MatrixXd P = inverse(MatrixXd(WD.transpose() * WD));
  fit.logs = P;
  constexpr double kFactor = 3;
  Index at = 0;
  for (const NoiseProcess& p : model) {
    FittedProcess part;
    part.process = p;
    const double variance_log = std::max(P(at, at), 0.0);
    part.sigma_log = std::sqrt(variance_log);
    std::tie(part.low, part.high) = size_interval(p.size, part.sigma_log, options.probability);
    part.determined = part.high < kFactor * kFactor * part.low;
    ++at;
    if (p.kind == ProcessKind::kGaussMarkov) {
      const double reach = normal_quantile((1 + options.probability) / 2) * std::sqrt(std::max(P(at, at), 0.0));
      part.low_time = p.correlation_time * std::exp(-reach);
      part.high_time = p.correlation_time * std::exp(reach);
      part.determined = part.determined && part.high_time < kFactor * kFactor * part.low_time;
      ++at;
    }
    fit.parts.push_back(part);
  }
  for (const ProcessKind kind : kSimpleKinds) {
    if (fit.find(kind) == nullptr) fit.unseen.push_back({kind, most_unseen(moments, model, kind)});
  }
  return fit;
}

}  // namespace piste
