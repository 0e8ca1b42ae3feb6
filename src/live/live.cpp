#include "piste/live/live.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "condition/clipping.h"
#include "core/fix_faults.h"
#include "core/time_search.h"
#include "filter/feeder.h"
#include "piste/core/error.h"
#include "start/heading_search.h"
#include "start/start_motion.h"

namespace piste {
namespace {

// Bit i is set where axis i is at the range; a range of 0 is not known.
std::uint8_t at_range(const Vector3d& value, double range) {
  std::uint8_t bits = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (range > 0 && std::abs(value(axis)) >= kAtRange * range) bits = static_cast<std::uint8_t>(bits | 1U << axis);
  }
  return bits;
}

template <class Timed>
void forget(std::vector<Timed>& fixes, double before) {
  fixes.erase(fixes.begin(), first_at_or_after(fixes, before));
}

}  // namespace

class Live::Session {
 public:
  explicit Session(LiveOptions options) : options_(std::move(options)) {
    options_.filter.validate();
    if (options_.filter.vehicle && !options_.filter.vehicle->mounting) {
      throw ConfigError("vehicle",
                        "`mounting: auto` looks ahead in a log; state it for a session, such as `0 0 0 deg`");
    }
    options_.conditioning.span = {};
    options_.conditioning.outages.clear();
    clock_ = std::exchange(options_.conditioning.imu, {});
    options_.conditioning.imu.R_bs = clock_.R_bs;
    options_.conditioning.imu.instantaneous = clock_.instantaneous;
    recent_.imu.file = "imu";
    recent_.gnss.resize(options_.filter.gnss.size());
    levels_.resize(recent_.gnss.size());
    given_.assign(recent_.gnss.size(), -1e300);
    for (std::size_t i = 0; i < recent_.gnss.size(); ++i) recent_.gnss[i].file = options_.filter.gnss[i].name;
  }

  void add(const ImuRow& row) {
    if (!(row.time > last_)) {
      throw DataError("imu",
                      fmt::format("time {:.6f} s does not increase, the row before is at {:.6f} s", row.time, last_));
    }
    if (!std::isfinite(row.time) || !row.gyro.allFinite() || !row.accel.allFinite()) {
      throw DataError("imu",
                      fmt::format("the row at {:.6f} s must be finite; leave out rows without a value", row.time));
    }
    if (recent_.imu.time.empty()) {
      first_ = row.time;
      options_.filter.clock_from = first_ - clock_.clock_offset;
    }
    last_ = row.time;
    recent_.imu.time.push_back(row.time - clock_.clock_offset - clock_.clock_drift * (row.time - first_));
    recent_.imu.gyro.push_back(row.gyro);
    recent_.imu.accel.push_back(row.accel);
    if (row.time < next_pass_) return;
    next_pass_ = row.time + options_.pass_interval;
    pass();
  }

  void add(int receiver, const GeodeticFix& fix) {
    if (receiver < 0 || static_cast<std::size_t>(receiver) >= recent_.gnss.size()) {
      throw DataError("gnss", fmt::format("there is no receiver {}; the options have {}, the first of which is 0",
                                          receiver, recent_.gnss.size()));
    }
    auto& fixes = recent_.gnss[static_cast<std::size_t>(receiver)].fixes;
    if (const std::string fault = fault_of(fix); !fault.empty()) {
      throw DataError(
          fmt::format("{}: t = {:.3f} s", options_.filter.gnss[static_cast<std::size_t>(receiver)].name, fix.time),
          fault);
    }
    const auto later = [](double t, const GeodeticFix& f) { return t < f.time; };
    const auto place = fixes.insert(std::upper_bound(fixes.begin(), fixes.end(), fix.time, later), fix);
    SlowLevel& level = levels_[static_cast<std::size_t>(receiver)];
    place->slow_level = level.next(fix.time, fix.sigma_position);
    place->slow_change = level.take_change();
    if (fix.time <= given_.at(static_cast<std::size_t>(receiver))) ++late_;
    if (!world_) world_ = World(fix.position);
  }

  std::optional<LiveState> state() const {
    if (filter_) return of(*filter_, std::nullopt);
    if (search_) return of(search_->best(), search_->heading());
    return std::nullopt;
  }

