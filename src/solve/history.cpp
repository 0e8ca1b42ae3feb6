#include "piste/solve/history.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "piste/solve/fix_queue.h"

namespace piste {
namespace {

constexpr double kChunk = 1;  // s: covariances are filtered again over it, and are a tenth of what is kept

template <class Values>
void put(std::vector<double>& out, const Values& values) {
  out.insert(out.end(), values.data(), values.data() + values.size());
}

// Reads values in the order in which they were put.
class Reader {
 public:
  Reader(const History::Chunk& chunk, std::size_t at) : p_(chunk.values.data() + at) {}
  double number() { return *p_++; }
  template <class Values>
  void take(Values&& values) {
    for (Eigen::Index k = 0; k < values.size(); ++k) values.data()[k] = *p_++;
  }
  ErrorVector vector(int size) {
    ErrorVector v(size);
    take(v);
    return v;
  }

 private:
  const double* p_;
};

std::size_t packed(int n) { return static_cast<std::size_t>(n) * static_cast<std::size_t>(n + 1) / 2; }

}  // namespace

void History::begin(const FilterState& state, bool reference) {
  *this = {};
  size_ = static_cast<int>(state.P.rows());
  reference_ = reference;
  open(state);
}

void History::open(const FilterState& state) {
  now_.first = rows_;
  now_.time = state.time;
  now_.events.clear();
  now_.values.clear();
  for (int j = 0; j < size_; ++j) put(now_.values, state.P.col(j).head(j + 1));
  if (reference_) put(now_.values, state.mean);
}

// What is kept has no room to grow.
void History::close() { chunks_.push_back(now_); }

void History::add(Kind kind, std::uint32_t other) {
  now_.events.push_back({kind, static_cast<std::uint32_t>(now_.values.size()), other});
}

// A step's scales are where the step before it has them, unless they have changed.
void History::add_step(const Transition& t) {
  const ErrorStep& s = t.step;
  if (around_.empty() || !(around_.back() == s.around)) around_.push_back(s.around);
  auto scales = static_cast<double>(now_.values.size());
  const auto before = std::find_if(now_.events.rbegin(), now_.events.rend(),
                                   [](const Event& event) { return event.kind == Kind::kStep; });
  if (before != now_.events.rend()) {
    const ErrorStep last = step(now_, *before);
    if (last.gyro_scale == s.gyro_scale && last.accel_scale == s.accel_scale) scales = now_.values[before->at];
  }
  if (scales == static_cast<double>(now_.values.size())) {
    put(now_.values, s.gyro_scale);
    put(now_.values, s.accel_scale);
  }
  add(Kind::kStep, static_cast<std::uint32_t>(around_.size() - 1));
  now_.values.push_back(scales);
  now_.values.push_back(s.dt);
  put(now_.values, s.q_wb.coeffs());
  for (const Vector3d* v : {&s.v_wb, &s.rate, &s.force}) put(now_.values, *v);
}

ErrorStep History::step(const Chunk& chunk, const Event& event) const {
  Reader r(chunk, event.at);
  Reader scales(chunk, static_cast<std::size_t>(r.number()));
  ErrorStep s;
  scales.take(s.gyro_scale);
  scales.take(s.accel_scale);
  s.dt = r.number();
  r.take(s.q_wb.coeffs());
  for (Vector3d* v : {&s.v_wb, &s.rate, &s.force}) r.take(*v);
  s.around = around_[event.other];
  return s;
}

// Of H only the columns that are not zero: a fix depends on few blocks.
void History::add_correction(const Update& u, bool moved) {
  add(Kind::kCorrection, moved);
  std::vector<double>& out = now_.values;
  out.push_back(u.rows);
  out.push_back(u.observed);
  const std::size_t count = out.size();
  out.push_back(0);
  for (int k = 0; k < size_; ++k) {
    if (u.H.col(k).isZero(0)) continue;
    out[count] += 1;
    out.push_back(k);
    put(out, u.H.col(k));
  }
  put(out, u.PHt);
  for (const Matrix3d* m : {&u.S, &u.R}) {
    for (int j = 0; j < 3; ++j) put(out, m->col(j).head(j + 1));
  }
  put(out, u.residual);
}

History::Correction History::correction(const Chunk& chunk, const Event& event) const {
  Reader r(chunk, event.at);
  Correction c;
  Update& u = c.update;
  u.rows = static_cast<int>(r.number());
  u.observed = static_cast<int>(r.number());
  u.H.setZero(3, size_);
  for (auto count = static_cast<int>(r.number()); count > 0; --count) {
    const auto k = static_cast<Eigen::Index>(r.number());
    r.take(u.H.col(k));
  }
  u.PHt.resize(size_, 3);
  r.take(u.PHt);
  for (Matrix3d* m : {&u.S, &u.R}) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i <= j; ++i) (*m)(i, j) = (*m)(j, i) = r.number();
    }
  }
  r.take(u.residual);
  u.S_inverse = u.S.llt().solve(Matrix3d::Identity());
  if (event.other != 0) c.moved = gain(u) * u.residual;
  return c;
}

void History::add_taken_back(const ScaleScore& score, const ErrorVector& moved) {
  add(Kind::kTakenBack);
  put(now_.values, score);
  put(now_.values, moved);
}

History::TakenBack History::taken_back(const Chunk& chunk, const Event& event) const {
  Reader r(chunk, event.at);
  TakenBack t;
  r.take(t.score);
  t.moved = r.vector(size_);
  return t;
}

void History::add_admitted(const Variances& variances) {
  add(Kind::kAdmitted);
  put(now_.values, variances);
}

History::Variances History::admitted(const Chunk& chunk, const Event& event) const {
  Variances v;
  Reader(chunk, event.at).take(v);
  return v;
}

void History::add_moved(const ErrorVector& moved) {
  add(Kind::kMoved);
  put(now_.values, moved);
}

ErrorVector History::moved(const Chunk& chunk, const Event& event) const {
  return Reader(chunk, event.at).vector(size_);
}

void History::end_row(const FilterState& state) {
  add(Kind::kRow);
  ++rows_;
  if (state.time - now_.time < kChunk - kSameInstant) return;
  close();
  open(state);
}

void History::finish(const FilterState& state) {
  if (!now_.events.empty()) {
    close();
    open(state);
  }
  close();
}

Covariance History::covariance(const Chunk& chunk) const {
  Covariance P(size_, size_);
  const double* p = chunk.values.data();
  for (int j = 0; j < size_; ++j) {
    for (int i = 0; i <= j; ++i) P(i, j) = P(j, i) = *p++;
  }
  return P;
}

ErrorVector History::mean(const Chunk& chunk) const {
  if (!reference_) return ErrorVector::Zero(size_);
  return Reader(chunk, packed(size_)).vector(size_);
}

}  // namespace piste
