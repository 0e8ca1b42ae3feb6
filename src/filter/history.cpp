#include "filter/history.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <span>

#include "core/stored_estimate.h"
#include "core/time_search.h"
#include "filter/kalman_filter.h"
#include "walker/fix_queue.h"

namespace piste {
namespace {

constexpr double kChunk = 1;  // s: a smoother filters covariances again over it; they are a tenth of what is stored

// Reads values in the order in which they were stored.
class Reader {
 public:
  Reader(const History::Chunk& chunk, std::size_t at) : p_(chunk.values.data() + at) {}
  double number() { return *p_++; }
  template <class Values>
  void take(Values&& values) {
    p_ = take_values(p_, values);
  }
  ErrorVector vector(int size) {
    ErrorVector v(size);
    take(v);
    return v;
  }

 private:
  const double* p_;
};

}  // namespace

void History::begin(const KalmanFilter& filter, double own_rows_until) {
  clear();
  layout_ = filter.layout();
  options_ = filter.options();
  considered_ = Considered(options_, layout_);
  earth_rate_ = filter.world().earth_rate();
  fixed_ = filter.estimate();
  reference_ = filter.has_reference();
  own_rows_until_ = own_rows_until;
  open(filter.state());
}

void History::open(const FilterState& state) {
  now_.first = rows_;
  now_.events.clear();
  now_.values.clear();
  opened_ = state.time;
  constants_ = 0;
  StoredEstimate(layout_).put_constants(state.x, now_.values);
  put_row(state);
  for (int j = 0; j < layout_.size(); ++j) put_values(now_.values, state.P.col(j).head(j + 1));
  if (reference_) put_values(now_.values, state.mean);
}

void History::close() {
  const std::size_t events = scratch_.add(std::span<const Event>(now_.events));
  places_.push_back({now_.first, events, scratch_.add(std::span<const double>(now_.values))});
}

void History::load(std::size_t number, Chunk& chunk) const {
  const Place& place = places_[number];
  chunk.first = place.first;
  scratch_.read(place.events, chunk.events);
  scratch_.read(place.values, chunk.values);
}

// Stores an index to the last written constants, and the row.
void History::put_row(const FilterState& state) {
  now_.values.push_back(static_cast<double>(constants_));
  now_.values.push_back(state.time);
  StoredEstimate(layout_).put_row(state.x, now_.values);
}

double History::take_row(const Chunk& chunk, const double*& p, Estimate& x) const {
  const StoredEstimate stored(layout_);
  stored.take_constants(chunk.values.data() + static_cast<std::size_t>(*p++), x);
  const double time = *p++;
  p = stored.take_row(p, x);
  return time;
}

FilterState History::start(const Chunk& chunk) const {
  const int n = layout_.size();
  FilterState state{0, fixed_, Covariance(n, n), ErrorVector::Zero(n)};
  const double* p = StoredEstimate(layout_).take_constants(chunk.values.data(), state.x);
  state.time = take_row(chunk, p, state.x);
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i <= j; ++i) state.P(i, j) = state.P(j, i) = *p++;
  }
  if (reference_) state.mean = Eigen::Map<const Eigen::VectorXd>(p, n);
  return state;
}

void History::add(Kind kind, std::uint32_t other) {
  now_.events.push_back({kind, static_cast<std::uint32_t>(now_.values.size()), other});
}

// Stores the scales of a step only if they have changed, otherwise an index to the last written ones.
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
    put_values(now_.values, s.gyro_scale);
    put_values(now_.values, s.accel_scale);
  }
  add(Kind::kStep, static_cast<std::uint32_t>(around_.size() - 1));
  now_.values.push_back(scales);
  now_.values.push_back(s.dt);
  put_values(now_.values, s.q_wb.coeffs());
  for (const Vector3d* v : {&s.v_wb, &s.rate, &s.force}) put_values(now_.values, *v);
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

void History::add_correction(const Update& u) { add_update(u, false); }

void History::add_correction(const Update& u, const ResetJacobian& /*reset*/, const Estimate& x,
                             const std::optional<Standing>& standing) {
  add_update(u, true);
  std::vector<double>& out = now_.values;
  put_values(out, x.q_wb.coeffs());
  put_values(out, x.v_wb);
  put_values(out, x.lever_arm);
  out.push_back(standing ? 1 : 0);
  if (!standing) return;
  put_values(out, standing->down);
  put_values(out, standing->last_q_wb.coeffs());
}

