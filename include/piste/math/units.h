#pragma once
/// Converts numbers with units, as data sheets write them, into SI and radians and back, and checks the dimension.
///
/// A unit is a product of base units, such as `deg/s/sqrt(Hz)`, `m/s^2`, `ug/sqrt(Hz)`, `deg*s^-1`. A `/` divides only
/// by the factor that follows it. A blank multiplies, `m s^-2`, and so do a point, `m.s^-2`, and a number, `1e-7 deg`.
/// The spellings of headers are known as well: `m/s²`, `m/s2`, `m/(s^2)`, `°/s`, `dps`, `µT`. `G` is a g for
/// accelerations, and a gauss for magnetic fields. Angle is a dimension of its own, so that `m` and `rad` cannot be
/// confused.

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <span>
#include <string>
#include <string_view>

namespace piste {

/// One degree in radians, and one radian in degrees.
inline constexpr double kDegree = std::numbers::pi / 180, kDegreesPerRadian = 180 / std::numbers::pi;
inline constexpr double kMillisecondsPerSecond = 1e3;

/// The dimension of a number: the exponents of its base dimensions times two (√Hz has half exponents), and for error
/// messages a name and an example.
struct Dimension {
  std::array<int, 5> half_exponents;  ///< of angle, length, time, temperature, magnetic flux density
  std::string_view name, example;
  bool operator==(const Dimension& other) const { return half_exponents == other.half_exponents; }
};

namespace dimension {
inline constexpr Dimension kRatio{{0, 0, 0, 0, 0}, "a ratio", "1000 ppm"};
inline constexpr Dimension kAngle{{2, 0, 0, 0, 0}, "an angle", "1.5 deg"};
inline constexpr Dimension kLength{{0, 2, 0, 0, 0}, "a length", "0.4 m"};
inline constexpr Dimension kArea{{0, 4, 0, 0, 0}, "an area", "0.04 m^2"};
inline constexpr Dimension kTime{{0, 0, 2, 0, 0}, "a time", "60 s"};
inline constexpr Dimension kFrequency{{0, 0, -2, 0, 0}, "a frequency", "12 Hz"};
inline constexpr Dimension kVelocity{{0, 2, -2, 0, 0}, "a velocity", "0.05 m/s"};
inline constexpr Dimension kAcceleration{{0, 2, -4, 0, 0}, "an acceleration", "0.05 m/s^2"};
inline constexpr Dimension kAngularRate{{2, 0, -2, 0, 0}, "an angular rate", "0.5 deg/s"};
inline constexpr Dimension kAngularAcceleration{{2, 0, -4, 0, 0}, "an angular acceleration", "20 deg/s^2"};
inline constexpr Dimension kGyroNoise{{2, 0, -1, 0, 0}, "an angular-rate noise density", "0.05 deg/s/sqrt(Hz)"};
inline constexpr Dimension kAccelNoise{{0, 2, -3, 0, 0}, "an acceleration noise density", "200 ug/sqrt(Hz)"};
inline constexpr Dimension kGyroDrift{{2, 0, -3, 0, 0}, "a random walk of angular rate", "4e-5 deg/s^2/sqrt(Hz)"};
inline constexpr Dimension kAccelDrift{{0, 2, -5, 0, 0}, "a random walk of acceleration", "4e-5 m/s^3/sqrt(Hz)"};
inline constexpr Dimension kGSensitivity{{2, -2, 2, 0, 0}, "an angular rate by acceleration", "0.1 deg/s/g"};
inline constexpr Dimension kTemperature{{0, 0, 0, 2, 0}, "a temperature", "21 degC"};
inline constexpr Dimension kMagneticField{{0, 0, 0, 0, 2}, "a magnetic flux density", "48 uT"};
inline constexpr Dimension kGyroTemperature{{2, 0, -2, -2, 0}, "an angular rate by temperature", "0.01 deg/s/degC"};
inline constexpr Dimension kAccelTemperature{{0, 2, -4, -2, 0}, "an acceleration by temperature", "0.002 m/s^2/degC"};
}  // namespace dimension

/// Factor that turns a number in `unit` into SI and radians (`degC` stays, `uT` becomes T). Empty is dimensionless.
/// Throws std::invalid_argument where a unit is unknown, or measures something else than `expected`.
double unit_factor(std::string_view unit, const Dimension& expected);

/// Whether a text is a unit of this dimension.
bool measures(std::string_view unit, const Dimension& dimension);

/// One number and its unit, such as `0.05 deg/s/sqrt(Hz)`, in SI and radians. Only a ratio needs no unit.
/// Throws std::invalid_argument that says what would be right.
double parse_quantity(std::string_view text, const Dimension& expected);

/// Three numbers and one unit, such as `-0.06 0.03 -0.42 m`, in SI and radians. Throws as parse_quantity.
Eigen::Vector3d parse_vector(std::string_view text, const Dimension& expected);

/// `value`, in SI and radians, as text in `unit`, with the fewest digits that read back as the same number. If rounding
/// allows no such text, it has 17 digits, and reads back as a neighbouring number.
std::string format_quantity(double value, std::string_view unit, const Dimension& expected);

}  // namespace piste
