#include "drivers/haply/protocol.h"

#include <cmath>

#include "palpate/core/text.h"

namespace palpate::drivers::haply {
namespace {

constexpr double kFarthest = 10.0;  // m, N and what else is a vector: beyond it nothing is meant
constexpr double kMostForce = 1000.0;
constexpr std::size_t kLongestId = 64;

// Null where there is none.
const Json* part(const Json& json, const char* key) {
  if (!json.is_object()) return nullptr;
  const auto found = json.find(key);
  return found == json.end() ? nullptr : &*found;
}

std::optional<double> number(const Json& json, const char* key) {
  const Json* found = part(json, key);
  if (found == nullptr || !found->is_number()) return std::nullopt;
  const double value = found->get<double>();
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<bool> truth(const Json& json, const char* key) {
  const Json* found = part(json, key);
  return found != nullptr && found->is_boolean() ? std::optional(found->get<bool>()) : std::nullopt;
}

// {x, y, z}; a coordinate that is left out is 0, as the service leaves out what is.
std::optional<Vector3> vector(const Json& json, const char* key, double most) {
  const Json* found = part(json, key);
  if (found == nullptr || !found->is_object()) return std::nullopt;
  Vector3 v = Vector3::Zero();
  constexpr const char* kAxes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    if (part(*found, kAxes[i]) == nullptr) continue;
    const auto value = number(*found, kAxes[i]);
    if (!value) return std::nullopt;
    v[i] = *value;
  }
  return v.cwiseAbs().maxCoeff() <= most ? std::optional(v) : std::nullopt;
}

// What is left out is as in the identity.
std::optional<Quaternion> rotation(const Json& json, const char* key) {
  const Json* found = part(json, key);
  if (found == nullptr || !found->is_object()) return std::nullopt;
  const auto or_identity = [&](const char* name, double identity) {
    return part(*found, name) == nullptr ? std::optional(identity) : number(*found, name);
  };
  const auto w = or_identity("w", 1.0), x = or_identity("x", 0.0), y = or_identity("y", 0.0),
             z = or_identity("z", 0.0);
  if (!w || !x || !y || !z) return std::nullopt;
  const Quaternion q(*w, *x, *y, *z);
  constexpr double kUnitWithin = 0.05;
  return std::abs(q.norm() - 1.0) <= kUnitWithin ? std::optional(q.normalized()) : std::nullopt;
}

Expected<std::string> id_of(const Json& device, const char* what) {
  const Json* found = part(device, "device_id");
  if (found == nullptr || !found->is_string() || found->get_ref<const std::string&>().empty() ||
      found->get_ref<const std::string&>().size() > kLongestId)
    return refused("{}: has no device_id; a short text is expected", what);
  return one_line(found->get<std::string>());
}

Expected<ArmState> arm_of(const Json& device) {
  const auto id = id_of(device, "inverse3");
  if (!id) return tl::unexpected(id.error());
  ArmState arm;
  arm.id = *id;
  static const Json nothing;
  const Json* state = part(device, "state");
  const Json* status = part(device, "status");
  const auto place = vector(state == nullptr ? nothing : *state, "cursor_position", kFarthest);
  if (!place)
    return refused("inverse3 {}: state.cursor_position is no place; x, y and z in metres are expected", *id);
  arm.place = *place;
  arm.force = vector(*state, "current_cursor_force", kMostForce);
  if (status != nullptr) {
    arm.calibrated = truth(*status, "calibrated");
    arm.powered = truth(*status, "power_supply");
  }
  if (const Json* config = part(device, "config")) arm.config = *config;
  return arm;
}

Expected<GripState> grip_of(const Json& device) {
  const auto id = id_of(device, "verse_grip");
  if (!id) return tl::unexpected(id.error());
  GripState grip;
  grip.id = *id;
  const Json* state = part(device, "state");
  const auto turn = state == nullptr ? std::nullopt : rotation(*state, "orientation");
  if (!turn) return refused("verse_grip {}: state.orientation is no unit quaternion, as is expected", *id);
  grip.orientation = *turn;
  if (const Json* buttons = part(*state, "buttons")) {
    constexpr const char* kButtons[] = {"a", "b", "c"};
    for (std::uint32_t i = 0; i < 3; ++i)
      if (truth(*buttons, kButtons[i]).value_or(false)) grip.buttons |= 1u << i;
  }
  return grip;
}

Json vector_json(const Vector3& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

const Json kIdentity = {{"position", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}},
                        {"rotation", {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}}},
                        {"scale", {{"x", 1.0}, {"y", 1.0}, {"z", 1.0}}}};

// The service leaves out what is as it is by default.
bool is_identity(const Json& mount) {
  const auto differs = [](const std::optional<Vector3>& v, const Vector3& expected) {
    return v && (*v - expected).norm() > 1e-9;
  };
  const Json* inner = part(mount, "transform");
  const Json& of = inner == nullptr ? mount : *inner;
  if (differs(vector(of, "position", kFarthest), Vector3::Zero())) return false;
  if (part(of, "scale") != nullptr && differs(vector(of, "scale", kFarthest), Vector3::Ones())) return false;
  if (const auto turn = rotation(of, "rotation")) return turn->angularDistance(Quaternion::Identity()) < 1e-9;
  return true;
}

}  // namespace

