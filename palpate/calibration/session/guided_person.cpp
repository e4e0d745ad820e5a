#include "palpate/calibration/session/guided_person.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>

#include "palpate/math/place_text.h"

namespace palpate::calibration::session {
namespace {

using device::Gesture;

constexpr double kTold = 0.2;       // s between lines of progress
constexpr double kObserved = 0.05;  // s between views
constexpr double kNear = 0.05;      // m: about where it was shown
const double kTurnedAlike = radians_from_degrees(25.0);
constexpr double kSaid = 0.01;  // m: less is not told

constexpr const char* kBegin = " Enter when it has begun.";

// World: x to the right, y up, z towards a person who faces the tracker.
std::string way(const Vector3& offset) {
  constexpr std::array<std::array<const char*, 2>, 3> kWords{
      {{"to the left", "to the right"}, {"down", "up"}, {"away from you", "towards you"}}};
  std::string words;
  for (Eigen::Index k = 0; k < 3; ++k)
    if (std::abs(offset[k]) > kSaid)
      words += fmt::format("{}{:.0f} cm {}", words.empty() ? "" : ", ", 100.0 * std::abs(offset[k]),
                           kWords[static_cast<std::size_t>(k)][offset[k] > 0.0 ? 1 : 0]);
  return words;
}

Point<World> tip_of(const device::TrackerSample& marker, const device::PoseTarget& target) {
  return {marker.translation + marker.rotation * target.tip_in_marker};
}

SeenMarker seen_marker(const Stillness& marker) {
  const auto newest = marker.newest();
  if (!newest) return {};
  return {true, marker.still(), newest->rotation, newest->translation};
}

}  // namespace

std::string instruction(const device::Request& request) {
  switch (request.gesture) {
    case Gesture::rest:
      return "Put the arm into its rest position and the pointer down. Enter when they are.";
    case Gesture::next_pose:
      return request.target
                 ? fmt::format(
                       "Bring the stylus' tip to the place that is shown, {} in World, and hold it still, "
                       "its "
                       "marker towards the tracker; it counts by itself. s: another place; Enter: take it "
                       "where it is.",
                       place_text_mm(request.target->tip.m, 0))
                 : std::string(
                       "Hold the stylus still in a pose unlike those before, anywhere in its reach, its "
                       "marker "
                       "towards the tracker; it counts by itself.");
    case Gesture::swing_stylus:
      return (request.what == "hollow"
                  ? std::string(
                        "Rest the stylus' tip in a hollow and swing its marker widely in all directions.")
                  : std::string(
                        "Swing the stylus' marker widely in all directions; the arm holds its tip.")) +
             kBegin;
    case Gesture::wander:
      return std::string("Move the stylus freely through its whole reach, its marker towards the tracker.") +
             kBegin;
    case Gesture::swing_pointer:
      return std::string("Rest the pointer's tip in a hollow and swing it widely in all directions.") +
             kBegin;
    case Gesture::touch:
      return request.what == "landmark"
                 ? fmt::format("Hold the pointer's tip on the middle of landmark {} and press Enter{}.",
                               request.index + 1, request.known ? "" : "; n: there are no more")
                 : fmt::format("Hold the pointer's tip on corner {} of the {} and press Enter.",
                               request.index + 1, request.what);
    case Gesture::look_around_board:
      return std::string(
                 "Lay the board where it stays, and look at it from all sides, near and far, tilting the "
                 "head.") +
             kBegin;
    case Gesture::look:
      return std::string("Look at the scene as in use, and move the head slowly.") + kBegin;
    case Gesture::hold:
      return "Now the arm's forces: in five poses, a hand's breadth apart, it pushes the tip by at most 0.5 "
             "N, and only while you hold the key (the space bar, or the stylus' button that --key-button "
             "names). Hold the stylus lightly, as a pen, "
             "about the middle of its reach. Enter when you do; n: not today, forces stay off.";
  }
  return "";
}

GuidedPerson::GuidedPerson(Panel& panel, StillnessSettings settings)
    : panel_(panel),
      stylus_(device::MarkerId::tip_marker, settings),
      pointer_(device::MarkerId::pointer, settings),
      head_(device::MarkerId::camera_marker, settings) {}

Expected<void> GuidedPerson::ask(const device::Request& request) {
  // Where the stylus lies before the first pose is no pose of the person's choice.
  if (request.gesture == Gesture::next_pose && request_.gesture != Gesture::next_pose) stylus_.take();
  // What was pressed before the person could read this was meant for something else.
  while (const auto key = panel_.key())
    if (*key == PanelKey::stop) return tl::unexpected(answer(*key).error());
  request_ = request;
  pressed_ = false;
  told_s_ = -1.0;
  std::string text = instruction(request_);
  if (request.gesture == Gesture::touch && !touched_.emplace(request.what, request.index).second)
    text = fmt::format("Once more: {}{}",
                       static_cast<char>(std::tolower(static_cast<unsigned char>(text[0]))), text.substr(1));
  panel_.show(request_, text);
  return {};
}

Expected<void> GuidedPerson::release() {
  request_ = {};
  pressed_ = false;
  panel_.released();
  return {};
}

Stillness& GuidedPerson::watched() {
  switch (request_.gesture) {
    case Gesture::touch:
    case Gesture::swing_pointer:
      return pointer_;
    case Gesture::look_around_board:
    case Gesture::look:
      return head_;
    default:
      return stylus_;
  }
}

Expected<bool> GuidedPerson::answer(PanelKey key) {
  switch (key) {
    case PanelKey::proceed:
      pressed_ = true;
      break;
    case PanelKey::no_more:
      if (request_.gesture == Gesture::touch && request_.what == "landmark" && !request_.known)
        return refused(ErrorCode::no_more, "landmark {}: there are no more", request_.index + 1);
      if (request_.gesture == Gesture::hold) return refused(ErrorCode::no_more, "forces: not today");
      break;
    case PanelKey::skip:
      if (request_.gesture == Gesture::next_pose)
        return refused(ErrorCode::out_of_reach, "pose: skipped by the person");
      break;
    case PanelKey::stop:
      return refused(ErrorCode::stopped, "stopped");
  }
  return pressed_;
}

bool GuidedPerson::near_target() const {
  const auto marker = stylus_.newest();
  if (!request_.target || !marker) return !request_.target;
  return (tip_of(*marker, *request_.target).m - request_.target->tip.m).norm() < kNear &&
         marker->rotation.angularDistance(request_.target->R_world_marker) < kTurnedAlike;
}

bool GuidedPerson::there() {
  if (request_.gesture == Gesture::next_pose)
    return stylus_.still() && stylus_.moved() && (pressed_ || near_target());
  return pressed_ && (request_.gesture != Gesture::touch || pointer_.still());
}

Expected<bool> GuidedPerson::ready() {
  while (const auto key = panel_.key())
    if (const auto answered = answer(*key); !answered) return tl::unexpected(answered.error());
  if (!there()) return false;
  watched().take();
  panel_.taken();
  return true;
}

void GuidedPerson::watch(double now_s, const device::ArmSample& arm,
                         std::span<const device::TrackerSample> tracked) {
  for (Stillness* marker : {&stylus_, &pointer_, &head_}) marker->watch(now_s, tracked);
  now_s_ = now_s;
  if (now_s_ >= observed_s_ + kObserved || observed_s_ < 0.0) {
    observed_s_ = now_s_;
    panel_.observe(seen_now(arm.connected));
  }
  if (now_s_ < told_s_ + kTold && told_s_ >= 0.0) return;
  told_s_ = now_s_;
  panel_.tell(arm.connected ? progress() : "the arm does not answer");
}

PersonView GuidedPerson::seen_now(bool arm_answers) const {
  return {now_s_,
          arm_answers,
          seen_marker(stylus_),
          seen_marker(pointer_),
          seen_marker(head_),
          request_.target && near_target()};
}

std::string GuidedPerson::progress() {
  if (request_.gesture == Gesture::rest) return "";
  const Stillness& marker = watched();
  if (!marker.seen()) return "the tracker does not see the marker";
  if (request_.gesture != Gesture::next_pose && request_.gesture != Gesture::touch)
    return "the tracker sees the marker";
  if (request_.target) {
    const auto newest = marker.newest();
    const std::string to_go = way(request_.target->tip.m - tip_of(*newest, *request_.target).m);
    const double turn = newest->rotation.angularDistance(request_.target->R_world_marker);
    if (!near_target())
      return fmt::format("{}{}turn it by {:.0f} degrees", to_go, to_go.empty() ? "" : "; ",
                         degrees_from_radians(turn));
  }
  if (!marker.moved()) return "taken; on to another pose";
  return marker.still() ? "still" : "hold it still";
}

}  // namespace palpate::calibration::session
