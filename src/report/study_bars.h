#pragma once
/// Draws numbers of a study with their intervals as bars, and other parts that its figures share.

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/plot/figure.h"
#include "piste/study/study_tables.h"
#include "plot/svg.h"
#include "report/study_words.h"

namespace piste::study_bars {

inline constexpr int kHeight = 340;
inline constexpr int kFrame = 150;  ///< height of a picture without its rows of names [px]
inline constexpr int kGrey = 6;
inline constexpr std::string_view kSign = "Sign: a correction to add.";

/// "fx", "fy", "fz" of the accelerometers.
std::vector<std::string> axis_names(const study_words::Triad& triad);

/// Offset of one of `count` bars that share a name from the place of the name.
double bar_offset(std::size_t index, std::size_t count);

/// Numbers with their 95 % intervals at places along the other axis, and their true values.
struct Bars {
  std::vector<double> place, value, low, high;
  std::vector<double> truth_place, truth;  ///< short strokes

  void add(double where, double mean, double half);
  void add_truth(double where, double half_stroke, double what);
  void draw(Plot& plot, int colour, const std::string& label, Plot::Along along) const;
  void draw_truth(Plot& plot, Plot::Along along) const;
};

/// Draws a line at zero, to see which intervals contain it.
void zero_line(Plot& plot, std::size_t names, Plot::Along along);

/// A caption that explains the bars and states the number of runs.
std::string bars_caption(const std::vector<AcrossRow>& rows);

/// A caption that explains the strokes. Empty if the truth is not known.
std::string truth_caption(const Study& study);

/// Adds a figure if there is one.
void append(std::vector<Figure>& out, std::optional<Figure> figure);

}  // namespace piste::study_bars