Expected<ServiceState> read_state(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object())
    return refused("the service says '{}'; a JSON object is expected", excerpt(text, 60));
  ServiceState state;
  if (const Json* arms = part(json, "inverse3"); arms != nullptr && arms->is_array())
    for (const auto& device : *arms) {
      auto arm = arm_of(device);
      if (!arm) return tl::unexpected(arm.error());
      state.arms.push_back(std::move(*arm));
    }
  for (const char* kind : {"verse_grip", "wireless_verse_grip"})
    if (const Json* grips = part(json, kind); grips != nullptr && grips->is_array())
      for (const auto& device : *grips)
        // One that sleeps tells no turn, which is no fault of the arm.
        if (auto grip = grip_of(device)) state.grips.push_back(std::move(*grip));
  return state;
}

std::string hello(const std::string& arm) {
  const Json json = {
      {"session",
       {{"configure", {{"profile", {{"name", "org.palpate"}}}, {"basis", {{"permutation", "XYZ"}}}}},
        {"force_render_full_state", Json::object()}}},
      {"inverse3",
       Json::array(
           {{{"device_id", arm},
             {"configure", {{"mount", {{"transform", kIdentity}}}}},
             {"commands",
              {{"set_cursor_force",
                {{"vector", vector_json(Vector3::Zero())}, {"values", vector_json(Vector3::Zero())}}}}}}})}};
  return json.dump();
}

Expected<void> check_configured(const ArmState& arm) {
  if (!arm.config.is_object())
    return refused(
        "inverse3 {}: the service does not tell how it is configured; version 3.4 or later of it is expected",
        arm.id);
  if (const Json* basis = part(arm.config, "basis")) {
    const Json* axes = part(*basis, "permutation");
    if (axes != nullptr && axes->is_string() && axes->get_ref<const std::string&>() != "XYZ")
      return refused(
          "inverse3 {}: the service keeps the axes {}; XYZ is expected, end other programs that use it",
          arm.id, excerpt(axes->get<std::string>(), 20));
  }
  if (const Json* mount = part(arm.config, "mount"); mount != nullptr && !is_identity(*mount))
    return refused(
        "inverse3 {}: the service keeps a mount that moves or scales its places; none is expected, end other "
        "programs that use it",
        arm.id);
  return {};
}

std::string force_command(const std::string& arm, const Vector3& force) {
  const Json vector = vector_json(force);
  const Json json = {
      {"inverse3",
       Json::array({{{"device_id", arm},
                     {"commands", {{"set_cursor_force", {{"vector", vector}, {"values", vector}}}}}}})}};
  return json.dump();
}

}  // namespace palpate::drivers::haply
