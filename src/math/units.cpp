#include "piste/math/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "math/numbers.h"
#include "piste/math/earth.h"

namespace piste {
namespace {

using Exponents = std::array<int, 5>;

struct Unit {
  double factor;
  Exponents half_exponents;
};

struct NamedUnit {
  std::string_view name;
  Unit unit;
};

constexpr Exponents kNone{0, 0, 0, 0, 0}, kAngle{2, 0, 0, 0, 0}, kLength{0, 2, 0, 0, 0}, kTime{0, 0, 2, 0, 0},
    kRate{0, 0, -2, 0, 0}, kAcceleration{0, 2, -4, 0, 0}, kTemperature{0, 0, 0, 2, 0}, kField{0, 0, 0, 0, 2},
    kTurnRate{2, 0, -2, 0, 0}, kSpeed{0, 2, -2, 0, 0};
constexpr double kKnot = 1852.0 / 3600;

constexpr auto kUnits = std::to_array<NamedUnit>({
    {"rad", {1, kAngle}},
    {"mrad", {1e-3, kAngle}},
    {"deg", {kDegree, kAngle}},
    {"mdeg", {1e-3 * kDegree, kAngle}},
    {"°", {kDegree, kAngle}},
    {"arcmin", {kDegree / 60, kAngle}},
    {"arcsec", {kDegree / 3600, kAngle}},
    {"m", {1, kLength}},
    {"cm", {1e-2, kLength}},
    {"mm", {1e-3, kLength}},
    {"km", {1e3, kLength}},
    {"s", {1, kTime}},
    {"ms", {1e-3, kTime}},
    {"us", {1e-6, kTime}},
    {"ns", {1e-9, kTime}},
    {"sec", {1, kTime}},
    {"min", {60, kTime}},
    {"h", {3600, kTime}},
    {"hr", {3600, kTime}},
    {"Hz", {1, kRate}},
    {"dps", {kDegree, kTurnRate}},
    {"mdps", {1e-3 * kDegree, kTurnRate}},
    {"kn", {kKnot, kSpeed}},
    {"knots", {kKnot, kSpeed}},
    {"kph", {1 / 3.6, kSpeed}},
    {"g", {kStandardGravity, kAcceleration}},
    {"mg", {1e-3 * kStandardGravity, kAcceleration}},
    {"ug", {1e-6 * kStandardGravity, kAcceleration}},
    {"Gal", {1e-2, kAcceleration}},
    {"mGal", {1e-5, kAcceleration}},
    {"degC", {1, kTemperature}},
    {"°C", {1, kTemperature}},
    {"K", {1, kTemperature}},
    {"T", {1, kField}},
    {"mT", {1e-3, kField}},
    {"uT", {1e-6, kField}},
    {"nT", {1e-9, kField}},
    {"G", {1e-4, kField}},
    {"mG", {1e-7, kField}},
    {"%", {1e-2, kNone}},
    {"ppm", {1e-6, kNone}},
});

std::string known_units() {
  std::string list;
  for (const NamedUnit& u : kUnits) list += fmt::format("{}{}", list.empty() ? "" : " ", u.name);
  return list;
}

Unit multiply(const Unit& a, const Unit& b, int sign) {
  Unit product{sign > 0 ? a.factor * b.factor : a.factor / b.factor, a.half_exponents};
  for (std::size_t i = 0; i < b.half_exponents.size(); ++i) product.half_exponents[i] += sign * b.half_exponents[i];
  return product;
}

// The spellings of headers as those of data sheets: `m/s²` is m/s^2, `µT` is uT.
std::string plain(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kSpellings{
      {{"²", "^2"}, {"³", "^3"}, {"·", "*"}, {"µ", "u"}, {"μ", "u"}}};
  std::string result(text);
  for (const auto& [from, to] : kSpellings) {
    for (std::size_t at = result.find(from); at != std::string::npos; at = result.find(from, at + to.size())) {
      result.replace(at, from.size(), to);
    }
  }
  return result;
}

const Unit* find_unit(std::string_view name) {
  const auto* const found =
      std::find_if(kUnits.begin(), kUnits.end(), [name](const NamedUnit& u) { return u.name == name; });
  return found == kUnits.end() ? nullptr : &found->unit;
}

// unit = factor { ['*' | '.' | '/'] factor };
// factor = ('sqrt(' unit ')' | '(' unit ')' | number | name) [ ['^'] integer ]
// Headers are full of words that are no units: that is an answer, and no exception.
class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : all_(plain(text)), rest_(all_) { skip_blanks(); }

  // Nothing if the text is no unit; then fault() says why.
  std::optional<Unit> parse() {
    const std::optional<Unit> unit = product();
    if (unit && !rest_.empty()) return fail(fmt::format("`{}` is one too many", rest_));
    return unit;
  }

  std::string fault() const {
    return fmt::format("unit `{}`: {}; known are {}, joined by * / ^ and sqrt(), such as deg/s/sqrt(Hz)", all_, why_,
                       known_units());
  }

 private:
  std::nullopt_t fail(std::string why) {
    why_ = std::move(why);
    return std::nullopt;
  }

  void skip_blanks() {
    while (rest_.starts_with(' ')) rest_.remove_prefix(1);
  }

  bool take(std::string_view token) {
    if (!rest_.starts_with(token)) return false;
    rest_.remove_prefix(token.size());
    return true;
  }

  std::optional<Unit> product() {
    std::optional<Unit> unit = power();
    while (unit) {
      skip_blanks();
      const bool divided = take("/");
      if (!divided && !take("*") && !take(".") && (rest_.empty() || rest_.front() == ')' || rest_.front() == '^'))
        break;
      const std::optional<Unit> next = power();
      if (!next) return next;
      unit = multiply(*unit, *next, divided ? -1 : 1);
    }
    return unit;
  }

