#include "palpate/figures/surface_outlines.h"

#include <algorithm>

namespace palpate::figures {

void add_surface_outlines(Plot& plot, const PlayFolder& play, std::string_view horizontal,
                          std::string_view vertical) {
  const CsvTable* surface = play.raw("surface.csv");
  if (surface == nullptr || !has_columns(*surface, {"label", "x_mm", "y_mm", "z_mm"})) return;
  const auto label = *surface->find("label");
  const auto h = column(*surface, horizontal), v = column(*surface, vertical);
  for (std::size_t i = 0; i + 3 < surface->rows.size(); i += 4) {
    // Touched several times over: once is enough to show it.
    if (std::any_of(plot.series.begin(), plot.series.end(),
                    [&](const Series& s) { return s.name == surface->text[i][label]; }))
      continue;
    Series side{.name = surface->text[i][label],
                .tone = plot.series.size() % 2 == 1 ? Tone::third : Tone::fourth};
    for (std::size_t k : {0, 1, 2, 3, 0}) {
      side.x.push_back(h[i + k] / 1000.0);
      side.y.push_back(v[i + k] / 1000.0);
    }
    plot.series.push_back(side);
  }
}

}  // namespace palpate::figures
