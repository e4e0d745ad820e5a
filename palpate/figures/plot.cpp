#include "palpate/figures/plot.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::figures {

Series histogram(std::string name, const std::vector<double>& values, double low, double high, int bins,
                 Tone tone) {
  Series series;
  series.name = std::move(name);
  series.mark = Mark::bars;
  series.tone = tone;
  const double width = (high - low) / bins;
  series.x.resize(static_cast<std::size_t>(bins));
  series.y.assign(static_cast<std::size_t>(bins), 0.0);
  for (int i = 0; i < bins; ++i) series.x[static_cast<std::size_t>(i)] = low + (i + 0.5) * width;
  for (double value : values) {
    if (!std::isfinite(value)) continue;
    const double bin = std::clamp(std::floor((value - low) / width), 0.0, bins - 1.0);
    series.y[static_cast<std::size_t>(bin)] += 1.0;
  }
  return series;
}

Series band_around(std::string name, const std::vector<double>& x, const std::vector<double>& middle,
                   const std::vector<double>& half) {
  Series band{.name = std::move(name), .tone = Tone::muted, .filled = true};
  for (std::size_t i = 0; i < x.size(); ++i) {
    band.x.push_back(x[i]);
    band.y.push_back(middle[i] + half[i]);
  }
  for (std::size_t i = x.size(); i-- > 0;) {
    band.x.push_back(x[i]);
    band.y.push_back(middle[i] - half[i]);
  }
  return band;
}

Series cumulative(std::string name, std::vector<double> values, Tone tone, int points) {
  Series series;
  series.name = std::move(name);
  series.tone = tone;
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  std::sort(values.begin(), values.end());
  const auto count = values.size();
  const auto shown = std::min(count, static_cast<std::size_t>(points));
  for (std::size_t i = 0; i < shown; ++i) {
    const std::size_t k = shown == 1 ? count - 1 : i * (count - 1) / (shown - 1);
    series.x.push_back(values[k]);
    series.y.push_back(static_cast<double>(k + 1) / static_cast<double>(count));
  }
  return series;
}

}  // namespace palpate::figures
