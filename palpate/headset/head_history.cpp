#include "palpate/headset/head_history.h"

#include <algorithm>

namespace palpate::headset {
namespace {

Vector3 vector_of(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }
std::array<double, 3> array_of(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

Pose<Local, View> HeadHistory::pose_of(const Entry& entry) {
  return {Quaternion(entry.turn[0], entry.turn[1], entry.turn[2], entry.turn[3]), vector_of(entry.place)};
}

HeadHistory::Entry HeadHistory::entry_of(Instant<GraphicsClock> time, const Pose<Local, View>& pose) {
  Entry entry;
  entry.time = time;
  entry.turn = {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()};
  entry.place = array_of(pose.translation);
  return entry;
}

bool HeadHistory::add(Instant<GraphicsClock> time, const Pose<Local, View>& X_local_view) {
  Entry entry = entry_of(time, X_local_view);
  if (count() > 0 && time > last_.time) {
    const double dt = to_seconds(time - last_.time);
    const Pose<Local, View> before = pose_of(last_);
    entry.spin = array_of(so3_log(X_local_view.rotation * before.rotation.conjugate()) / dt);
    entry.velocity = array_of((X_local_view.translation - before.translation) / dt);
  }
  if (!entries_.push(entry)) return false;
  last_ = entry;
  return true;
}

HeadHistory::Entry HeadHistory::between(const Entry& a, const Entry& b, double s) {
  Entry entry = entry_of(a.time, interpolate(pose_of(a), pose_of(b), s));
  entry.time += Duration(std::llround(s * static_cast<double>((b.time - a.time).count())));
  return entry;
}

HeadHistory::Entry HeadHistory::ahead(const Entry& a, Duration by) {
  const double dt = to_seconds(by);
  const Pose<Local, View> pose = pose_of(a);
  return entry_of(a.time + by, {(so3_exp(dt * vector_of(a.spin)) * pose.rotation).normalized(),
                                pose.translation + dt * vector_of(a.velocity)});
}

HeadHistory::Head HeadHistory::at(Instant<GraphicsClock> time) const {
  const auto answer = entries_.at(time, between, ahead);
  return {answer.kind, pose_of(answer.state)};
}

}  // namespace palpate::headset
