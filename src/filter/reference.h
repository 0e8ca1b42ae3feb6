#pragma once
/// A trajectory about which a run is linearised, instead of about the filter's own estimate.
///
/// A filter linearises each step at its own estimate, with the rate and the force that the sensors measured. After an
/// outage that estimate is far from the truth. And the measured rate holds the noise that has accumulated in the
/// attitude. As the factor of a scale, that rate correlates with the residuals, and the scale follows the noise (errors
/// in variables; Fuller 1987).
///
/// A smoothed trajectory has neither fault. Filtering and smoothing about it is one Gauss-Newton step for the whole run
/// (the iterated Kalman smoother; Bell 1994).

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "io/scratch.h"
#include "piste/core/estimate.h"
#include "piste/model/measurement.h"

namespace piste {

/// A smoothed run: the estimate at its start, and at the end of each epoch, or of each merged one at standstill. Blocks
/// that are constant, except rotations, keep their value from the start.
class Reference {
 public:
  struct Row {
    double time = 0;
    Estimate x;
  };
  /// Without rows, for estimates of `layout`. `scratch`: folder of the file that holds them; empty: memory.
  explicit Reference(StateLayout layout, std::filesystem::path scratch = {});

  /// Appends a row to the current piece, which holds the rows since the last close().
  void add(double time, const Estimate& x);
  /// Puts the current piece before all others: a smoother finds the last rows first.
  void close();
  Estimate start;

  std::size_t size() const { return size_; }
  double last_time() const { return last_time_; }
  const std::filesystem::path& scratch() const { return folder_; }

  /// Reads the rows in order. A copy continues independently.
  class Reader {
   public:
    explicit Reader(std::shared_ptr<const Reference> of);
    /// The row at that time, or the linear interpolation between the rows around it; the last row if all are before it.
    /// @pre Times ascend, and there is a row.
    const Row& at(double time);
    bool ends_before(double time) const { return of_->last_time() < time; }

   private:
    void next();
    std::shared_ptr<const Reference> of_;
    std::vector<double> rows_;  // of the current piece
    std::size_t next_piece_, next_ = 0, left_;
    Row before_, row_, between_;
  };

 private:
  StateLayout layout_;
  std::filesystem::path folder_;
  Scratch scratch_;
  std::vector<std::size_t> pieces_;  // last rows first
  std::vector<double> rows_;         // of the current piece
  std::size_t size_ = 0;
  double last_time_ = -1e300;
};

/// Mean angular rate and specific force over `dt` that lead from one estimate to the next, in the body axes half-way:
///
///     ω = Log(R₁ᵀ R₂) / dt + Rᵀ ω_ie,    f = Rᵀ ((v₂ − v₁) / dt + 2 ω_ie × v − g)
///
/// An IMU without errors measures them (Groves 2013, section 5.4). `earth_rate` and the gravity are in w.
BodyMotion motion_between(const Estimate& from, const Estimate& to, double dt, const Vector3d& earth_rate,
                          const Gravity& gravity);

}  // namespace piste
