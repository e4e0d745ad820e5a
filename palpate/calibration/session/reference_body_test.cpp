#include "palpate/calibration/session/reference_body.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"

namespace palpate::calibration::session {
namespace {

device::TrackerSample noisy(const device::TrackerSample& sample, Random& random) {
  const Eigen::LLT<Matrix6> root(sample.covariance);
  Eigen::Matrix<double, 6, 1> white;
  for (int i = 0; i < 6; ++i) white[i] = random.normal(1.0);
  const Eigen::Matrix<double, 6, 1> step = root.matrixL() * white;
  device::TrackerSample off = sample;
  off.rotation = so3_exp(step.head<3>()) * sample.rotation;
  off.translation += step.tail<3>();
  return off;
}

Matrix6 some_covariance(Random& random) {
  Matrix6 A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = random.normal(1.0);
  Matrix6 C = A * A.transpose() + Matrix6::Identity();
  const Eigen::Matrix<double, 6, 1> scale =
      (Eigen::Matrix<double, 6, 1>() << 1e-3, 1e-3, 1e-3, 1e-4, 1e-4, 1e-4).finished();
  return scale.asDiagonal() * C * scale.asDiagonal();
}

TEST(ReferenceBody, ATrackerThatIsMovedChangesNothing) {
  std::vector<TrackedPose> marker, body;
  const Quaternion turn = so3_exp(Vector3(0.3, -0.2, 0.5));
  const Vector3 place(0.1, 0.02, -0.03);
  for (int i = 0; i < 200; ++i) {
    const double t = 0.01 * i;
    const Quaternion R = so3_exp(Vector3(0.2 * std::sin(t), 0.3 * t, 0.1));
    TrackedPose one;
    one.time_s = t;
    one.marker.seen = true;
    one.marker.rotation = R;
    one.marker.translation = Vector3(0.5 * t, std::cos(t), 1.0);
    body.push_back(one);
    one.marker.rotation = R * turn;
    one.marker.translation += R * place;
    one.marker.seen = i != 7;
    marker.push_back(one);
  }
  body[50].marker.seen = false;
  const auto relative = in_reference(marker, body);
  ASSERT_EQ(relative.size(), marker.size());
  for (std::size_t i = 0; i < relative.size(); ++i) {
    EXPECT_EQ(relative[i].marker.seen, i != 7 && i != 50) << i;
    if (!relative[i].marker.seen) continue;
    EXPECT_LT((relative[i].marker.translation - place).norm(), 1e-12);
    EXPECT_LT(relative[i].marker.rotation.angularDistance(turn), 1e-9);
  }
}

TEST(ReferenceBody, ItsStampsMayLieBetweenThoseOfTheMarker) {
  std::vector<TrackedPose> marker, body;
  for (int i = 0; i < 100; ++i) {
    TrackedPose one;
    one.time_s = 0.02 * i;
    one.marker.seen = true;
    one.marker.translation = Vector3(one.time_s, 0.0, 0.0);
    body.push_back(one);
    one.time_s += 0.007;
    one.marker.translation = Vector3(one.time_s + 0.25, 0.0, 0.0);
    marker.push_back(one);
  }
  const auto relative = in_reference(marker, body);
  EXPECT_FALSE(relative.back().marker.seen) << "nobody knows where the body was after its last pose";
  for (std::size_t i = 0; i + 1 < relative.size(); ++i)
    EXPECT_NEAR(relative[i].marker.translation.x(), 0.25, 1e-12);
}

// The stated covariance beside that of a thousand draws.
TEST(ReferenceBody, TheCovarianceIsThatOfTheDifferences) {
  Random random(5, "reference body");
  TrackedPose marker, body;
  marker.marker.seen = body.marker.seen = true;
  marker.marker.rotation = so3_exp(Vector3(0.4, 0.1, -0.6));
  marker.marker.translation = Vector3(0.3, -0.2, 1.0);
  marker.marker.covariance = some_covariance(random);
  body.marker.rotation = so3_exp(Vector3(-0.2, 0.9, 0.3));
  body.marker.translation = Vector3(0.1, 0.1, 1.2);
  body.marker.covariance = some_covariance(random);
  const auto stated = in_reference({marker}, {body}).front().marker;
  Matrix6 sum = Matrix6::Zero();
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    TrackedPose a = marker, b = body;
    a.marker = noisy(marker.marker, random);
    b.marker = noisy(body.marker, random);
    const auto drawn = in_reference({a}, {b}).front().marker;
    Eigen::Matrix<double, 6, 1> off;
    off << so3_log(drawn.rotation * stated.rotation.conjugate()), drawn.translation - stated.translation;
    sum += off * off.transpose() / kDraws;
  }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const double scale = std::sqrt(stated.covariance(i, i) * stated.covariance(j, j));
      EXPECT_NEAR(sum(i, j) / scale, stated.covariance(i, j) / scale, 0.1) << i << ' ' << j;
    }
}

}  // namespace
}  // namespace palpate::calibration::session
