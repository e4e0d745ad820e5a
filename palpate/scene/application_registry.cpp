#include "palpate/scene/application_registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include "palpate/core/text.h"

namespace palpate::scene {
namespace {

bool is_name(std::string_view name) {
  const auto letter = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto part = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '-'; };
  return !name.empty() && name.size() <= ApplicationRegistry::kLongestName && letter(name.front()) &&
         std::all_of(name.begin(), name.end(), part);
}

// What a guest throws, in its name once.
std::string words_of(const std::string& name, const char* thrown) {
  const std::string_view said(thrown);
  return said.starts_with(name + ": ") ? std::string(said) : fmt::format("{}: {}", name, said);
}

template <typename Make, typename... Given>
auto guarded(const std::string& name, const char* part, const Make& make, const Given&... given)
    -> Expected<decltype(make(given...))> {
  try {
    auto made = make(given...);
    if (!made) return refused("{}: made no {}; one is expected", name, part);
    return made;
  } catch (const std::exception& thrown) {
    return refused("{}", words_of(name, thrown.what()));
  } catch (...) {
    return refused("{}: threw what is no std::exception when its {} was made", name, part);
  }
}

// One that can be pointed at.
bool is_mesh(const TriangleMesh& mesh) {
  return !mesh.triangles.empty() &&
         std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                     [](const auto& v) { return v.allFinite(); }) &&
         std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&mesh](const auto& t) {
           return std::all_of(t.begin(), t.end(), [&mesh](auto i) { return i < mesh.vertices.size(); });
         });
}

// "--long-name", in lower-case letters, digits and '-'.
bool is_option(std::string_view name) { return name.starts_with("--") && is_name(name.substr(2)); }

Expected<void> fits_in_a_message(const SceneDescription& scene) {
  if (scene.settings.bytes.size() > kMaxPayloadBytes)
    return refused("{}: its settings take {} bytes, at most {} are expected", scene.application,
                   scene.settings.bytes.size(), kMaxPayloadBytes);
  if (scene.bodies.size() > SceneState::kBodies)
    return refused("{}: it describes {} bodies, at most {} are expected", scene.application,
                   scene.bodies.size(), SceneState::kBodies);
  for (const auto& body : scene.bodies)
    if (body.name.size() > kLongestBodyName || !(body.mass >= 0.0 && std::isfinite(body.mass)))
      return refused(
          "{}: its body '{}' has a mass of {} kg; a name of at most {} bytes and a mass of 0 or more "
          "is expected",
          scene.application, excerpt(body.name), body.mass, kLongestBodyName);
  if (!scene.carried_offset.allFinite())
    return refused("{}: the place of what the stylus carries is not finite", scene.application);
  return {};
}

bool is_line(std::string_view text) { return !text.empty() && text.find('\n') == std::string_view::npos; }

// A CSV file's name, without a folder.
bool is_table(std::string_view file) {
  return file.ends_with(".csv") && file.size() > 4 && file.find('/') == file.npos && file.front() != '.';
}

}  // namespace

void ApplicationRegistry::add(ApplicationSpec spec) {
  const auto wrong = [&spec](const std::string& words) {
    return std::invalid_argument(fmt::format("application '{}': {}", excerpt(spec.name), words));
  };
  if (!is_name(spec.name))
    throw wrong(fmt::format(
        "a name of 1 to {} lower-case letters, digits and '-', a letter first, is expected", kLongestName));
  if (find(spec.name) != nullptr) throw wrong("another one has this name; choose a new one");
  if (!is_line(spec.summary)) throw wrong("a summary of one line is expected");
  if (!spec.make_physics) throw wrong("has no make_physics");
  if (!spec.make_view) throw wrong("has no make_view");
  SettingValues taken = settings();
  try {
    taken.add(spec.settings);
  } catch (const std::invalid_argument& twice) {
    throw wrong(twice.what());
  }
  for (const auto& option : spec.options)
    if (!is_option(option.name) || option.help.empty() || !option.apply)
      throw wrong(fmt::format("option '{}': a name like --mesh, a help text and what it does are expected",
                              excerpt(option.name)));
  for (const auto& table : spec.tables)
    if (!is_table(table.file))
      throw wrong(fmt::format("table '{}': a file name that ends in .csv is expected", excerpt(table.file)));
  for (const auto& study : spec.studies) {
    if (!is_name(study.name) || !is_line(study.summary) || !study.run)
      throw wrong(fmt::format(
          "study '{}': a name as applications have, a summary of one line and what it runs are expected",
          excerpt(study.name)));
    for (const auto& other : specs_)
      for (const auto& known : other.studies)
        if (known.name == study.name)
          throw wrong(fmt::format("study '{}': another one has this name", study.name));
  }
  specs_.push_back(std::move(spec));
}

