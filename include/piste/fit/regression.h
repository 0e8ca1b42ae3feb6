#pragma once
/// Least squares of one series on others, and how far to trust it.
///
///     y = X c + e,   ĉ = (XᵀX)⁻¹ Xᵀ y   by Householder QR of the scaled columns
///
/// Two covariances stand beside the values. The formal one, s² (XᵀX)⁻¹, holds where the errors e are white. Errors of
/// an IMU are not: what the filter leaves, vibration and drift last from one sample to the next, and n samples tell as
/// much as a few of them would if they were independent. The second covariance knows this:
///
///     (XᵀX)⁻¹ S (XᵀX)⁻¹,   S = Σ_k w(k / (L + 1)) Σ_t x_t e_t e_(t+k) x_(t+k)ᵀ,   −L ≤ k ≤ L
///
/// (Newey and West 1987, Econometrica 55) with Parzen's window w, on scores x_t e_t that a first-order autoregression
/// has whitened, and recoloured after (Andrews and Monahan 1992, Econometrica 60). Parzen's, and not Bartlett's,
/// because low-passed noise has a steep spectrum, and Bartlett's window leaks. The lag L = 2 √n is of the order that
/// Lazarus, Lewis, Stock and Watson 2018 (J. Business & Economic Statistics 36) recommend; errors that last longer are
/// seen as far as an autoregression carries them. S is itself a random number of some n / (0.54 L) degrees of freedom,
/// so tests use Student's t with these and not the normal distribution.
///
/// Rows are taken as equally spaced in time; where some were left out, the others move together.

#include <Eigen/Core>
#include <vector>

namespace piste {

/// One number that was estimated, and how far to trust it.
struct Term {
  double value = 0;
  double sigma = 0;           ///< formal: if errors were white
  double standard_error = 0;  ///< of errors correlated in time
  double dof = 1;             ///< effective, of the standard error
  double systematic = 0;      ///< 1 sigma of what no length of the series makes smaller, such as of the x it is held to

  /// Of standard error and systematic error together.
  double total() const;
  /// Probability of a value at least that far from `hypothesis` if that were the truth: two-sided, by the total,
  /// Student's t with the degrees of freedom of Welch and Satterthwaite.
  double p_value(double hypothesis = 0) const;
  /// The truth lies within value ± this with `probability`.
  double half_width(double probability) const;
};

struct Regression {
  Eigen::VectorXd value;           ///< of the coefficients
  Eigen::MatrixXd covariance;      ///< formal
  Eigen::MatrixXd hac_covariance;  ///< heteroscedasticity- and autocorrelation-consistent
  Eigen::VectorXd inflation;       ///< of each variance by the other columns: 1 where it is orthogonal to them
  double residual = 0;             ///< s = sqrt(Σ e² / (n − p))
  int samples = 0;                 ///< n
  int lag = 0;                     ///< L
  double dof = 1;                  ///< effective

  Term term(int i) const;
  /// Formal, of two coefficients.
  double correlation(int i, int j) const;
  /// White samples that would tell as much of coefficient i; n or more where errors change sign all the time.
  double effective_samples(int i) const;
};

/// y on the columns of X, of which one may be of ones. Solved in extended precision where the machine has it.
/// @pre as many rows as y has, more than columns.
/// Throws DataError where a column is zero or follows from those before it.
Regression regress(const Eigen::MatrixXd& X, const Eigen::VectorXd& y);

/// Each column of Y on the same X, as regress would, for the price of one factorisation.
std::vector<Regression> regress_each(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y);

/// y = Σ c_j x^j, j = 0 … order, solved in powers of (x − mean) / deviation, which follow from one another far less
/// than those of x do. Coefficients, covariances and inflation are those of the powers of x.
/// @pre order ≥ 0, at least order + 2 samples. Throws DataError where x has no more than `order` different values.
Regression regress_polynomial(const Eigen::VectorXd& x, const Eigen::VectorXd& y, int order);

/// y = c₀ + c₁ x: the polynomial of order 1.
/// @pre at least three samples. Throws DataError where x does not change.
Regression regress_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y);

/// Mean of y, as regress on a column of ones. @pre at least two samples.
Regression regress_mean(const Eigen::VectorXd& y);

/// y = c₀ + c₁ x where both are observed with noise, whose variances have a known ratio: `ratio` = that of y over that
/// of x. Deming's regression, maximum likelihood where the noise is normal (Deming 1943, Statistical Adjustment of
/// Data; Fuller 1987, Measurement Error Models, section 1.3). With x and y about their means c₁ solves
///
///     Σ e z = 0,   e = y − c₁ x,   z = ratio x + c₁ y
///
/// and is the root of the sign of Σ x y. A ratio that grows goes to regress_line(x, y), one that falls to the line of x
/// on y, inverted; the line of y on x for 1 / ratio is the same line seen from the other side. Noise in e and z is
/// uncorrelated, so the scores are e z, their derivative is −Σ x z + Σ e y, and the formal variance is that of Fuller
/// for normal noise. Covariances take the ratio for known: where it is wrong the line is, by up to its distance from
/// either regression. `residual` is that of e.
/// @pre at least three samples, ratio > 0. Throws DataError where x or y does not change, or neither with the other.
Regression regress_both_noisy(const Eigen::VectorXd& x, const Eigen::VectorXd& y, double ratio);

/// a − b of independent terms without systematic errors, with the degrees of freedom of Welch and Satterthwaite.
Term difference(const Term& a, const Term& b);

}  // namespace piste
