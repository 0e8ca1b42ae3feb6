#include "piste/model/measurement_list.h"

#include <fmt/format.h>

#include <algorithm>

namespace piste {
namespace {

// Whether `source` is the name of this channel, of any sensor.
bool is_named(std::string_view source, std::string_view type, std::string_view channel) {
  if (!source.starts_with(type)) return false;
  source.remove_prefix(type.size());
  if (source.starts_with('[')) source.remove_prefix(std::min(source.find(']'), source.size() - 1) + 1);
  if (channel.empty()) return source.empty();
  return source.starts_with('.') && source.substr(1) == channel;
}

}  // namespace

std::array<std::string_view, 3> innovation_axes(std::string_view source) {
  std::array<std::string_view, 3> axes = MeasurementChannel{}.axes;
  MeasurementList::for_each([&]<class Type>() {
    for (const MeasurementChannel& channel : Type::kChannels) {
      if (is_named(source, Type::kName, channel.name)) axes = channel.axes;
    }
  });
  return axes;
}

MeasurementSources::MeasurementSources(const FilterOptions& options) {
  MeasurementList::for_each([&]<class Type>() {
    first_[MeasurementList::index_of<Type>()] = static_cast<int>(all_.size());
    for (int sensor = 0; sensor < Type::sensors(options); ++sensor) {
      const int first = static_cast<int>(all_.size());
      const std::string name = Type::kNumbered ? fmt::format("{}[{}]", Type::kName, sensor) : std::string(Type::kName);
      for (const MeasurementChannel& channel : Type::kChannels) {
        all_.push_back({.name = channel.name.empty() ? name : fmt::format("{}.{}", name, channel.name),
                        .partner = channel.partner < 0 ? -1 : first + channel.partner,
                        .readmitted = channel.readmitted,
                        .hold = channel.hold,
                        .adapted = Type::kAdapted && Type::in_use(options)});
      }
    }
  });
}

void MeasurementSources::find_delays(const FilterOptions& options, const StateLayout& layout, const Estimate& x,
                                     double elapsed, std::span<double> delays) const {
  MeasurementList::for_each([&]<class Type>() {
    for (int sensor = 0; sensor < Type::sensors(options); ++sensor) {
      for (int channel = 0; channel < static_cast<int>(Type::kChannels.size()); ++channel) {
        const int source = first<Type>(sensor) + channel;
        delays[static_cast<std::size_t>(source)] = Type::delay(options, layout, sensor, channel, x, elapsed).value;
      }
    }
  });
}

std::vector<std::string> MeasurementSources::names() const {
  std::vector<std::string> out;
  out.reserve(all_.size());
  for (const MeasurementSource& source : all_) out.push_back(source.name);
  return out;
}

}  // namespace piste
