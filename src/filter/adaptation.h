#pragma once
/// Adaptive noise: the filter estimates a factor for the variances of each source, and one for the white noise of each
/// triad of the IMU.
///
/// An innovation z of covariance S has the log-likelihood −½ (ln det S + zᵀ S⁻¹ z). Let D_k = ∂S/∂ln θ_k for a factor
/// θ_k of a variance. The score and the Fisher information are
///
///     s_k = ½ (zᵀ S⁻¹ D_k S⁻¹ z − tr S⁻¹ D_k)        I_kl = ½ tr(S⁻¹ D_k S⁻¹ D_l)
///
/// The logarithms of all factors are Gauss-Markov processes about zero, the noise as stated. Each innovation corrects
/// them by score and information, as a Kalman filter would (score-driven models: Creal, Koopman and Lucas 2013; Harvey
/// 2013).
///
/// For a source, D is its own R. The step is then, to first order, that of variational Bayes (Särkkä and Nummenmaa
/// 2009). For the IMU, D is H M Hᵀ, where M = ∂P/∂ln θ goes through the same steps as P. M holds the effect of the
/// noise of all past samples on this innovation, not only of those since the last fix. The noises of IMU and receiver
/// are thus separated by their effect over time. The sums of innovations of Sage and Husa cannot separate them.
///
/// The factor of a receiver's positions is not below 1 unless the user declares their errors white. Innovations show
/// only the white part of the stated error.

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "filter/considered.h"
#include "model/dynamics.h"
#include "piste/core/options.h"
#include "piste/model/measurement_list.h"

namespace piste {

/// The factors of a run. Without options the adaptation is off: every factor is 1, and nothing is stored.
class Adaptation {
 public:
  Adaptation() = default;
  Adaptation(const FilterOptions& options, const StateLayout& layout, const MeasurementSources& sources);

  bool on() const { return log_.size() > 0; }
  /// The factor of the covariance of a source's noise.
  double variance_of(int source) const;
  /// The noise of a step, multiplied by the factors of the IMU.
  StepNoise of(const StepNoise& stated) const;
  /// The factors of the white noise of gyroscopes and accelerometers, as variances.
  std::array<double, 2> imu_variances() const;

  /// Call it after each step of the covariance, with the noise of the step over `dt` seconds. `dt` = 0: no noise was
  /// added.
  void propagate(const StateLayout& layout, const Transition& t, const StepNoise& noise, double dt);
  /// Updates the factors by an innovation in motion, before it is used. `bound`: the gate. An innovation outside the
  /// gate informs on its own source only, by its change since the previous one. An offset of a receiver is not noise.
  /// No heap.
  void learn(int source, double time, const Update& u, double bound);
  /// Call it when the covariance has been updated by this measurement and reset.
  void correct(const StateLayout& layout, const Update& u, const ResetJacobian& G);

  /// Names of the factors in files: the sources that are adapted, "gyro_noise", "accel_noise".
  std::vector<std::string> names() const { return names_; }
  /// Appends the factors of the sigmas, in the order of names().
  void append_to(std::vector<double>& row) const;
  /// ∂P/∂ln θ: what the noise of gyroscopes (0) or accelerometers (1) has added to the covariance so far.
  const Covariance& of_imu(int triad) const { return imu_[static_cast<std::size_t>(triad)]; }

 private:
  struct Last {
    double time = -1e300;
    Vector3d residual = Vector3d::Zero();
    Matrix3d R = Matrix3d::Zero();
    int rows = 0;
  };

  void forget(double time);
  void learn_inside(Eigen::Index source, const Update& u);
  void learn_outside(Eigen::Index source, const Update& u, const Last& last, double bound);
  void keep_in_bounds();
  double furthest() const { return 2 * std::log(options_.within); }  // largest |ln θ|

  AdaptationOptions options_;
  std::vector<std::string> names_;
  std::vector<int> slot_;               // index of each source's factor; −1: not adapted
  Eigen::VectorXd log_;                 // ln θ: sources, gyroscopes, accelerometers
  Eigen::MatrixXd variance_;            // covariance of log_
  Eigen::MatrixXd seen_, gain_, drop_;  // of one correction; members, so that it needs no heap
  std::vector<Last> last_;              // by slot
  std::vector<double> least_;           // lower bounds of log_
  double time_ = 0;
  Considered considered_;
  std::vector<Covariance> imu_;  // ∂P/∂ln θ of the two triads
};

}  // namespace piste
