// World files: what is read can be written and read again, settings of an application included.
#include "fuzz/check.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::fuzz {
namespace {

// One that lets people set a field of every kind, in a section of its own and in one of the laboratory.
const scene::ApplicationRegistry& applications() {
  using scene::SettingKind;
  static const scene::ApplicationRegistry all = [] {
    scene::ApplicationSpec spec;
    spec.name = "game";
    spec.summary = "Has settings";
    spec.settings.fields = {
        {.section = "ball", .key = "mass_kg", .initial = std::vector<double>{0.0027}, .range = kPositive},
        {.section = "ball", .key = "contact_ms", .initial = std::vector<double>{4.0}, .unit = 1e-3},
        {.section = "ball",
         .key = "physics",
         .kind = SettingKind::choice,
         .initial = "full",
         .choices = {"full", "paper"}},
        {.section = "touch", .key = "mesh", .kind = SettingKind::file, .initial = ""},
        {.section = "touch", .key = "name", .kind = SettingKind::text, .initial = ""},
        {.section = "scene",
         .key = "bat_offset_m",
         .kind = SettingKind::numbers,
         .initial = std::vector<double>{0.0, 0.0, 0.0}}};
    spec.make_physics = [](const auto&, const auto&) { return nullptr; };
    spec.make_view = [](const auto&) { return nullptr; };
    return scene::ApplicationRegistry{spec};
  }();
  return all;
}

}  // namespace

Refusals worlds(std::string_view file) {
  Refusals refusals;
  const auto world = sim::config::parse_world(file, "world.toml", applications());
  if (!answered(world, refusals)) return refusals;
  const auto text = sim::config::world_text(*world);
  const auto again = sim::config::parse_world(text, "written.toml", applications());
  if (!again) std::fprintf(stderr, "%s\n", again.error().message.c_str());
  hold(again.has_value(), "a world that was read can be written and read again");
  return refusals;
}

}  // namespace palpate::fuzz
