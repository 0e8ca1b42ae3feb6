#include "smoother/smoothed_parts.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "math/four.h"
#include "model/step_operator.h"

namespace piste {
namespace {

constexpr std::ptrdiff_t kTile = 16, kFours = kTile / 4;  // columns that are processed together
constexpr std::ptrdiff_t kLaneStride = StepOperator::kLanes;
constexpr int kTopRows = StepOperator::kNavigation;
// Columns of a tile: position, one other state, velocity and attitude, other states.
constexpr std::size_t kOther = 3, kMotion = 4, kAfter = 10;

// Rows of a tile of C, two at a time: `lanes` times the stored P. Ten rows: navigation, and λᵀ P as the last.
PISTE_WIDE void rows_through(const double* lanes, const double* kept, std::ptrdiff_t n, double* out) {
  for (std::ptrdiff_t i = 0; i <= kTopRows; i += 2) {
    Four a[kFours] = {}, b[kFours] = {};
    for (std::ptrdiff_t k = 0; k < n; ++k) {
      const double wa = lanes[k * kLaneStride + i], wb = lanes[k * kLaneStride + i + 1];
      for (std::ptrdiff_t j = 0; j < kFours; ++j) {
        Four x;
        load(kept + k * kTile + 4 * j, x);
        a[j] += wa * x;
        b[j] += wb * x;
      }
    }
    for (std::ptrdiff_t j = 0; j < kFours; ++j) {
      store(a[j], out + i * kTile + 4 * j);
      store(b[j], out + (i + 1) * kTile + 4 * j);
    }
  }
}

// out = U C for the upper half U of a symmetric Λ, its diagonal halved: Cᵀ Λ C is Cᵀ U C plus its transpose.
PISTE_WIDE void times_upper_half(const double* Lambda, const double* C, std::ptrdiff_t n, double* out) {
  for (std::ptrdiff_t i = 0; i < n; i += 2) {
    const double* la = Lambda + i * n;
    Four a[kFours], b[kFours] = {};
    for (std::ptrdiff_t j = 0; j < kFours; ++j) {
      Four x;
      load(C + i * kTile + 4 * j, x);
      a[j] = 0.5 * la[i] * x;
    }
    if (i + 1 < n) {
      const double* lb = la + n;
      for (std::ptrdiff_t j = 0; j < kFours; ++j) {
        Four x;
        load(C + (i + 1) * kTile + 4 * j, x);
        a[j] += la[i + 1] * x;
        b[j] = 0.5 * lb[i + 1] * x;
      }
      for (std::ptrdiff_t k = i + 2; k < n; ++k) {
        const double wa = la[k], wb = lb[k];
        for (std::ptrdiff_t j = 0; j < kFours; ++j) {
          Four x;
          load(C + k * kTile + 4 * j, x);
          a[j] += wa * x;
          b[j] += wb * x;
        }
      }
      for (std::ptrdiff_t j = 0; j < kFours; ++j) store(b[j], out + (i + 1) * kTile + 4 * j);
    }
    for (std::ptrdiff_t j = 0; j < kFours; ++j) store(a[j], out + i * kTile + 4 * j);
  }
}

// Blocks of Cᵀ (U C) in the first tile: position with itself, velocity and attitude with themselves.
struct Corners {
  double position[3][4];
  double motion[6][8];
};
PISTE_WIDE void multiply_corners(const double* C, const double* UC, std::ptrdiff_t n, Corners& out) {
  Four p[3] = {}, m[6][2] = {};
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    const double *c = C + k * kTile, *u = UC + k * kTile;
    Four u0, u1, u2;
    load(u, u0);
    load(u + kMotion, u1);
    load(u + kMotion + 4, u2);
    for (int a = 0; a < 3; ++a) p[a] += c[a] * u0;
    for (int a = 0; a < 6; ++a) {
      m[a][0] += c[kMotion + static_cast<std::size_t>(a)] * u1;
      m[a][1] += c[kMotion + static_cast<std::size_t>(a)] * u2;
    }
  }
  for (int a = 0; a < 3; ++a) store(p[a], out.position[a]);
  for (int a = 0; a < 6; ++a) {
    store(m[a][0], out.motion[a]);
    store(m[a][1], out.motion[a] + 4);
  }
}

// Sums of products, column by column of a tile.
PISTE_WIDE void multiply_columns(const double* A, const double* B, std::ptrdiff_t n, double* out) {
  Four sum[kFours] = {};
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    for (std::ptrdiff_t j = 0; j < kFours; ++j) {
      Four a, b;
      load(A + k * kTile + 4 * j, a);
      load(B + k * kTile + 4 * j, b);
      sum[j] += a * b;
    }
  }
  for (std::ptrdiff_t j = 0; j < kFours; ++j) store(sum[j], out + 4 * j);
}

