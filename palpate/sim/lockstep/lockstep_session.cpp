#include "palpate/sim/lockstep/lockstep_session.h"

#include "palpate/evaluation/overlay_of_play.h"
#include "palpate/scene/mesh_asset.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/lockstep/internal/play_events.h"
#include "palpate/sim/lockstep/play_figures.h"
#include "palpate/sim/truth_rig.h"

namespace palpate::sim::lockstep {
namespace {

// Of the application alone, as they are used.
Json settings_json(const SessionRequest& request) {
  Json json = Json::object();
  for (const auto& field : request.applications.find(request.application)->settings.fields) {
    const auto& value = request.world.settings.at(field.name()).value;
    if (const auto* numbers = std::get_if<std::vector<double>>(&value))
      json[field.name()] = field.kind == scene::SettingKind::number ? Json(numbers->front()) : Json(*numbers);
    else
      json[field.name()] = std::get<std::string>(value);
  }
  return json;
}

LockstepOptions options_of(const SessionRequest& request) {
  LockstepOptions options;
  options.applications = request.applications;
  options.seconds = request.seconds;
  options.seed = request.seed;
  options.channel = request.channel;
  options.player_extra_delay_s = request.player_extra_delay_s;
  options.graphics = graphics_settings(request.world);
  options.extra_force_delay = seconds(request.world.display.extra_force_delay_s);
  options.record = request.record;
  return options;
}

Expected<Json> figures_of(const SessionRequest& request, const Simulator& world, const rig::Rig& rig,
                          const LockstepResult& play, const Json& of_the_application, const Json& events) {
  Json figures = {{"application", request.application},
                  {"seed", request.seed},
                  {"seconds", request.seconds},
                  {"rig", request.rig ? "given" : "truth"},
                  {"settings", settings_json(request)}};
  figures["registration"] = evaluation::overlay_figures(evaluation::overlay_of_play(
      play.frames, rig.camera->model, evaluation::check_points(world.truth(), rig)));
  figures["exchange"] = exchange_figures(play);
  figures["force"] = force_figures(play.haptic, request.world.arm.max_force);
  figures["player"] = player_figures(request.world);
  figures["events"] = events;
  for (const auto& [key, part] : of_the_application.items()) {
    if (figures.contains(key))
      return refused("{}: its summary has the key '{}', which is the system's", request.application, key);
    figures[key] = part;
  }
  return figures;
}

void tell_of_another_laboratory(const rig::Rig& rig, const Simulator& world,
                                std::vector<scene::ClosingLine>& lines) {
  const double away = away_from_laboratory(*rig.arm, world);
  if (away > kOtherLaboratory)
    lines.push_back(
        {"rig", fmt::format("warning: its arm is {:.0f} mm from this laboratory's; a rig is played with the "
                            "--seed and --world that it was calibrated in",
                            1e3 * away)});
}

}  // namespace

Expected<SessionOutcome> run_session(const SessionRequest& request) {
  auto described = config::scene_of(request.world, request.applications, request.application);
  if (!described) return tl::unexpected(described.error());
  if (auto mesh = scene::read_mesh_asset(*described); !mesh) return tl::unexpected(mesh.error());
  if (!request.rig && request.world.states_place())
    return wrong_use(
        "the laboratory's arm states its place, and no rig is without its errors; a rig that was calibrated "
        "with "
        "it is expected (--rig FILE)");
  Simulator world(request.world, request.seed);
  const rig::Rig rig = request.rig ? *request.rig : truth_rig(world);
  const bool cartesian = rig.arm && rig.arm->model.kind == device::ArmModel::Kind::cartesian;
  if (cartesian != request.world.states_place())
    return wrong_use("the rig's arm {} {}, the laboratory's {}; a rig of this laboratory's arm is expected",
                     rig.arm ? rig.arm->model.name : "", cartesian ? "states its place" : "has joints",
                     request.world.states_place() ? "states its place" : "has joints");
  const auto scene = server::physics::scene_from_rig(rig, *described);
  const auto record = request.applications.make_record(scene);
  if (!record) return tl::unexpected(record.error());
  PlayEvents events(scene.bodies);
  LockstepOptions options = options_of(request);
  options.watch = [&](const scene::SceneState& state) {
    (*record)->add_state(state);
    events.add(state);
  };
  options.conditions = [&](double since_s, const std::vector<server::graphics::Condition>& conditions) {
    if (since_s > options.warm_up_s) events.add(since_s - options.warm_up_s, conditions);
  };
  const auto play = play_in_lockstep(world, rig, scene, options, {}, request.progress);
  if (!play) return tl::unexpected(play.error());
  auto figures = figures_of(request, world, rig, *play, (*record)->summary(), events.told());
  if (!figures) return tl::unexpected(figures.error());
  SessionOutcome outcome{*figures, (*record)->closing_lines(*figures)};
  tell_of_another_laboratory(rig, world, outcome.lines);
  return outcome;
}

}  // namespace palpate::sim::lockstep