const ApplicationSpec* ApplicationRegistry::find(std::string_view name) const {
  const auto at =
      std::find_if(specs_.begin(), specs_.end(), [name](const auto& spec) { return spec.name == name; });
  return at == specs_.end() ? nullptr : &*at;
}

std::vector<std::string> ApplicationRegistry::names() const {
  std::vector<std::string> names;
  for (const auto& spec : specs_) names.push_back(spec.name);
  return names;
}

const Handling& ApplicationRegistry::handling(std::string_view name) const {
  static const Handling bare_stylus;
  const ApplicationSpec* spec = find(name);
  return spec == nullptr ? bare_stylus : spec->handling;
}

SettingValues ApplicationRegistry::settings() const {
  SettingValues values;
  for (const auto& spec : specs_) values.add(spec.settings);
  return values;
}

std::vector<SettingComplaint> ApplicationRegistry::complaints(const SettingValues& values) const {
  std::vector<SettingComplaint> all;
  for (const auto& spec : specs_) {
    if (!spec.settings.relations) continue;
    for (auto& complaint : spec.settings.relations(values)) all.push_back(std::move(complaint));
  }
  return all;
}

Expected<SceneDescription> ApplicationRegistry::describe(std::string_view application,
                                                         const SettingValues& values) const {
  const auto spec = known(application);
  if (!spec) return tl::unexpected(spec.error());
  SettingValues own((*spec)->settings);
  own.take(values);
  if (auto fine = check((*spec)->settings, own); !fine) return tl::unexpected(fine.error());
  SceneDescription scene;
  scene.application = (*spec)->name;
  const auto described = guarded((*spec)->name, "description", [&]() -> std::optional<SceneDescription> {
    if ((*spec)->describe)
      (*spec)->describe(own, scene);
    else
      scene.settings = to_payload((*spec)->settings, own);
    return scene;
  });
  if (!described) return tl::unexpected(described.error());
  if (auto fine = fits_in_a_message(**described); !fine) return tl::unexpected(fine.error());
  return **described;
}

Expected<const ApplicationSpec*> ApplicationRegistry::known(std::string_view name) const {
  if (const ApplicationSpec* spec = find(name)) return spec;
  return wrong_use("application '{}' is not known; there are: {}", excerpt(name),
                   specs_.empty() ? "none" : fmt::format("{}", fmt::join(names(), ", ")));
}

Expected<const ApplicationSpec*> ApplicationRegistry::ready(const SceneDescription& scene) const {
  const auto found = known(scene.application);
  if (!found) return found;
  const ApplicationSpec* spec = *found;
  for (const auto& needed : spec->surfaces)
    if (std::none_of(scene.surfaces.begin(), scene.surfaces.end(),
                     [&needed](const auto& surface) { return surface.name == needed; }))
      return refused("{}: the rig has no calibrated surface '{}'; run `palpate calibrate surface`",
                     spec->name, needed);
  return spec;
}

