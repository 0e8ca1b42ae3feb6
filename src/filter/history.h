#pragma once
/// Record of all operations of a filter in a run, small enough to be kept whole: a smoother need not run the filter
/// again.
///
/// A run is cut into chunks of one second. Each begins with estimate and covariance at the end of an epoch. Its events
/// follow: steps, corrections, other changes of the estimate, and the estimates at the ends of its epochs. The
/// transition is computed from the steps (ErrorStep). The chunks are in memory, or in a file.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "filter/considered.h"
#include "filter/errors_in_variables.h"
#include "io/scratch.h"
#include "model/dynamics.h"
#include "piste/filter/filter_state.h"

namespace piste {

class KalmanFilter;

/// Records the operations of a filter in a run (src/filter/filter_walk.h calls the functions), and reads them back.
class History {
 public:
  enum class Kind : std::uint8_t {
    kStep,
    kCorrection,  ///< by a fix
    kScore,       ///< errors-in-variables correction of the scales (filter/errors_in_variables.h)
    kInflated,    ///< variances were added to the covariance
    kMoved,       ///< the estimate moved to that of a reference, or left it
    kRow          ///< the end of an epoch
  };
  struct Event {
    Kind kind;
    std::uint32_t at;     ///< index of its first value in the chunk
    std::uint32_t other;  ///< of a step: its surroundings; of other kinds: a flag
  };
  struct Chunk {
    std::size_t first = 0;  ///< the first row that ends in it
    std::vector<Event> events;
    std::vector<double> values;
  };
  /// A correction: the update, and the change of the estimate. `moved` is empty if the estimate did not move.
  struct Correction {
    Update update;
    ErrorVector moved;
    ResetJacobian reset;  ///< if it moved
  };
  struct ScoreCorrection {
    ScaleScore score;
    ErrorVector moved;            ///< by −P times the score
    bool estimate_moved = false;  ///< otherwise the mean about a reference moved
  };

  /// `scratch`: folder of the file that holds the chunks; empty: memory.
  explicit History(std::filesystem::path scratch) : folder_(std::move(scratch)), scratch_(folder_) {}
  History() : History(std::filesystem::path()) {}

  /// Begins with the state of a filter. The estimates at the ends of epochs up to the time `own_rows_until` are stored,
  /// too.
  void begin(const KalmanFilter& filter, double own_rows_until);
  void add_step(const Transition& t);
  /// A correction that does not move the estimate: it moves the mean about a reference, or only the covariance changes.
  void add_correction(const Update& u);
  /// A correction that moves the estimate `x`. transport_jacobian() gives the reset Jacobian again.
  void add_correction(const Update& u, const ResetJacobian& reset, const Estimate& x,
                      const std::optional<Standing>& standing);
  /// An errors-in-variables correction of the scales, which moves the estimate, or the mean about a reference.
  void add_score_correction(const ScaleScore& score, const ErrorVector& moved, bool estimate_moved);
  /// `variances`: added to the diagonal of the covariance.
  void add_inflation(const ErrorVector& variances);
  /// The estimate moved to that of a reference, or left it. `moved`: change of the mean of its error.
  void add_moved(const ErrorVector& moved);
  /// The end of an epoch. A chunk ends here if it has lasted one second.
  void end_row(const FilterState& state);
  /// Ends with the state of the last row, in a chunk without events.
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

  FilterState start(const Chunk& chunk) const;  ///< at its beginning; without a reference its mean is zero
  ErrorStep step(const Chunk& chunk, const Event& event) const;
  Correction correction(const Chunk& chunk, const Event& event) const;
  ScoreCorrection score_correction(const Chunk& chunk, const Event& event) const;
  ErrorVector inflated(const Chunk& chunk, const Event& event) const;
  ErrorVector moved(const Chunk& chunk, const Event& event) const;
  const StateLayout& layout() const { return layout_; }
  const Considered& considered() const { return considered_; }
  const FilterOptions& options() const { return options_; }
  const Vector3d& earth_rate() const { return earth_rate_; }
  bool about_reference() const { return reference_; }  ///< whether the filter was linearised about one, and has a mean
  /// Whether the filter's estimate at the end of an epoch is stored; otherwise it is the row of the run's solution.
  bool has_row(const Event& event) const { return event.other != 0; }
  /// Sets `x` to the estimate at the end of an epoch, and returns its time. @pre has_row(). Values that are not
  /// estimated are those of start().
  double row(const Chunk& chunk, const Event& event, Estimate& x) const {
    const double* p = chunk.values.data() + event.at;
    return take_row(chunk, p, x);
  }

 private:
  void add_update(const Update& u, bool moves);
  struct Place {
    std::size_t first;
    std::size_t events, values;  // blocks of the scratch file
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
  Chunk now_;                  // the chunk that is being written
  double opened_ = 0;          // time of its beginning
  std::size_t constants_ = 0;  // index in it of the last written constants
  StateLayout layout_;
  Considered considered_;
  FilterOptions options_;
  Vector3d earth_rate_ = Vector3d::Zero();
  Estimate fixed_;  // values that are not estimated
  bool reference_ = false;
  double own_rows_until_ = 1e300;
  std::size_t rows_ = 0;
};

}  // namespace piste