bool is_fixed(Block b) { return info(b).process == nullptr; }

}  // namespace

PartsSmoother::PartsSmoother(const StateLayout& layout, Considered considered)
    : layout_(layout), considered_(std::move(considered)), column_(n(), -1) {
  std::vector<int> slow;
  for (const Block b : layout.blocks()) {
    if (is_navigation(b)) continue;
    (is_fixed(b) ? constants_ : changing_).push_back(b);
    for (int k = 0; k < info(b).size && !is_fixed(b); ++k) slow.push_back(layout.offset(b) + k);
  }
  for (const auto& [bias, drift] :
       {std::pair{Block::kGyroBias, Block::kGyroDrift}, {Block::kAccelBias, Block::kAccelDrift}}) {
    if (layout.has(bias) && layout.has(drift)) pairs_.push_back({bias, drift});
  }
  const std::size_t first = static_cast<std::size_t>(kTile) - kAfter + 1;  // of them fit into the first tile
  const std::size_t more = slow.size() > first ? slow.size() - first : 0, tile = kTile;
  width_ = tile * (1 + (more + tile - 1) / tile);
  state_.assign(width_, -1);
  for (int k = 0; k < 3; ++k) state_[static_cast<std::size_t>(k)] = k;
  for (int k = 0; k < 6; ++k) state_[kMotion + static_cast<std::size_t>(k)] = 3 + k;
  for (std::size_t i = 0; i < slow.size(); ++i) state_[i == 0 ? kOther : kAfter + i - 1] = slow[i];
  for (std::size_t c = 0; c < width_; ++c) {
    if (state_[c] >= 0) column_[static_cast<std::size_t>(state_[c])] = static_cast<int>(c);
  }
  const int size = layout.size();
  of_constants_.setZero(size, size);
  parts_.P.setZero(size, size);
  parts_.turn.setIdentity();
  correction_.setZero(size);
  weights_.assign(width_ * n(), 0);
  through_.assign(width_ * n(), 0);
  half_.assign(width_ * n(), 0);
}

std::size_t PartsSmoother::at(std::size_t column) const {
  constexpr std::size_t kWide = kTile;
  return column / kWide * kWide * n() + column % kWide;
}

void PartsSmoother::keep(const Covariance& P, const ErrorVector& mean, std::vector<double>& out) const {
  constexpr std::size_t kWide = kTile;
  const std::size_t begin = out.size();
  out.resize(begin + kept_size());
  double* to = out.data() + begin;
  for (std::size_t first = 0; first < width_; first += kWide) {
    for (Eigen::Index k = 0; k < P.cols(); ++k, to += kWide) {
      const double* from = P.col(k).data();
      for (std::size_t c = 0; c < kWide; ++c) {
        const int state = state_[first + c];
        to[c] = state < 0 ? 0 : from[state];
      }
    }
  }
  std::copy(mean.data(), mean.data() + mean.size(), to);
}

double PartsSmoother::dot(const std::vector<double>& a, std::size_t column_a, const std::vector<double>& b,
                          std::size_t column_b) const {
  const double *x = a.data() + at(column_a), *y = b.data() + at(column_b);
  double sum = 0;
  for (std::size_t k = 0; k < n(); ++k) sum += x[k * kTile] * y[k * kTile];
  return sum;
}

void PartsSmoother::find_constants(const Covariance& P, const ErrorVector& mean, const ErrorVector& lambda,
                                   const Covariance& Lambda) {
  for (const Block b : constants_) {
    const int o = layout_.offset(b), size = info(b).size;
    const auto columns = P.middleCols(o, size);
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostStates, kLargestBlock> weighted =
        Lambda.transpose().lazyProduct(columns);  // Λ is symmetric: the product reads its columns
    of_constants_.block(o, o, size, size) = P.block(o, o, size, size) - columns.transpose().lazyProduct(weighted);
    correction_.segment(o, size) = mean.segment(o, size) - columns.transpose().lazyProduct(lambda);
    for (const Pair& pair : pairs_) {
      if (pair.bias != b) continue;
      for (int i = 0; i < size; ++i) {
        double* to = weights_.data() + at(column_of(layout_.offset(pair.drift) + i));
        for (Eigen::Index k = 0; k < weighted.rows(); ++k) to[k * kTile] = weighted(k, i);
      }
    }
  }
}

