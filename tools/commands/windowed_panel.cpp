#include "tools/commands/windowed_panel.h"

#include <memory>
#include <utility>

#include "palpate/desktop/session_shapes.h"

namespace palpate::tools::commands {

namespace session = calibration::session;
using desktop::SessionView;

WindowedPanel::WindowedPanel(TerminalPanel& terminal, desktop::SessionExchange& exchange)
    : terminal_(terminal), exchange_(exchange) {
  terminal_.set_more_keys([&exchange] { return exchange.take_key(); });
}

void WindowedPanel::show(const device::Request& request, const std::string& text) {
  exchange_.change([&](SessionView& view) {
    view.request = request;
    view.instruction = text;
    view.progress.clear();
    // The last pose is still told of while the next one is begun; a movement's time begins anew.
    if (request.gesture != device::Gesture::next_pose && request.gesture != device::Gesture::touch)
      view.taken_s.reset();
  });
  terminal_.show(request, text);
}

void WindowedPanel::tell(const std::string& line) {
  exchange_.change([&](SessionView& view) { view.progress = line; });
  terminal_.tell(line);
}

void WindowedPanel::observe(const session::PersonView& person) {
  exchange_.change([&](SessionView& view) { view.person = person; });
  terminal_.observe(person);
}

void WindowedPanel::taken() {
  exchange_.change([](SessionView& view) {
    view.taken_s = view.person.now_s;
    if (!view.request || view.request->gesture == device::Gesture::rest) return;
    ++view.taken;
    const auto tip = desktop::stylus_tip(view);
    if (view.request->gesture == device::Gesture::next_pose && tip && view.person.stylus.seen)
      view.held.emplace_back(view.person.stylus.translation + view.person.stylus.rotation * *tip);
  });
  terminal_.taken();
}

void WindowedPanel::begin_step(std::size_t step, std::size_t steps, const std::string& name) {
  exchange_.change([&](SessionView& view) {
    view.step = step;
    view.steps = steps;
    view.step_name = name;
    view.request.reset();
    view.instruction.clear();
    view.progress.clear();
    view.taken = 0;
    view.taken_s.reset();
    view.held.clear();
    view.guidance.clear();
    view.guided_of = 0;
  });
  terminal_.begin_step(step, steps, name);
}

session::Review WindowedPanel::review(const session::StepOutcome& outcome) {
  exchange_.change([&](SessionView& view) { view.outcome = outcome; });
  const auto answer = terminal_.review(outcome);
  exchange_.change([](SessionView& view) {
    view.outcome.reset();
    view.request.reset();
    view.instruction.clear();
  });
  return answer;
}

void WindowedPanel::guided(const session::GuidanceState& state, int of) {
  exchange_.change([&](SessionView& view) {
    view.guidance.push_back(state);
    view.guided_of = of;
  });
  terminal_.guided(state, of);
}

void WindowedPanel::show_rig(const rig::Rig& rig) {
  camera_after_tracker_s_ = rig.delays ? rig.delays->camera_after_tracker_s : 0.0;
  auto known = std::make_shared<const rig::Rig>(rig);
  exchange_.change([&](SessionView& view) { view.rig = std::move(known); });
}

void WindowedPanel::show_picture(const device::CameraImage& image, bool right, double now_s) {
  auto picture = std::make_shared<desktop::SessionPicture>();
  picture->image = image;
  picture->right = right;
  picture->marker = marker_.at(image, now_s, camera_after_tracker_s_);
  exchange_.change([&](SessionView& view) { view.picture = std::move(picture); });
}

}  // namespace palpate::tools::commands