// Stores only the nonzero columns of H: a fix depends on few blocks.
void History::add_update(const Update& u, bool moves) {
  add(Kind::kCorrection, moves);
  std::vector<double>& out = now_.values;
  out.push_back(u.rows);
  out.push_back(u.observed);
  const std::size_t count = out.size();
  out.push_back(0);
  for (int k = 0; k < layout_.size(); ++k) {
    if (u.H.col(k).isZero(0)) continue;
    out[count] += 1;
    out.push_back(k);
    put_values(out, u.H.col(k));
  }
  put_values(out, u.PHt);
  for (const Matrix3d* m : {&u.S, &u.R}) {
    for (int j = 0; j < 3; ++j) put_values(out, m->col(j).head(j + 1));
  }
  put_values(out, u.residual);
}

History::Correction History::correction(const Chunk& chunk, const Event& event) const {
  Reader r(chunk, event.at);
  Correction c;
  Update& u = c.update;
  u.rows = static_cast<int>(r.number());
  u.observed = static_cast<int>(r.number());
  u.H.setZero(3, layout_.size());
  for (auto count = static_cast<int>(r.number()); count > 0; --count) {
    const auto k = static_cast<Eigen::Index>(r.number());
    r.take(u.H.col(k));
  }
  u.PHt.resize(layout_.size(), 3);
  r.take(u.PHt);
  for (Matrix3d* m : {&u.S, &u.R}) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i <= j; ++i) (*m)(i, j) = (*m)(j, i) = r.number();
    }
  }
  r.take(u.residual);
  u.S_inverse = inverse_of_definite(u.S);
  if (event.other != 0) {
    c.moved = considered_.correction(u);
    Estimate x;
    r.take(x.q_wb.coeffs());
    r.take(x.v_wb);
    r.take(x.lever_arm);
    std::optional<Standing> standing;
    if (r.number() != 0) {
      standing.emplace();
      r.take(standing->down);
      r.take(standing->last_q_wb.coeffs());
    }
    c.reset = transport_jacobian(x, layout_, c.moved, standing);
  }
  return c;
}

void History::add_score_correction(const ScaleScore& score, const ErrorVector& moved, bool estimate_moved) {
  add(Kind::kScore, estimate_moved);
  put_values(now_.values, score);
  put_values(now_.values, moved);
}

History::ScoreCorrection History::score_correction(const Chunk& chunk, const Event& event) const {
  Reader r(chunk, event.at);
  ScoreCorrection t;
  r.take(t.score);
  t.moved = r.vector(layout_.size());
  t.estimate_moved = event.other != 0;
  return t;
}

void History::add_inflation(const ErrorVector& variances) {
  add(Kind::kInflated);
  put_values(now_.values, variances);
}

ErrorVector History::inflated(const Chunk& chunk, const Event& event) const {
  return Reader(chunk, event.at).vector(layout_.size());
}

// About a reference constants do not move, and are not stored.
void History::add_moved(const ErrorVector& moved) {
  const auto still = [&](Block b) { return changes(b) || moved.segment(layout_.offset(b), info(b).size).isZero(0); };
  const bool all = !std::all_of(layout_.blocks().begin(), layout_.blocks().end(), still);
  add(Kind::kMoved, all);
  for (const Block b : layout_.blocks()) {
    if (all || changes(b)) put_values(now_.values, moved.segment(layout_.offset(b), info(b).size));
  }
}

ErrorVector History::moved(const Chunk& chunk, const Event& event) const {
  Reader r(chunk, event.at);
  ErrorVector moved = ErrorVector::Zero(layout_.size());
  for (const Block b : layout_.blocks()) {
    if (event.other != 0 || changes(b)) r.take(moved.segment(layout_.offset(b), info(b).size));
  }
  return moved;
}

void History::end_row(const FilterState& state) {
  const bool own = state.time <= own_rows_until_ + kSameInstant;
  add(Kind::kRow, own);
  if (own) {
    note_constants(state);
    now_.events.back().at = static_cast<std::uint32_t>(now_.values.size());
    put_row(state);
  }
  ++rows_;
  if (state.time - opened_ < kChunk - kSameInstant) return;
  close();
  open(state);
}

// Writes the constants only if they have changed.
void History::note_constants(const FilterState& state) {
  const std::size_t before = now_.values.size();
  StoredEstimate(layout_).put_constants(state.x, now_.values);
  const auto at = [&](std::size_t place) { return now_.values.begin() + static_cast<std::ptrdiff_t>(place); };
  if (std::equal(at(before), now_.values.end(), at(constants_))) {
    now_.values.resize(before);
  } else {
    constants_ = before;
  }
}

void History::finish(const FilterState& state) {
  if (!now_.events.empty()) {
    close();
    open(state);
  }
  close();
}

}  // namespace piste