  std::optional<Unit> power() {
    const std::optional<Unit> base = factor();
    if (!base) return base;
    const bool raised = take("^");
    const bool digits = !rest_.empty() && (rest_.front() == '-' || (rest_.front() >= '0' && rest_.front() <= '9'));
    if (!raised && !digits) return base;
    int exponent = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), exponent);
    if (error != std::errc{} || exponent < -9 || exponent > 9) return fail("after ^ comes a small whole number");
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    Unit unit{1, kNone};
    for (int i = 0; i < std::abs(exponent); ++i) unit = multiply(unit, *base, exponent > 0 ? 1 : -1);
    return unit;
  }

  // The unit of an expression whose opening parenthesis was taken.
  std::optional<Unit> enclosed() {
    if (++depth_ > 4) return fail("too many parentheses");
    const std::optional<Unit> unit = product();
    if (unit && !take(")")) return fail("a closing parenthesis is missing");
    return unit;
  }

  std::optional<Unit> factor() {
    skip_blanks();
    if (take("sqrt(") || take("√(")) {
      std::optional<Unit> unit = enclosed();
      if (!unit) return unit;
      unit->factor = std::sqrt(unit->factor);
      for (int& e : unit->half_exponents) {
        if (e % 2 != 0) return fail("a root of a root");
        e /= 2;
      }
      return unit;
    }
    if (take("(")) return enclosed();
    double number = 0;
    const auto [end, error] = read_number(rest_.data(), rest_.data() + rest_.size(), number);
    if (error == std::errc{} && number > 0 && std::isfinite(number)) {  // such as 1e-7 deg
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
      return Unit{number, kNone};
    }
    const std::string_view word = rest_.substr(0, rest_.find_first_of("*/^(). "));
    const std::string_view name = word.substr(0, word.find_first_of("-0123456789"));  // `s2` and `s-1` are powers
    if (const Unit* unit = find_unit(name)) {
      rest_.remove_prefix(name.size());
      return *unit;
    }
    return fail(word.empty() ? "a unit is missing" : fmt::format("`{}` is unknown", word));
  }

  const std::string all_;
  std::string_view rest_;
  std::string why_;
  int depth_ = 0;
};

bool is_space(char c) { return c == ' ' || c == '\t'; }

void skip_spaces(std::string_view& text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
}

std::optional<double> take_number(std::string_view& text) {
  skip_spaces(text);
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = read_number(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

// Numbers, then a unit.
template <std::size_t N>
std::array<double, N> parse(std::string_view text, const Dimension& expected) {
  const auto wrong = [&, text](std::string_view why) {
    std::string name(expected.name), example(expected.example);
    if (N == 3) {
      std::string_view unit = expected.example;
      take_number(unit);
      skip_spaces(unit);
      name += " for each of three axes";
      example = fmt::format("0.1 -0.2 0.3 {}", unit);
    }
    return std::invalid_argument(fmt::format("`{}` {}; {} is expected, such as `{}`", text, why, name, example));
  };
  std::array<double, N> values{};
  std::string_view rest = text;
  for (double& value : values) {
    const auto number = take_number(rest);
    if (!number)
      throw wrong(N == 1 ? "does not begin with a number" : fmt::format("does not begin with {} numbers", N));
    value = *number;
  }
  skip_spaces(rest);
  if (rest.empty() && !(expected == dimension::kRatio)) throw wrong("has no unit");
  if (std::string_view more = rest; take_number(more) && rest != "1") {
    throw wrong(N == 1 ? "has more than one number" : fmt::format("has more than {} numbers", N));
  }
  const double factor = unit_factor(rest, expected);
  for (double& value : values) {
    value *= factor;
    if (!std::isfinite(value)) throw wrong("is too large for a number");
  }
  return values;
}

// Phones mean g by `G`; elsewhere it is gauss.
bool is_phone_g(std::string_view unit, const Dimension& expected) {
  return unit == "G" && expected == dimension::kAcceleration;
}

}  // namespace

double unit_factor(std::string_view unit, const Dimension& expected) {
  if (is_phone_g(unit, expected)) return kStandardGravity;
  UnitParser parser(unit);
  const std::optional<Unit> parsed = unit.empty() ? Unit{1, kNone} : parser.parse();
  if (!parsed) throw std::invalid_argument(parser.fault());
  if (parsed->half_exponents != expected.half_exponents) {
    throw std::invalid_argument(fmt::format("unit `{}` does not measure {}; right would be such as `{}`", unit,
                                            expected.name, expected.example));
  }
  return parsed->factor;
}

bool measures(std::string_view unit, const Dimension& dimension) {
  if (unit.empty()) return false;
  if (is_phone_g(unit, dimension)) return true;
  const std::optional<Unit> parsed = UnitParser(unit).parse();
  return parsed && parsed->half_exponents == dimension.half_exponents;
}

double parse_quantity(std::string_view text, const Dimension& expected) { return parse<1>(text, expected)[0]; }

Eigen::Vector3d parse_vector(std::string_view text, const Dimension& expected) {
  const auto v = parse<3>(text, expected);
  return {v[0], v[1], v[2]};
}

std::string format_quantity(double value, std::string_view unit, const Dimension& expected) {
  const double factor = unit_factor(unit, expected);
  const double number = value / factor;
  for (int digits = 1; digits < 17; ++digits) {
    const std::string text = fmt::format("{:.{}g}", number, digits);
    double again = 0;
    read_number(text.data(), text.data() + text.size(), again);
    if (again * factor == value) return fmt::format("{} {}", again, unit);  // without an exponent: 200, not 2e+02
  }
  return fmt::format("{:.17g} {}", number, unit);
}

}  // namespace piste
