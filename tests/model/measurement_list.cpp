// The one list of measurements: sources, their names and their places.

#include "piste/model/measurement_list.h"

#include <gtest/gtest.h>

#include <set>

namespace piste {
namespace {

FilterOptions options(std::size_t receivers, std::size_t references) {
  FilterOptions o;
  o.gnss.resize(receivers);
  o.attitude.resize(references);
  return o;
}

TEST(MeasurementSources, StandInTheOrderOfTheList) {
  const std::vector<std::string> expected{"gnss[0].position", "gnss[0].velocity", "gnss[1].position",
                                          "gnss[1].velocity", "attitude[0]",      "rest.velocity",
                                          "rest.rate"};
  EXPECT_EQ(MeasurementSources(options(2, 1)).names(), expected);
}

// Whatever there is of each type: every sensor and channel has a place of its own, whose name says which it is.
TEST(MeasurementSources, EveryChannelHasItsPlace) {
  for (std::size_t receivers : {0, 1, 3}) {
    for (std::size_t references : {0, 2}) {
      const FilterOptions o = options(receivers, references);
      const MeasurementSources sources(o);
      std::set<int> places;
      MeasurementList::for_each([&]<class Type>() {
        for (int sensor = 0; sensor < Type::sensors(o); ++sensor) {
          for (std::size_t c = 0; c < Type::kChannels.size(); ++c) {
            const int place = sources.first<Type>(sensor) + static_cast<int>(c);
            ASSERT_LT(static_cast<std::size_t>(place), sources.all().size());
            EXPECT_TRUE(places.insert(place).second);
            const MeasurementSource& source = sources.all()[static_cast<std::size_t>(place)];
            EXPECT_TRUE(source.name.starts_with(Type::kName)) << source.name;
            EXPECT_TRUE(source.name.ends_with(Type::kChannels[c].name)) << source.name;
            EXPECT_EQ(source.readmitted, Type::kChannels[c].readmitted) << source.name;
            if (source.partner < 0) continue;
            const MeasurementSource& partner = sources.all()[static_cast<std::size_t>(source.partner)];
            EXPECT_EQ(partner.partner, place) << "partners of each other";
            EXPECT_EQ(partner.name.substr(0, partner.name.find('.')), source.name.substr(0, source.name.find('.')));
          }
        }
      });
      EXPECT_EQ(places.size(), sources.all().size());
    }
  }
}

TEST(MeasurementSources, RowsHaveTheirNames) {
  using Axes = std::array<std::string_view, 3>;
  EXPECT_EQ(innovation_axes("gnss[12].position"), (Axes{"north", "east", "down"}));
  EXPECT_EQ(innovation_axes("rest.velocity"), (Axes{"north", "east", "down"}));
  EXPECT_EQ(innovation_axes("rest.rate"), (Axes{"x", "y", "z"}));
  EXPECT_EQ(innovation_axes("magnetometer"), (Axes{"x", "y", "z"}));
  EXPECT_EQ(innovation_axes("parity[0].gyro"), (Axes{"x", "y", "z"}));
  EXPECT_EQ(innovation_axes("vehicle.right"), (Axes{"right"}));
  EXPECT_EQ(innovation_axes("barometer"), (Axes{"height"}));
  EXPECT_EQ(innovation_axes("heading"), (Axes{"heading", "pitch"}));
}

TEST(MeasurementList, AFixIsSeenByItsOwnTypeAlone) {
  int seen = 0;
  MeasurementList::visit(
      [&]<class Type>(const typename Type::Fix& fix) {
        ++seen;
        EXPECT_TRUE((std::is_same_v<Type, Magnetometer>));
        EXPECT_EQ(fix.time, 3);
      },
      MagneticSample{.time = 3, .field = Vector3d::Zero()});
  EXPECT_EQ(seen, 1);
}

}  // namespace
}  // namespace piste