const SmoothedParts& PartsSmoother::row(const double* kept, const Estimate& x, const double* lanes, const double* decay,
                                        const Covariance& Lambda) {
  constexpr std::size_t kWide = kTile;
  const auto size = static_cast<std::ptrdiff_t>(n());
  const double* mean = kept + width_ * n();
  double sums[kMostStates + kTile], crosses[kMostStates + kTile];
  Corners corners;
  for (std::size_t first = 0; first < width_; first += kWide) {
    const double* tile = kept + first * n();
    double *C = through_.data() + first * n(), *UC = half_.data() + first * n();
    double top[(kTopRows + 1) * kTile];
    rows_through(lanes, tile, size, top);
    std::copy(top, top + kTopRows * kTile, C);
    for (std::size_t c = 0; c < kWide; ++c) {
      const int state = state_[first + c];
      if (state >= 0) correction_(state) = mean[state] - top[kTopRows * kTile + c];
    }
    for (std::ptrdiff_t k = kTopRows; k < size; ++k) {
      for (std::ptrdiff_t c = 0; c < kTile; ++c) C[k * kTile + c] = decay[k] * tile[k * kTile + c];
    }
    times_upper_half(Lambda.data(), C, size, UC);
    if (first == 0) multiply_corners(C, UC, size, corners);
    multiply_columns(C, UC, size, sums + first);
    multiply_columns(C, weights_.data() + first * n(), size, crosses + first);
  }
  const auto of_filter = [&](int state, std::size_t column) {
    return kept[at(column) + static_cast<std::size_t>(state) * kWide];
  };

  Covariance& P = parts_.P;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b <= a; ++b) {
      P(a, b) = P(b, a) = of_filter(a, static_cast<std::size_t>(b)) - (corners.position[a][b] + corners.position[b][a]);
    }
  }
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b <= a; ++b) {
      P(3 + a, 3 + b) = P(3 + b, 3 + a) =
          of_filter(3 + a, kMotion + static_cast<std::size_t>(b)) - (corners.motion[a][b] + corners.motion[b][a]);
    }
  }
  for (const Block block : changing_) {
    const int o = layout_.offset(block), count = info(block).size;
    for (int i = 0; i < count; ++i) {
      const std::size_t c = column_of(o + i);
      P(o + i, o + i) = of_filter(o + i, c) - 2 * sums[c];
      for (int j = 0; j < i && is_rotation(block); ++j) {
        const std::size_t d = column_of(o + j);
        P(o + i, o + j) = P(o + j, o + i) =
            of_filter(o + i, d) - (dot(through_, c, half_, d) + dot(through_, d, half_, c));
      }
    }
  }
  for (const Block block : constants_) {
    const int o = layout_.offset(block), count = info(block).size;
    P.block(o, o, count, count) = of_constants_.block(o, o, count, count);
  }
  for (const auto& [bias, drift] : pairs_) {
    for (int i = 0; i < info(bias).size; ++i) {
      const int b = layout_.offset(bias) + i, d = layout_.offset(drift) + i;
      const std::size_t c = column_of(d);
      P(b, d) = P(d, b) = of_filter(b, c) - crosses[c];
    }
  }

  considered_.hold(correction_);
  parts_.x = boxplus(x, layout_, correction_);
  const ResetJacobian G = reset_jacobian(layout_, correction_);
  parts_.turn = G.velocity_attitude.bottomRightCorner<3, 3>();
  using Motion = Eigen::Matrix<double, 6, 6>;
  const Motion turned = G.velocity_attitude * P.block<6, 6>(3, 3) * G.velocity_attitude.transpose();
  P.block<6, 6>(3, 3) = 0.5 * (turned + turned.transpose());
  for (std::size_t i = 0; i < kMountingBlocks.size(); ++i) {
    if (!layout_.has(kMountingBlocks[i])) continue;
    const int o = layout_.offset(kMountingBlocks[i]);
    const Matrix3d mounting = G.mountings[i] * P.block<3, 3>(o, o) * G.mountings[i].transpose();
    P.block<3, 3>(o, o) = 0.5 * (mounting + mounting.transpose());
  }
  return parts_;
}

}  // namespace piste
