// palpate._live: a running session. Its Python side is palpate/_client.py.
#include <algorithm>

#include "python/bindings/conversions.h"
#include "python/bindings/live_client.h"

namespace palpate::python {
namespace {

constexpr Duration kSignalsEvery = std::chrono::milliseconds(50);

// Waits until `done()`, as long as it may, without Python's lock; False: the time is over. Ctrl-C ends it. It looks when the
// client's thread has done something, or every `pause`.
template <typename Done>
bool waited(LiveClient& client, double patience_s, const Done& done, Duration pause = {}) {
  const auto until = client.now() + seconds(patience_s);
  for (;;) {
    const bool come = unlocked([&] {
      const auto turn = std::min(until, client.now() + kSignalsEvery);
      while (!client.closed() && client.now() < turn) {
        if (done()) return true;
        if (pause > Duration(0))
          std::this_thread::sleep_for(pause);
        else
          client.wait(turn - client.now());
      }
      return done();
    });
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (come || client.closed()) return come;
    if (client.now() >= until) return false;
  }
}

// A number of each state for each column; three or four of each body.
class Columns {
 public:
  explicit Columns(const std::vector<scene::SceneState>& states)
      : states_(states), bodies_(states.empty() ? 0 : static_cast<py::ssize_t>(states.front().body_count)) {}

  template <typename T, typename Of>
  void number(const char* name, Of&& of) {
    fill<T>(name, {rows()},
            [&](const scene::SceneState& state, T*& to) { *to++ = static_cast<T>(of(state)); });
  }
  template <typename T, typename Of>
  void list(const char* name, Of&& of) {
    const auto width = static_cast<py::ssize_t>(of(scene::SceneState{}).size());
    fill<T>(name, {rows(), width}, [&](const scene::SceneState& state, T*& to) {
      for (const auto number : of(state)) *to++ = static_cast<T>(number);
    });
  }
  template <typename T, typename Of>
  void body_number(const char* name, Of&& of) {
    fill<T>(name, {rows(), bodies_}, [&](const scene::SceneState& state, T*& to) {
      for_bodies(state, [&](const scene::BodyState& body) { *to++ = static_cast<T>(of(body)); });
    });
  }
  template <typename Of>
  void body_list(const char* name, Of&& of) {
    const auto width = static_cast<py::ssize_t>(of(scene::BodyState{}).size());
    fill<double>(name, {rows(), bodies_, width}, [&](const scene::SceneState& state, double*& to) {
      for_bodies(state, [&](const scene::BodyState& body) {
        for (const double number : of(body)) *to++ = number;
      });
    });
  }
  py::dict fields;

 private:
  py::ssize_t rows() const { return static_cast<py::ssize_t>(states_.size()); }
  template <typename T, typename Put>
  void fill(const char* name, const std::vector<py::ssize_t>& shape, const Put& put) {
    py::array_t<T> array(shape);
    T* to = array.mutable_data();
    for (const auto& state : states_) put(state, to);
    fields[name] = read_only(std::move(array));
  }
  template <typename Put>
  void for_bodies(const scene::SceneState& state, const Put& put) {
    for (py::ssize_t i = 0; i < bodies_; ++i) put(state.bodies[static_cast<std::size_t>(i)]);
  }

