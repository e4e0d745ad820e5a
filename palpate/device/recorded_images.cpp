#include "palpate/device/recorded_images.h"

#include <fmt/format.h>

namespace palpate::device {

std::string stamp_text(std::int64_t ns) {
  const std::int64_t magnitude = ns < 0 ? -ns : ns;
  return fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", magnitude / 1'000'000'000, magnitude % 1'000'000'000);
}

}  // namespace palpate::device
