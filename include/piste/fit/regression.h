#pragma once
/// Linear regression of a time series on others, with standard errors that hold for coloured noise.
///
///     y = X c + e,   ĉ = (XᵀX)⁻¹ Xᵀ y   by Householder QR of the scaled columns
///
/// There are two covariances. The formal one, s² (XᵀX)⁻¹, is right if the errors e are white. Errors of an IMU are
/// coloured: low-passed noise, vibration and drift are correlated from one sample to the next. n samples then have as
/// much information as a few independent ones. The second covariance takes this into account:
///
///     (XᵀX)⁻¹ S (XᵀX)⁻¹,   S = Σ_k Σ_t E(x_t e_t e_(t+k) x_(t+k)ᵀ)
///
/// S is estimated as the mean of ν squared cosine averages of the scores,
///
///     S = 1/ν Σ_j Λ_j Λ_jᵀ,   Λ_j = √2 Σ_t x_t e_t cos(π j (t − ½) / n),   j = 1 … ν
///
/// and tests use Student's t with ν degrees of freedom (Mueller 2007, J. Econometrics 141; Lazarus, Lewis, Stock and
/// Watson 2018, J. Business & Economic Statistics 36). ν = 12 is fixed (Mueller and Watson 2008, Econometrica 76): so
/// the averages are of the lowest frequencies of the stretch, and do not depend on how often it was sampled. It holds
/// where the stretch lasts some 50 correlation times of the errors.
///
/// Rows are treated as equally spaced in time. If some were left out, the others are treated as if they were adjacent.

#include <Eigen/Core>
#include <vector>

namespace piste {

/// An estimated number and its uncertainty.
struct Term {
  double value = 0;
  double sigma = 0;           ///< formal: as if errors were white
  double standard_error = 0;  ///< for coloured errors
  double dof = 1;             ///< effective degrees of freedom of the standard error
  double systematic = 0;      ///< 1-sigma of errors that do not become smaller in a longer series, such as those of x
  /// What two terms from the same signals share (paired_difference): of the standard error the cosine averages, whose
  /// squares are summed in its square; of the systematic error the effects of errors of variance 1. Empty: nothing.
  Eigen::VectorXd averages = {}, effects = {};

  /// Standard error and systematic error together: the root of the sum of their squares.
  double total() const;
  /// Two-sided p-value of the hypothesis that the true value is `hypothesis`, by Student's t with the total error and
  /// the degrees of freedom of Welch and Satterthwaite.
  double p_value(double hypothesis = 0) const;
  /// Half the width of the confidence interval: the true value is within value ± this with `probability`.
  double half_width(double probability) const;
};

/// The result of a regression.
struct Regression {
  Eigen::VectorXd value;           ///< of the coefficients
  Eigen::MatrixXd covariance;      ///< formal
  Eigen::MatrixXd hac_covariance;  ///< heteroscedasticity- and autocorrelation-consistent
  Eigen::MatrixXd averages;        ///< the cosine averages, a row for each coefficient: A Aᵀ is the second covariance
  Eigen::VectorXd inflation;       ///< of each variance by the other columns: 1 if it is orthogonal to them
  double residual = 0;             ///< s = sqrt(Σ e² / (n − p))
  int samples = 0;                 ///< n
  double dof = 1;                  ///< of the second covariance

  Term term(int i) const;
  /// Formal correlation of two coefficients.
  double correlation(int i, int j) const;
  /// Number of white samples that would determine coefficient i as well. It is n or more if successive errors tend to
  /// have opposite signs.
  double effective_samples(int i) const;
};

/// Regression of y on the columns of X. For a constant term, X must have a column of ones. Solved in extended precision
/// if the machine has it. @pre X has as many rows as y, and more rows than columns.
/// Throws DataError if a column is zero or depends linearly on those before it.
Regression regress(const Eigen::MatrixXd& X, const Eigen::VectorXd& y);

/// Regression of each column of Y on the same X, with only one factorisation of X.
std::vector<Regression> regress_each(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y);

/// Fits a polynomial y = Σ c_j x^j, j = 0 … order. It is solved in powers of (x − mean) / deviation, which are far less
/// correlated than those of x. Coefficients, covariances and inflation are those of the powers of x.
/// @pre order ≥ 0, at least order + 2 samples. Throws DataError if x has no more than `order` different values.
Regression regress_polynomial(const Eigen::VectorXd& x, const Eigen::VectorXd& y, int order);

/// Fits a line y = c₀ + c₁ x. @pre at least three samples. Throws DataError if x does not change.
Regression regress_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y);

/// The mean of y, as a regression on a column of ones. @pre at least two samples.
Regression regress_mean(const Eigen::VectorXd& y);

/// Fits a line y = c₀ + c₁ x if both x and y have noise, whose variances have a known ratio: `ratio` = that of y over
/// that of x. This is Deming's regression, the maximum-likelihood solution for normal noise (Deming 1943, Statistical
/// Adjustment of Data; Fuller 1987, Measurement Error Models, section 1.3). With x and y less their means, c₁ solves
///
///     Σ e z = 0,   e = y − c₁ x,   z = ratio x + c₁ y
///
/// and is the root that has the sign of Σ x y. For a large ratio the result approaches regress_line(x, y), for a small
/// one the inverted line of x on y. If x and y are exchanged and the ratio is 1 / ratio, the line is the same. Noise in
/// e and z is uncorrelated, so the scores are e z, their derivative is −Σ x z + Σ e y, and the formal variance is that
/// of Fuller for normal noise. Covariances assume that the ratio is known. If it is wrong, the error of the line is at
/// most its distance from either regression. `residual` is that of e.
/// @pre at least three samples, ratio > 0. Throws DataError if x or y does not change, or if they are uncorrelated.
Regression regress_both_noisy(const Eigen::VectorXd& x, const Eigen::VectorXd& y, double ratio);

/// The difference a − b of two estimates from the same signals, such as a line and a polynomial of one run. They share
/// the noise of the signals, and what is wrong with x. Cosine averages of two linear estimates from the same rows are
/// subtracted one by one, so that
///
///     var(a − b) = var(a) + var(b) − 2 Σ_j a_j b_j,   likewise the systematic variance by their effects
///
/// which is what the averages of the difference itself give. What they do not share counts as independent. The formal
/// sigma is that of independent terms: white noise does not say how much of it is shared.
///
/// Example: means of 90 s of one noisy signal, and of the same with a tenth of the noise added to it. Both have a
/// standard error of 0.100, their difference one of 0.010, where independent terms would have 0.141.
Term paired_difference(const Term& a, const Term& b);

/// The difference a − b of independent terms without systematic errors, with the degrees of freedom of Welch and
/// Satterthwaite.
Term difference(const Term& a, const Term& b);

}  // namespace piste
