#pragma once
/// The one list of measurement types. Filter, smoother, fault detection, innovations and files read it. A new sensor is
/// a type of its own (measurement.h says what it must have) and an entry in `MeasurementList`.

#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "piste/model/attitude.h"
#include "piste/model/dual_heading.h"
#include "piste/model/gnss.h"
#include "piste/model/height.h"
#include "piste/model/imu_parity.h"
#include "piste/model/magnetometer.h"
#include "piste/model/rest.h"
#include "piste/model/vehicle.h"

namespace piste {

/// A list of measurement types, and how to go through it.
template <class... Types>
struct TypeList {
  using Fix = std::variant<typename Types::Fix...>;
  static constexpr std::size_t kSize = sizeof...(Types);

  /// Calls `f.operator()<Type>()` for each, in order.
  template <class F>
  static void for_each(F&& f) {
    (f.template operator()<Types>(), ...);
  }
  template <class Type>
  static constexpr std::size_t index_of() {
    std::size_t index = 0;
    bool found = false;
    ((found = found || std::is_same_v<Type, Types>, index += found ? 0 : 1), ...);
    return index;
  }
  /// Calls `f.operator()<Type>(fix)` with the type of the fix.
  template <class F>
  static void visit(F&& f, const Fix& fix) {
    (void)((std::holds_alternative<typename Types::Fix>(fix)
                ? (f.template operator()<Types>(std::get<typename Types::Fix>(fix)), true)
                : false) ||
           ...);
  }
};

/// All types, in the order in which fixes with the same time are used.
using MeasurementList = TypeList<GnssReceivers, ReferenceAttitudes, Magnetometer, ZeroUpdates, VehicleConstraint,
                                 Odometer, Barometer, DualHeading, ImuParity>;

/// A fix of any type.
using AnyFix = MeasurementList::Fix;

/// One channel of one sensor. Every innovation belongs to a source.
struct MeasurementSource {
  std::string name;  ///< such as "gnss[0].position", "attitude[1]", "rest.rate"
  int partner = -1;  ///< index of another source, or −1; see MeasurementChannel
  bool readmitted = true;
  double hold = 0;
  bool adapted = true;
};

/// The axes of the rows of a source's innovations, by its name in files: MeasurementChannel::axes. For an unknown name
/// they are north, east, down.
std::array<std::string_view, 3> innovation_axes(std::string_view source);

/// The sources of a run: type by type in the order of the list, sensor by sensor, channel by channel.
class MeasurementSources {
 public:
  MeasurementSources() = default;
  explicit MeasurementSources(const FilterOptions& options);

  const std::vector<MeasurementSource>& all() const { return all_; }
  std::vector<std::string> names() const;
  /// Index of a sensor's first channel. Its other channels follow.
  template <class Type>
  int first(int sensor) const {
    return first_[MeasurementList::index_of<Type>()] + sensor * static_cast<int>(Type::kChannels.size());
  }
  /// Sets the delay of each source by the estimate `x` [s]. `elapsed`: s since the drift of the IMU's clock counts.
  /// @pre `delays` has a place for each source
  void find_delays(const FilterOptions& options, const StateLayout& layout, const Estimate& x, double elapsed,
                   std::span<double> delays) const;

 private:
  std::vector<MeasurementSource> all_;
  std::array<int, MeasurementList::kSize> first_{};
};

}  // namespace piste
