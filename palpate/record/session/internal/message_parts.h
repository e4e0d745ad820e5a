// What messages of recordings have in common: vectors on the way out and in, and the check of what is read. Private to the
// module.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <cmath>
#include <optional>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/math/so3.h"
#include "palpate_recording.pb.h"

namespace palpate::record::session {

inline void put(recording::Vector3* to, const Vector3& from) {
  to->set_x(from.x());
  to->set_y(from.y());
  to->set_z(from.z());
}
inline Vector3 vector_of(const recording::Vector3& from) { return {from.x(), from.y(), from.z()}; }

// The upper triangle of a symmetric matrix, row by row.
template <int N>
void put_upper(google::protobuf::RepeatedField<double>* to, const Eigen::Matrix<double, N, N>& m) {
  for (int i = 0; i < N; ++i)
    for (int j = i; j < N; ++j) to->Add(m(i, j));
}

// False where there are not as many numbers, or one is none.
template <int N>
bool read_upper(const google::protobuf::RepeatedField<double>& from, Eigen::Matrix<double, N, N>& m) {
  if (from.size() != N * (N + 1) / 2) return false;
  int k = 0;
  for (int i = 0; i < N; ++i)
    for (int j = i; j < N; ++j) m(i, j) = m(j, i) = from[k++];
  return m.allFinite();
}

inline void put_orientation(google::protobuf::RepeatedField<double>* to, const Quaternion& q) {
  for (const double part : {q.w(), q.x(), q.y(), q.z()}) to->Add(part);
}
// Nothing where it is no unit quaternion to 1e-3.
inline std::optional<Quaternion> orientation_of(const google::protobuf::RepeatedField<double>& from) {
  if (from.size() != 4) return std::nullopt;
  const Quaternion q(from[0], from[1], from[2], from[3]);
  // What rounding leaves stays as it was written; what was written roughly is made a rotation.
  constexpr double kRoughly = 1e-3, kRounding = 1e-7;
  const double off = std::abs(q.norm() - 1.0);
  if (!(off < kRoughly)) return std::nullopt;
  return off < kRounding ? q : q.normalized();
}

template <typename Wire>
Expected<Wire> parse(std::string_view bytes, const char* what) {
  Wire in;
  if (!in.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    return refused("{} of {} bytes is no such message", what, bytes.size());
  return in;
}

}  // namespace palpate::record::session
