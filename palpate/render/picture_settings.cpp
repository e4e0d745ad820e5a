#include <fmt/format.h>

#include <stdexcept>

#include "palpate/core/text.h"
#include "palpate/render/compositor.h"

namespace palpate::render {

CompositorSettings settings_of(Quality quality) {
  CompositorSettings settings;
  switch (quality) {
    case Quality::low:
      settings.samples = 1, settings.surface_texels = 64, settings.map_texels = 0;
      settings.real_shadows = false, settings.shadow_cells = 16;
      break;
    case Quality::medium:
      break;
    case Quality::high:
      settings.samples = 8, settings.surface_texels = 256, settings.map_texels = 2048;
      break;
  }
  return settings;
}

std::string_view quality_word(Quality quality) {
  return quality == Quality::low ? "low" : quality == Quality::high ? "high" : "medium";
}

Expected<Quality> parse_quality(std::string_view word) {
  for (const Quality quality : {Quality::low, Quality::medium, Quality::high})
    if (word == quality_word(quality)) return quality;
  return wrong_use("--quality '{}': low, medium or high is expected", excerpt(word));
}

std::string_view quality_choice_word(std::optional<Quality> quality) {
  return quality ? quality_word(*quality) : "auto";
}

Expected<std::optional<Quality>> parse_quality_choice(std::string_view word) {
  if (word == quality_choice_word(std::nullopt)) return std::nullopt;
  const auto quality = parse_quality(word);
  if (!quality) return wrong_use("--quality '{}': auto, low, medium or high is expected", excerpt(word));
  return *quality;
}

std::vector<std::uint8_t> biocular(std::span<const std::uint8_t> rgb, int width, int height) {
  const auto row = 3 * static_cast<std::size_t>(std::max(width, 0));
  if (width <= 0 || height <= 0 || rgb.size() != row * static_cast<std::size_t>(height))
    throw std::invalid_argument(
        fmt::format("biocular: {} bytes for a picture of {}x{}", rgb.size(), width, height));
  std::vector<std::uint8_t> both;
  both.reserve(2 * rgb.size());
  for (std::size_t at = 0; at < rgb.size(); at += row)
    for (int eye = 0; eye < 2; ++eye)
      both.insert(both.end(), rgb.begin() + static_cast<std::ptrdiff_t>(at),
                  rgb.begin() + static_cast<std::ptrdiff_t>(at + row));
  return both;
}

std::vector<std::uint8_t> left_eye(std::span<const std::uint8_t> rgb, int width, int height, int eyes) {
  const auto row = 3 * static_cast<std::size_t>(std::max(width, 0));
  if (width <= 0 || height <= 0 || eyes < 1 || width % eyes != 0 ||
      rgb.size() != row * static_cast<std::size_t>(height))
    throw std::invalid_argument(fmt::format("left_eye: {} bytes for a picture of {}x{} with {} eyes",
                                            rgb.size(), width, height, eyes));
  const auto part = static_cast<std::ptrdiff_t>(row) / eyes;
  std::vector<std::uint8_t> left;
  left.reserve(rgb.size() / static_cast<std::size_t>(eyes));
  for (std::size_t at = 0; at < rgb.size(); at += row) {
    const auto from = rgb.begin() + static_cast<std::ptrdiff_t>(at);
    left.insert(left.end(), from, from + part);
  }
  return left;
}

}  // namespace palpate::render
