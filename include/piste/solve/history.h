#pragma once
/// All that a filter did in a run, small enough to be kept whole, so that a smoother filters nothing again.
///
/// A run is cut into chunks of a second. Each begins with the covariance, at the end of an epoch, and has
/// the events after it: steps, of which the transition follows (ErrorStep), corrections, and what moved the estimate
/// otherwise.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "piste/solve/noise_score.h"
#include "piste/solve/tape.h"

namespace piste {

/// Records a run, and gives what was recorded.
class History {
 public:
  enum class Kind : std::uint8_t {
    kStep,
    kCorrection,  ///< by a fix
    kTakenBack,   ///< what noise told the scales (solve/noise_score.h)
    kAdmitted,    ///< variances that were added to the covariance of (ρ, ν, θ)
    kMoved,       ///< the estimate went to that of a reference
    kRow          ///< the end of an epoch
  };
  struct Event {
    Kind kind;
    std::uint32_t at;     ///< where its values begin in the chunk
    std::uint32_t other;  ///< of a step: its surroundings
  };
  struct Chunk {
    std::size_t first = 0;  ///< the first row that ends in it
    double time = 0;        ///< of its beginning, which is the end of the row before, or the start
    std::vector<Event> events;
    std::vector<double> values;
  };
  /// A correction: the update, and by how much it moved the estimate; nothing if it did not, as about a reference.
  struct Correction {
    Update update;
    ErrorVector moved;
  };
  struct TakenBack {
    ScaleScore score;
    ErrorVector moved;  ///< the estimate, by −P times the score
  };
  using Variances = Eigen::Matrix<double, 9, 1>;

  /// Begins with the state of a filter. `reference`: whether it is linearised about one, and has a mean.
  void begin(const FilterState& state, bool reference);
  void add_step(const Transition& t);
  /// `moved`: whether it moved the estimate.
  void add_correction(const Update& u, bool moved);
  void add_taken_back(const ScaleScore& score, const ErrorVector& moved);
  void add_admitted(const Variances& variances);
  void add_moved(const ErrorVector& moved);
  /// The end of an epoch. A chunk ends here if it has lasted a second.
  void end_row(const FilterState& state);
  /// Ends with the state of the last row: a chunk without events, unless one has just begun.
  void finish(const FilterState& state);

  /// The last one begins at the end of the last row, and has no events.
  const std::vector<Chunk>& chunks() const { return chunks_; }
  bool empty() const { return chunks_.empty(); }
  void clear() { *this = {}; }

  Covariance covariance(const Chunk& chunk) const;  ///< at the beginning
  ErrorVector mean(const Chunk& chunk) const;       ///< likewise; zero without a reference
  ErrorStep step(const Chunk& chunk, const Event& event) const;
  Correction correction(const Chunk& chunk, const Event& event) const;
  TakenBack taken_back(const Chunk& chunk, const Event& event) const;
  Variances admitted(const Chunk& chunk, const Event& event) const;
  ErrorVector moved(const Chunk& chunk, const Event& event) const;

 private:
  void open(const FilterState& state);
  void close();
  void add(Kind kind, std::uint32_t other = 0);

  std::vector<Chunk> chunks_;
  std::vector<ErrorStep::Around> around_;
  Chunk now_;  // the last one, as it grows
  int size_ = 0;
  bool reference_ = false;
  std::size_t rows_ = 0;
};

}  // namespace piste
