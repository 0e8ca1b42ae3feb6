// `Filter` of the installed headers: holds a KalmanFilter in place, so that its parts need not be installed.

#include <memory>
#include <new>
#include <utility>

#include "filter/kalman_filter.h"
#include "piste/filter/filter.h"

namespace piste {

Filter::Filter(const FilterOptions& options, const World& world, const Start& start) {
  static_assert(sizeof(KalmanFilter) <= kSize && sizeof(KalmanFilter) > kSize / 2);
  static_assert(alignof(KalmanFilter) <= alignof(Filter));
  new (storage_.data()) KalmanFilter(options, world, start);
}
Filter::Filter(const Filter& other) { new (storage_.data()) KalmanFilter(other.kalman()); }
Filter::Filter(Filter&& other) noexcept { new (storage_.data()) KalmanFilter(std::move(other.kalman())); }
Filter& Filter::operator=(const Filter& other) {
  if (this != &other) kalman() = other.kalman();
  return *this;
}
Filter& Filter::operator=(Filter&& other) noexcept {
  kalman() = std::move(other.kalman());
  return *this;
}
Filter::~Filter() { std::destroy_at(&kalman()); }

const KalmanFilter& Filter::kalman() const {
  return *std::launder(reinterpret_cast<const KalmanFilter*>(storage_.data()));
}
KalmanFilter& Filter::kalman() { return *std::launder(reinterpret_cast<KalmanFilter*>(storage_.data())); }

bool Filter::add(const ImuSample& sample) { return kalman().add(sample); }
void Filter::add(int sensor, const AnyFix& fix) { kalman().add(sensor, fix); }
bool Filter::finish() { return kalman().finish(); }
double Filter::look_ahead() const { return kalman().look_ahead(); }
const FilterState& Filter::state() const { return kalman().state(); }
const StateLayout& Filter::layout() const { return kalman().layout(); }
const World& Filter::world() const { return kalman().world(); }
const FilterOptions& Filter::options() const { return kalman().options(); }
const std::vector<std::string>& Filter::sources() const { return kalman().sources(); }
Estimate Filter::predicted() const { return kalman().predicted(); }
std::span<const Innovation> Filter::innovations() const { return kalman().innovations(); }
void Filter::clear_innovations() { kalman().clear_innovations(); }
std::size_t Filter::late() const { return kalman().late(); }

}  // namespace piste