Expected<std::unique_ptr<Application>> ApplicationRegistry::make_physics(const SceneDescription& scene,
                                                                         const RunSettings& run) const {
  const auto spec = ready(scene);
  if (!spec) return tl::unexpected(spec.error());
  return guarded((*spec)->name, "physics side", (*spec)->make_physics, scene, run);
}

Expected<std::unique_ptr<SceneView>> ApplicationRegistry::make_view(const SceneDescription& scene) const {
  const auto spec = ready(scene);
  if (!spec) return tl::unexpected(spec.error());
  return guarded((*spec)->name, "view", (*spec)->make_view, scene);
}

Expected<std::unique_ptr<Player>> ApplicationRegistry::make_player(const SceneDescription& scene,
                                                                   const Reach& reach,
                                                                   const PlayerSettings& settings) const {
  const auto spec = ready(scene);
  if (!spec) return tl::unexpected(spec.error());
  if (!(*spec)->make_player)
    return refused("{}: has no scripted player; only a person at a window or an arm can play it",
                   (*spec)->name);
  return guarded((*spec)->name, "player", (*spec)->make_player, scene, reach, settings);
}

Expected<std::unique_ptr<InputAssist>> ApplicationRegistry::make_input_assist(
    const SceneDescription& scene, const Reach& reach, const PlayerSettings& settings) const {
  const auto spec = ready(scene);
  if (!spec) return tl::unexpected(spec.error());
  if (!(*spec)->make_input_assist) return nullptr;
  return guarded((*spec)->name, "help for the mouse", (*spec)->make_input_assist, scene, reach, settings);
}

Expected<std::optional<ExploredSurface>> ApplicationRegistry::explored(const SceneDescription& scene) const {
  const auto spec = ready(scene);
  if (!spec) return tl::unexpected(spec.error());
  if (!(*spec)->explored) return std::optional<ExploredSurface>();
  auto made = guarded((*spec)->name, "surface to explore",
                      [&] { return std::optional<ExploredSurface>((*spec)->explored(scene)); });
  if (made && !is_mesh((*made)->mesh))
    return refused("{}: its surface to explore is no mesh; triangles of finite vertices are expected",
                   (*spec)->name);
  return made;
}

Expected<std::unique_ptr<PlayRecord>> ApplicationRegistry::make_record(const SceneDescription& scene) const {
  const auto spec = ready(scene);
  if (!spec) return tl::unexpected(spec.error());
  if (!(*spec)->make_record) return std::make_unique<PlayRecord>();
  return guarded((*spec)->name, "record", (*spec)->make_record, scene);
}

Expected<SceneState> ApplicationRegistry::example_state(const SceneDescription& scene,
                                                        const Pose<World, Tip>& X_world_tip) const {
  const auto spec = ready(scene);
  if (!spec) return tl::unexpected(spec.error());
  const auto state = guarded((*spec)->name, "state", [&]() -> std::optional<SceneState> {
    if ((*spec)->example_state) return (*spec)->example_state(scene, X_world_tip);
    const auto physics = (*spec)->make_physics(scene, {.keeps_files = false});
    if (!physics) return std::nullopt;
    constexpr Duration kTick = std::chrono::milliseconds(1);
    const Instant<PhysicsClock> now{kTick};
    SceneState begun;
    begun.time = now;
    physics->step(now, kTick, {.time = now, .X_world_tip = X_world_tip}, begun);
    return begun;
  });
  if (!state) return tl::unexpected(state.error());
  return **state;
}

Expected<std::shared_ptr<const Shape>> ApplicationRegistry::example_shape(const SceneDescription& scene,
                                                                          const SceneState& state) const {
  const auto spec = ready(scene);
  if (!spec) return tl::unexpected(spec.error());
  if (!(*spec)->example_shape) return nullptr;
  auto shape = guarded((*spec)->name, "shape", [&] {
    return std::make_shared<const Shape>(Shape{state.time, (*spec)->example_shape(scene, state)});
  });
  if (!shape) return tl::unexpected(shape.error());
  return std::move(*shape);
}

}  // namespace palpate::scene
