// World files: what is read can be written and read again.
#include "fuzz/check.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::fuzz {

Refusals worlds(std::string_view file) {
  Refusals refusals;
  const auto world = sim::config::parse_world(file, "world.toml");
  if (!answered(world, refusals)) return refusals;
  const auto text = sim::config::world_text(*world);
  const auto again = sim::config::parse_world(text, "written.toml");
  if (!again) std::fprintf(stderr, "%s\n", again.error().message.c_str());
  hold(again.has_value(), "a world that was read can be written and read again");
  return refusals;
}

}  // namespace palpate::fuzz