  std::optional<LiveState> now() const {
    if (!filter_ && !search_) return std::nullopt;
    Filter ahead = filter_ ? *filter_ : search_->best();
    std::vector<double> given = given_;
    feed(ahead, given, newest_);
    feed_new_rows(ahead);
    ahead.finish();
    return of(ahead, filter_ ? std::nullopt : std::optional(search_->heading()));
  }

  const Filter* filter() const { return filter_ ? &*filter_ : nullptr; }
  std::size_t late() const { return late_ + (filter_ ? filter_->late() : 0); }

 private:
  // Conditions the stored rows and fixes, and feeds the filter those older than the lag.
  void pass() {
    if (!filter_ && !search_) forget_rows();  // a receiver may take an hour to its first fix
    if (!world_ || recent_.imu.time.size() < 3) return;
    log_ = condition(recent_, options_.conditioning, *world_);
    newest_ = log_.imu.back().time;
    period_ = (newest_ - log_.imu.front().time) / static_cast<double>(log_.imu.size() - 1);
    const double until = newest_ - options_.lag;
    if (!filter_ && !search_) begin(until);
    if (filter_) {
      fed_ = feed(*filter_, given_, until);
      filter_->clear_innovations();
    } else if (search_) {
      fed_ = feed(*search_, given_, until);
      if (search_->resolved()) settle(until);
    } else {
      return;
    }
    if (forget_rows()) {
      for (GnssRecording& receiver : recent_.gnss) forget(receiver.fixes, log_.imu.front().time);
    }
  }

  // Starts once fixes of `reach` seconds are there.
  void begin(double until) {
    const auto fixes = std::find_if(log_.gnss.begin(), log_.gnss.end(), [](const auto& f) { return !f.empty(); });
    if (fixes == log_.gnss.end() || until - fixes->front().time < options_.filter.behaviour.start.reach) return;
    if (options_.heading.source != InitialHeading::Source::kAuto) {
      const Start start = find_start(log_, options_.filter, options_.heading).start;
      filter_.emplace(options_.filter, log_.world, start);
      begin_at(start.time);
      return;
    }
    const Receiver receiver = first_receiver(log_, options_.filter);
    const std::vector<Start> starts = heading_hypotheses(
        log_, options_.filter, receiver, beginning(log_, receiver, options_.filter.behaviour.start).time);
    search_.emplace(options_.filter, log_.world, starts);
    begin_at(starts.front().time);
    begun_ = fed_;
  }

  // Takes the filter of the heading that is left. Its data so far were linearised about a heading up to 15 deg off. If
  // all of them are still in memory, they are filtered once more from a start with the right heading, as in a replay.
  void settle(double until) {
    filter_ = search_->best();
    search_.reset();
    if (begun_ < log_.imu.front().time - log_.imu.front().interval - 2 * kSameInstant) return;
    std::optional<Start> start;
    try {
      start = find_start(log_, options_.filter, options_.heading).start;
    } catch (const DataError&) {
      return;  // so little motion that a second search does not resolve it
    }
    filter_.emplace(options_.filter, log_.world, *start);
    begin_at(start->time);
    fed_ = feed(*filter_, given_, until);
    filter_->clear_innovations();
  }

  void begin_at(double time) {
    fed_ = time - 2 * kSameInstant;
    given_.assign(given_.size(), fed_);
  }

  // Feeds the samples after those already fed, up to `until`, and returns the time of the last. `given` holds the time
  // of each receiver's last fix. A sample of which a part was fed already is cut: the period in a gap may have been
  // estimated anew.
  template <class Sink>
  double feed(Sink& sink, std::vector<double>& given, double until) const {
    LogPlace place = place_at(log_, fed_, {.end = std::nextafter(until, 1e300)});
    for (std::size_t i = 0; i < given.size(); ++i) {
      const auto& fixes = log_.gnss[i];
      place.fixes[i] = static_cast<std::size_t>(first_at_or_after(fixes, given[i] + kSameInstant) - fixes.begin());
    }
    Feeder feeder(log_, place, sink, fed_);
    while (!feeder.done()) feeder.step();
    for (std::size_t i = 0; i < given.size(); ++i) {
      const std::size_t next = feeder.place().fixes[i];
      if (next > place.fixes[i]) given[i] = log_.gnss[i][next - 1].time;
    }
    const std::size_t next = feeder.place().imu;
    return next > place.imu ? log_.imu[next - 1].time : fed_;
  }

