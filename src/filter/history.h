#pragma once
/// All that a filter did in a run, small enough to be kept whole, so that a smoother filters nothing again.
///
/// A run is cut into chunks of a second. Each begins with estimate and covariance, at the end of an epoch, and has
/// the events after it: steps, of which the transition follows (ErrorStep), corrections, what moved the estimate
/// otherwise, and the estimates at the ends of its epochs. The chunks stand in memory, or in a file.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "filter/noise_score.h"
#include "io/scratch.h"
#include "model/dynamics.h"
#include "piste/filter/filter_state.h"

namespace piste {

class KalmanFilter;

/// Records what a filter does in a run (it calls the functions from src/filter/filter_walk.h), and reads it back.
class History {
 public:
  enum class Kind : std::uint8_t {
    kStep,
    kCorrection,  ///< by a fix
    kTakenBack,   ///< what noise told the scales (filter/noise_score.h)
    kInflated,    ///< variances that were added to the covariance of (ρ, ν, θ)
    kMoved,       ///< the estimate went to that of a reference
    kRow          ///< the end of an epoch
  };
  struct Event {
    Kind kind;
    std::uint32_t at;     ///< where its values begin in the chunk
    std::uint32_t other;  ///< of a step: its surroundings; of a row: whether its estimate is kept
  };
  struct Chunk {
    std::size_t first = 0;  ///< the first row that ends in it
    std::vector<Event> events;
    std::vector<double> values;
  };
  /// A correction: the update, and by how much it moved the estimate; nothing if it did not, as about a reference.
  struct Correction {
    Update update;
    ErrorVector moved;
    ResetJacobian reset;  ///< if it moved
  };
  struct TakenBack {
    ScaleScore score;
    ErrorVector moved;            ///< by −P times the score
    bool estimate_moved = false;  ///< or what is known beside a reference
  };

  /// `scratch`: the folder of the file that has the chunks; empty: they are in memory.
  explicit History(std::filesystem::path scratch) : folder_(std::move(scratch)), scratch_(folder_) {}
  History() : History(std::filesystem::path()) {}

  /// Begins with the state of a filter. The estimates at the ends of epochs up to the time `own_rows_until` are kept,
  /// too.
  void begin(const KalmanFilter& filter, double own_rows_until);
  void add_step(const Transition& t);
  /// A correction that moves the mean about a reference, or nothing.
  void add_correction(const Update& u);
  /// One that moves the estimate `x`. `down`, `stands`: of transport_jacobian(), from which the reset follows again.
  void add_correction(const Update& u, const ResetJacobian& reset, const Estimate& x, const Vector3d& down,
                      bool stands);
  /// An errors-in-variables correction of the scales, which moved the estimate, or the mean about a reference.
  void add_taken_back(const ScaleScore& score, const ErrorVector& moved, bool estimate_moved);
  /// `variances`: what was added to those of the state.
  void add_inflation(const ErrorVector& variances);
  /// The estimate went to that of a reference, or left it.
  void add_moved(const ErrorVector& moved);
  /// The end of an epoch. A chunk ends here if it has lasted a second.
  void end_row(const FilterState& state);
  /// Ends with the state of the last row: a chunk without events, unless one has just begun.
  void finish(const FilterState& state);

  /// Number of chunks. The last one begins at the end of the last row, and has no events.
  std::size_t size() const { return places_.size(); }
  bool empty() const { return places_.empty(); }
  /// The first row that ends in a chunk.
  std::size_t first(std::size_t chunk) const { return places_[chunk].first; }
  /// Reads a chunk. Throws Error if its file cannot be read.
  void load(std::size_t number, Chunk& chunk) const;
  void clear() { *this = History(folder_); }
  const std::filesystem::path& scratch() const { return folder_; }

  FilterState start(const Chunk& chunk) const;  ///< at the beginning; without a reference its mean is zero
  ErrorStep step(const Chunk& chunk, const Event& event) const;
  Correction correction(const Chunk& chunk, const Event& event) const;
  TakenBack taken_back(const Chunk& chunk, const Event& event) const;
  ErrorVector inflated(const Chunk& chunk, const Event& event) const;
  ErrorVector moved(const Chunk& chunk, const Event& event) const;
  const StateLayout& layout() const { return layout_; }
  const FilterOptions& options() const { return options_; }
  const Vector3d& earth_rate() const { return earth_rate_; }
  bool about_reference() const { return reference_; }  ///< whether the filter was linearised about one, and has a mean
  /// Whether the end of an epoch has the filter's estimate; otherwise the row of the run's solution is that estimate.
  bool has_row(const Event& event) const { return event.other != 0; }
  /// Sets `x` to the estimate at the end of an epoch, and returns its time. @pre has_row(). Of what is not estimated,
  /// `x` is that of start().
  double row(const Chunk& chunk, const Event& event, Estimate& x) const {
    const double* p = chunk.values.data() + event.at;
    return take_row(chunk, p, x);
  }

 private:
  void add_update(const Update& u, bool moves);
  struct Place {
    std::size_t first;
    std::size_t events, values;  // blocks of the scratch
  };
  void open(const FilterState& state);
  void close();
  void add(Kind kind, std::uint32_t other = 0);
  void note_constants(const FilterState& state);
  void put_row(const FilterState& state);
  double take_row(const Chunk& chunk, const double*& p, Estimate& x) const;

  std::filesystem::path folder_;
  Scratch scratch_;
  std::vector<Place> places_;
  std::vector<ErrorStep::Around> around_;
  Chunk now_;                  // the last one, as it grows
  double opened_ = 0;          // its beginning
  std::size_t constants_ = 0;  // where in it the last constants of an estimate stand
  StateLayout layout_;
  FilterOptions options_;
  Vector3d earth_rate_ = Vector3d::Zero();
  Estimate fixed_;  // what is not estimated
  bool reference_ = false;
  double own_rows_until_ = 1e300;
  std::size_t rows_ = 0;
};

}  // namespace piste
