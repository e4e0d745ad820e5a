#include "runtime.h"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace palpate::headset {
namespace {

constexpr std::int64_t kStart_ns = 1'000'000'000'000;
constexpr std::int64_t kRemembered_ns = 50'000'000;  // no more than the specification promises

std::int64_t machine_ns() {
  timespec spec{};
  clock_gettime(CLOCK_MONOTONIC, &spec);
  return static_cast<std::int64_t>(spec.tv_sec) * 1'000'000'000 + spec.tv_nsec;
}

std::chrono::duration<double> of_seconds(double s) { return std::chrono::duration<double>(s); }

XrPosef to_pose(const Placed& placed) {
  XrPosef pose{};
  pose.orientation = {static_cast<float>(placed.turn.x), static_cast<float>(placed.turn.y),
                      static_cast<float>(placed.turn.z), static_cast<float>(placed.turn.w)};
  pose.position = {static_cast<float>(placed.at.x), static_cast<float>(placed.at.y),
                   static_cast<float>(placed.at.z)};
  return pose;
}

}  // namespace

Runtime& Runtime::the() {
  static Runtime* const runtime = [] {  // outlives threads that still wait in it when the program ends
    auto* made = new Runtime();
    made->reset({});
    made->virtual_time_ = false;
    return made;
  }();
  return *runtime;
}

void Runtime::reset(const TestDisplay& display) {
  const std::lock_guard lock(mutex_);
  display_ = display;
  motion_ = nullptr;
  locals_ = {{0, Placed{}}};
  virtual_time_ = true;
  hung_ = gone_ = false;
  worn_ = true;
  refusal_ = Refusal::none;
  virtual_ns_ = kStart_ns;
  frame_asked_ = frame_waited_ = frame_ended_ = 0;
  layers_.clear();
  counts_ = {};
}

void Runtime::move_head(std::function<HeadPlace(std::int64_t)> place) {
  const std::lock_guard lock(mutex_);
  motion_ = std::move(place);
}

Placed Runtime::head_at(std::int64_t monotonic_ns) const {
  if (!motion_) return {};
  const HeadPlace p = motion_(monotonic_ns);
  return {{p.qw, p.qx, p.qy, p.qz}, {p.x, p.y, p.z}};
}

Placed Runtime::local_at(std::int64_t monotonic_ns) const {
  Placed local = locals_.front().second;
  for (const auto& [since, placed] : locals_)
    if (monotonic_ns >= since) local = placed;
  return local;
}

void Runtime::lay_local_anew() {
  const std::lock_guard lock(mutex_);
  // A few frames from now, so that the application hears of it before.
  const std::int64_t since = now_locked() + 4 * static_cast<std::int64_t>(1e9 / display_.rate_hz);
  const Placed before = local_at(since), after = head_at(since);
  locals_.emplace_back(since, after);
  XrEventDataBuffer buffer{};
  auto& event = reinterpret_cast<XrEventDataReferenceSpaceChangePending&>(buffer);
  event.type = XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING;
  event.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  event.changeTime = since + kXrTimeAhead_ns;
  event.poseValid = XR_TRUE;
  event.poseInPreviousSpace = to_pose(chained(inverse(before), after));
  events_.push_back(buffer);
}

std::int64_t Runtime::now_locked() const { return virtual_time_ ? virtual_ns_ : machine_ns(); }

std::int64_t Runtime::now_ns() const {
  const std::lock_guard lock(mutex_);
  return now_locked();
}

std::int64_t Runtime::period_ns() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::int64_t>(std::llround(1e9 / display_.rate_hz));
}

bool Runtime::refresh(double patience_s) {
  std::unique_lock lock(mutex_);
  virtual_ns_ += static_cast<std::int64_t>(std::llround(1e9 / display_.rate_hz));
  ++counts_.refreshes;
  const std::uint64_t asked = ++frame_asked_;
  changed_.notify_all();
  // And until it waits for the next one: then it has done with this one, whatever it does after handing over.
  return changed_.wait_for(lock, of_seconds(patience_s),
                           [&] { return frame_ended_ >= asked && counts_.waiting; });
}

void Runtime::run_by_itself() {
  const std::lock_guard lock(mutex_);
  virtual_time_ = false;
  hung_ = false;
  changed_.notify_all();
}

void Runtime::wear(bool worn) {
  const std::lock_guard lock(mutex_);
  if (session_ && worn != worn_) put_session(worn ? XR_SESSION_STATE_READY : XR_SESSION_STATE_STOPPING);
  worn_ = worn;
  changed_.notify_all();
}

// A program whose runtime this is, in a process of its own, is told by a file what becomes of it.
void Runtime::obey_file() {
  const char* name = std::getenv("PALPATE_TEST_RUNTIME_FILE");
  if (name == nullptr) return;
  std::ifstream file(name);
  std::string said;
  file >> said;
  if (said == file_said_) return;
  file_said_ = said;
  hung_ = said == "hang";
  gone_ = said == "vanish";
}