  // Feeds the rows since the last pass, which are not conditioned yet. None counts as standstill, which is detected
  // only after a second. A single wrong row is interpolated from the next pass on.
  void feed_new_rows(Filter& ahead) const {
    const ImuRecording& imu = recent_.imu;
    const ConditioningOptions& options = options_.conditioning;
    const GapOptions& gaps = options.behaviour.gaps;
    const auto first = std::upper_bound(imu.time.begin(), imu.time.end(), newest_ + kSameInstant) - imu.time.begin();
    for (auto i = static_cast<std::size_t>(first); i < imu.time.size(); ++i) {
      const double lapse = imu.time[i] - imu.time[i - 1];
      const Vector3d gyro = options.imu.R_bs * imu.gyro[i], accel = options.imu.R_bs * imu.accel[i];
      const Vector3d mean_gyro = options.imu.R_bs * (imu.gyro[i - 1] + imu.gyro[i]) / 2,
                     mean_accel = options.imu.R_bs * (imu.accel[i - 1] + imu.accel[i]) / 2;
      const bool gap = lapse > gaps.long_interval * period_;
      // A gap has the means of its adjoining rows, and the full noise of unmeasured motion.
      const double missing = !gap ? 0 : options.imu.instantaneous ? lapse : lapse - period_;
      if (missing > 0) {
        ahead.add({.time = imu.time[i - 1] + missing,
                   .interval = missing,
                   .dtheta = missing * mean_gyro,
                   .dvel = missing * mean_accel,
                   .gap = gaps.unknown});
      }
      const double interval = lapse - missing;
      if (!(interval > kSameInstant)) continue;
      ahead.add({.time = imu.time[i],
                 .interval = interval,
                 .dtheta = interval * (options.imu.instantaneous ? mean_gyro : gyro),
                 .dvel = interval * (options.imu.instantaneous ? mean_accel : accel),
                 .clipped_gyro = at_range(gyro, options.gyro_range),
                 .clipped_accel = at_range(accel, options.accel_range)});
    }
  }

  // Discards rows older than the memory; returns whether there were any.
  bool forget_rows() {
    ImuRecording& imu = recent_.imu;
    const double before = imu.time.back() - options_.memory;
    // In larger parts, so that rows are not moved at each pass.
    if (imu.time.front() > before - options_.memory / 4) return false;
    const auto rows = std::lower_bound(imu.time.begin(), imu.time.end(), before) - imu.time.begin();
    imu.time.erase(imu.time.begin(), imu.time.begin() + rows);
    imu.gyro.erase(imu.gyro.begin(), imu.gyro.begin() + rows);
    imu.accel.erase(imu.accel.begin(), imu.accel.begin() + rows);
    return true;
  }

  LiveState of(const Filter& filter, const std::optional<HeadingEstimate>& heading) const {
    const Estimate& x = filter.estimate();
    const Navigation here = navigation_of(log_.world, x);
    LiveState s{.time = filter.time(),
                .position = here.position,
                .velocity = here.velocity,
                .euler = here.euler,
                .sigmas = sigmas_of(log_.world, x, filter.layout(), filter.covariance()),
                .heading_known = !heading};
    if (heading) s.sigmas.euler.z() = heading->sigma;
    return s;
  }

  LiveOptions options_;
  Recording recent_;
  std::vector<SlowLevel> levels_;  // of each receiver
  Log log_;
  std::optional<World> world_;
  std::optional<HeadingSearch> search_;
  std::optional<Filter> filter_;
  ImuConditioning clock_;
  double first_ = 0, last_ = -1e300;  // of the rows, in their own clock
  double next_pass_ = -1e300, fed_ = -1e300, begun_ = -1e300, newest_ = -1e300;
  double period_ = 0;          // of the rows
  std::vector<double> given_;  // time of each receiver's last fix in the filter
  std::size_t late_ = 0;
};

Live::Live(LiveOptions options) : session_(std::make_unique<Session>(std::move(options))) {}
Live::~Live() = default;
Live::Live(Live&&) noexcept = default;
Live& Live::operator=(Live&&) noexcept = default;

void Live::add(const ImuRow& row) { session_->add(row); }
void Live::add(int receiver, const GeodeticFix& fix) { session_->add(receiver, fix); }
std::optional<LiveState> Live::state() const { return session_->state(); }
std::optional<LiveState> Live::now() const { return session_->now(); }
const Filter* Live::filter() const { return session_->filter(); }
std::size_t Live::late() const { return session_->late(); }

}  // namespace piste