  const std::vector<scene::SceneState>& states_;
  py::ssize_t bodies_;
};

py::dict columns_of(const std::vector<scene::SceneState>& states) {
  using scene::BodyState, scene::SceneState;
  Columns columns(states);
  columns.number<std::int64_t>("time_ns", [](const SceneState& s) { return s.time.ns(); });
  columns.number<std::uint64_t>("tick", [](const SceneState& s) { return s.tick; });
  columns.list<std::int32_t>("counters", [](const SceneState& s) { return s.counters; });
  columns.list<double>("impact_force", [](const SceneState& s) { return s.impact.force; });
  columns.list<double>("impact_point", [](const SceneState& s) { return s.impact.point; });
  columns.number<double>("impact_share", [](const SceneState& s) { return s.impact.share; });
  columns.list<double>("continuous_force", [](const SceneState& s) { return s.continuous.force; });
  columns.list<double>("touching_point", [](const SceneState& s) { return s.continuous.point; });
  columns.number<bool>("touching", [](const SceneState& s) { return s.continuous.touching != 0; });
  columns.body_list("positions", [](const BodyState& b) { return b.position; });
  columns.body_list("orientations", [](const BodyState& b) { return b.orientation; });
  columns.body_list("velocities", [](const BodyState& b) { return b.velocity; });
  columns.body_list("angular_velocities", [](const BodyState& b) { return b.angular_velocity; });
  columns.body_number<std::uint32_t>("jumps", [](const BodyState& b) { return b.jumps; });
  columns.body_number<bool>("visible", [](const BodyState& b) { return b.visible != 0; });
  return columns.fields;
}

const char* name_of(AnswerKind kind) {
  switch (kind) {
    case AnswerKind::exact:
      return "exact";
    case AnswerKind::interpolated:
      return "interpolated";
    case AnswerKind::extrapolated:
      return "extrapolated";
    case AnswerKind::too_old:
      return "too_old";
    case AnswerKind::too_new:
      break;
  }
  return "too_new";
}

py::dict state_fields(const scene::StateAnswer& answer, bool newest) {
  py::dict fields;
  fields["columns"] = columns_of({answer.state});
  fields["kind"] = newest ? "exact" : name_of(answer.kind);
  fields["extrapolated_by"] = newest ? 0.0 : to_seconds(answer.extrapolated_by);
  return fields;
}

py::object state(LiveClient& client, std::optional<std::int64_t> time_ns, double patience_s) {
  const auto number = client.ask(time_ns ? std::optional(Time{Duration(*time_ns)}) : std::nullopt);
  std::optional<transport::StateReply> reply;
  try {
    waited(client, patience_s, [&] { return (reply = client.answer(number)).has_value(); });
  } catch (...) {
    client.forget(number);
    throw;
  }
  client.forget(number);
  if (!reply) return py::none();
  return state_fields(reply->answer, !time_ns);
}

py::object next_block(LiveClient& client, StepQueue& steps, double span_s, double patience_s) {
  std::optional<StepBlock> block;
  waited(client, patience_s, [&] { return (block = client.take_steps(steps, seconds(span_s))).has_value(); });
  if (!block) return py::none();
  return py::make_tuple(columns_of(block->steps), block->restarted);
}

py::object next_watched(LiveClient& client, LiveWatch& watch, double pause_s, double patience_s) {
  std::optional<transport::StateReply> reply;
  waited(
      client, patience_s, [&] { return (reply = watch.take()).has_value(); }, seconds(pause_s));
  if (!reply) return py::none();
  return state_fields(reply->answer, false);
}

py::object facts_of(const LiveClient& client) {
  const ServerFacts facts = client.facts();
  py::dict fields;
  fields["alive"] = facts.alive;
  fields["trouble"] = facts.trouble;
  fields["session"] = facts.session;
  fields["role"] =
      facts.role ? py::object(py::str(std::string(transport::role_name(*facts.role)))) : py::none();
  if (!facts.scene) return fields;
  const scene::SceneDescription& scene = *facts.scene;
  fields["application"] = scene.application;
  fields["gravity"] = list_of(scene.gravity);
  fields["carried_offset"] = list_of(scene.carried_offset);
  fields["settings"] = py::bytes(scene.settings.bytes);
  py::list bodies, surfaces;
  for (const auto& body : scene.bodies) bodies.append(py::make_tuple(body.name, body.mass));
  for (const auto& surface : scene.surfaces)
    surfaces.append(py::make_tuple(surface.name, rows_of({surface.corners.begin(), surface.corners.end()})));
  fields["bodies"] = bodies;
  fields["surfaces"] = surfaces;
  return fields;
}

py::object clock_of(LiveClient& client, double patience_s) {
  ClockFacts facts;
  if (!waited(client, patience_s, [&] { return (facts = client.clock()).phase != ClockPhase::empty; }))
    return py::none();
  const auto now = client.now();
  py::dict fields;
  fields["settled"] = facts.phase == ClockPhase::tracking;
  fields["local_ns"] = now.ns();
  fields["server_ns"] = facts.model.to(now).ns();
  fields["drift"] = 1e-6 * facts.model.drift_ppm();
  fields["uncertainty"] = to_seconds(facts.model.uncertainty(now));
  fields["round_trip"] = facts.lowest_round_trip_s;
  return fields;
}

std::optional<scene::Control> control_named(const std::string& name) {
  if (name == "begin") return scene::Control::begin;
  if (name == "reset") return scene::Control::reset;
  if (name == "pause") return scene::Control::pause;
  if (name == "resume") return scene::Control::resume;
  return std::nullopt;
}

bool may(const std::string& role, const std::string& control) {
  const auto named = transport::role_named(role);
  return named && transport::may(*named, control_named(control).value_or(scene::Control::none));
}

// What became of it: "taken", "dropped" or "closed".
std::string control(LiveClient& client, const std::string& name) {
  const auto dropped = client.controls_dropped();
  const double patience_s = 1.0 + to_seconds(transport::StateLink::kControlKept);
  if (!client.send_control(control_named(name).value_or(scene::Control::none))) return "closed";
  if (!waited(client, patience_s, [&] { return client.controls_waiting() == 0; })) return "dropped";
  if (client.closed()) return "closed";
  return client.controls_dropped() == dropped ? "taken" : "dropped";
}

std::shared_ptr<LiveClient> connect(const std::string& address, bool insecure, const std::string& keys,
                                    const std::string& server_key, const std::string& name) {
  return value_or_raise(LiveClient::connect(
      {.address = address, .insecure = insecure, .keys = keys, .server_key = server_key}, name));
}

}  // namespace

PYBIND11_MODULE(_live, module) {
  raise_failures();
  module.def("may", &may);
  py::class_<StepQueue, std::shared_ptr<StepQueue>>(module, "Steps");
  py::class_<LiveWatch, std::shared_ptr<LiveWatch>>(module, "Watch")
      .def("refusal", &LiveWatch::refusal)
      .def("counts", [](const LiveWatch& watch) {
        const auto counts = watch.counters();
        return py::make_tuple(counts.skipped, counts.missed);
      });
  const auto free = py::call_guard<py::gil_scoped_release>();
  py::class_<LiveClient, std::shared_ptr<LiveClient>>(module, "Client")
      .def(py::init(&connect))
      .def("address", [](const LiveClient& client) { return client.place().endpoint.address; })
      .def("close", &LiveClient::close, free)
      .def("closed", &LiveClient::closed, free)
      .def("facts", &facts_of)
      .def("clock", &clock_of)
      .def("wait_for_scene",
           [](LiveClient& client, double patience_s) {
             return waited(client, patience_s, [&] { return client.facts().scene.has_value(); });
           })
      .def("state", &state)
      .def("control", &control)
      .def("begin_steps", &LiveClient::begin_steps, free)
      .def("next_block", &next_block)
      .def("end_steps", &LiveClient::end_steps, free)
      .def("begin_watch",
           [](LiveClient& client, int rate_hz) { return value_or_raise(client.begin_watch(rate_hz)); })
      .def("next_watched", &next_watched)
      .def("end_watch", &LiveClient::end_watch, free);
}

}  // namespace palpate::python
