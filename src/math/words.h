#pragma once
/// Numbers and times as a reader wants them.

#include <string>

namespace piste {

/// A length of time in the unit that suits it: `15.5 ms`, `18.02 s`, `2.3 days (198720.000 s)`.
std::string time_text(double seconds);

/// Whether stamps are late or early: `15.5 ms late`, `0.2 s early`.
std::string delay_text(double delay);

/// A number with so many significant digits, without an exponent and without zeros at its end: 0.00042, 200, 4900.
std::string plain(double value, int digits = 3);

/// A number with so many decimals, and 0 for what rounds to it: -0.05, 0.00.
std::string with_decimals(double value, int decimals);

/// A value to the second digit of its sigma, without an exponent: -22620 for a sigma of 530.
std::string rounded(double value, double sigma);

/// A value and its sigma, both to the second digit of the sigma: `-22620 ± 530`, `0.0123 ± 0.0021`.
std::string measured(double value, double sigma);

}  // namespace piste