void Runtime::hang(bool hung) {
  const std::lock_guard lock(mutex_);
  hung_ = hung;
  changed_.notify_all();
}

void Runtime::end_session_by_force() {
  const std::lock_guard lock(mutex_);
  put_session(XR_SESSION_STATE_LOSS_PENDING);
  ++frame_asked_;  // it hears of it when it is back from waiting
  changed_.notify_all();
}

bool Runtime::instance_open() const {
  const std::lock_guard lock(mutex_);
  return instance_;
}

void Runtime::vanish() {
  const std::lock_guard lock(mutex_);
  gone_ = true;
  changed_.notify_all();
}

void Runtime::return_again() {
  const std::lock_guard lock(mutex_);
  gone_ = false;
}

void Runtime::refuse(Refusal refusal) {
  const std::lock_guard lock(mutex_);
  refusal_ = refusal;
}

EyePicture Runtime::seen(int eye, std::int64_t monotonic_ns) const {
  const std::lock_guard lock(mutex_);
  return composite(layers_, eye, head_at(monotonic_ns), display_);
}

TestCounts Runtime::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

bool Runtime::gone() const {
  const std::lock_guard lock(mutex_);
  return gone_;
}

TestRuntime::Refusal Runtime::refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
}

XrResult Runtime::make_instance(XrInstance* instance) {
  const std::lock_guard lock(mutex_);
  obey_file();
  if (gone_ || refusal_ == Refusal::no_service) return XR_ERROR_RUNTIME_FAILURE;
  if (instance_) return XR_ERROR_LIMIT_REACHED;
  instance_ = true;
  requirements_ = false;
  events_.clear();
  ++counts_.instances;
  *instance = reinterpret_cast<XrInstance>(++handles_);
  return XR_SUCCESS;
}

void Runtime::end_instance() {
  end_session_object();
  const std::lock_guard lock(mutex_);
  instance_ = false;
}

XrResult Runtime::make_session(const XrSessionCreateInfo& info, XrSession* session) {
  const std::lock_guard lock(mutex_);
  if (session_) return XR_ERROR_LIMIT_REACHED;
  if (!requirements_) return XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING;
  const auto* binding = static_cast<const XrGraphicsBindingEGLMNDX*>(info.next);
  if (binding == nullptr || binding->type != XR_TYPE_GRAPHICS_BINDING_EGL_MNDX ||
      binding->display == nullptr || binding->context == nullptr || !gl_.load(binding->getProcAddress))
    return XR_ERROR_GRAPHICS_DEVICE_INVALID;
  session_ = true;
  running_ = begun_ = wait_done_ = false;
  put_session(XR_SESSION_STATE_IDLE);
  if (worn_) put_session(XR_SESSION_STATE_READY);
  *session = reinterpret_cast<XrSession>(++handles_);
  return XR_SUCCESS;
}

void Runtime::end_session_object() {
  const std::lock_guard lock(mutex_);
  session_ = running_ = false;
  spaces_.clear();
  swapchains_.clear();
  layers_.clear();
}

void Runtime::put_session(XrSessionState state) {
  XrEventDataBuffer buffer{};
  auto& event = reinterpret_cast<XrEventDataSessionStateChanged&>(buffer);
  event.type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED;
  event.state = state;
  events_.push_back(buffer);
}

XrResult Runtime::next_event(XrEventDataBuffer& event) {
  const std::lock_guard lock(mutex_);
  if (events_.empty()) return XR_EVENT_UNAVAILABLE;
  event = events_.front();
  events_.pop_front();
  return XR_SUCCESS;
}

XrResult Runtime::make_space(XrReferenceSpaceType type, XrSpace* space) {
  const std::lock_guard lock(mutex_);
  if (type != XR_REFERENCE_SPACE_TYPE_VIEW && type != XR_REFERENCE_SPACE_TYPE_LOCAL)
    return XR_ERROR_REFERENCE_SPACE_UNSUPPORTED;
  spaces_[++handles_] = type;
  *space = reinterpret_cast<XrSpace>(handles_);
  return XR_SUCCESS;
}

XrResult Runtime::locate(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation& location) {
  const std::lock_guard lock(mutex_);
  const auto a = spaces_.find(reinterpret_cast<std::uint64_t>(space));
  const auto b = spaces_.find(reinterpret_cast<std::uint64_t>(base));
  if (a == spaces_.end() || b == spaces_.end()) return XR_ERROR_HANDLE_INVALID;
  if (time <= 0) return XR_ERROR_TIME_INVALID;
  const std::int64_t at = time - kXrTimeAhead_ns;
  location.locationFlags = 0;
  if (at < now_locked() - kRemembered_ns) return XR_SUCCESS;  // forgotten
  const auto in_room = [&](XrReferenceSpaceType type) {
    return type == XR_REFERENCE_SPACE_TYPE_VIEW ? head_at(at) : local_at(at);
  };
  location.pose = to_pose(chained(inverse(in_room(b->second)), in_room(a->second)));
  location.locationFlags = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
                           XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
  return XR_SUCCESS;
}

}  // namespace palpate::headset
