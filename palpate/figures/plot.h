// What a page can draw: flat plots of lines, points and bars.
//
// Values, in the units their axis labels name. Not a number is a gap. Nothing here knows HTML.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace palpate::figures {

// Colours by meaning; the page knows how each looks in its light and its dark dress.
enum class Tone { ours, rival, third, fourth, muted, good, bad };

enum class Mark { line, points, steps, bars, area };

struct Series {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
  Mark mark = Mark::line;
  Tone tone = Tone::ours;
  std::vector<std::string> labels;  // instead of x: categories of bars
  bool in_legend = true;
  bool dashed = false;
  bool filled = false;               // lines only: the area of the closed path
  std::vector<std::string> hover;    // one text per point, instead of its coordinates
  std::vector<std::string> written;  // bars only: text at the end of each bar
};

struct Level {  // a straight line across the plot: a bar to reach, a paper's figure
  double at = 0.0;
  std::string label;
  Tone tone = Tone::muted;
  bool upright = false;      // at an x instead of a y
  std::optional<double> to;  // a band from `at` to there
};

struct Plot {
  std::string title;
  std::string x_label, y_label;
  std::vector<Series> series;
  std::vector<Level> levels;
  bool equal_axes = false;  // one metre to the right is as long as one metre up
  bool log_x = false, log_y = false;
  bool from_zero = false;                   // the y axis begins at zero
  bool stacked = false;                     // bars of one category one upon the other
  bool sideways = false;                    // bars grow to the right, categories read on the left
  bool flip_x = false, flip_y = false;      // larger values on the left, below
  std::array<double, 2> y_range{0.0, 0.0};  // fixed where they differ
  std::array<double, 2> x_range{0.0, 0.0};
  int height_px = 340;
  std::string caption;
};

// Counts of `values` in `bins` equal bins over [low, high]; values outside are counted in the outermost bins.
Series histogram(std::string name, const std::vector<double>& values, double low, double high, int bins,
                 Tone tone = Tone::ours);

// The area between `middle` - `half` and `middle` + `half`.
Series band_around(std::string name, const std::vector<double>& x, const std::vector<double>& middle,
                   const std::vector<double>& half);

// Share of values (0..1) that are at most x, as a step line of at most `points` points.
Series cumulative(std::string name, std::vector<double> values, Tone tone = Tone::ours, int points = 200);

}  // namespace palpate::figures
