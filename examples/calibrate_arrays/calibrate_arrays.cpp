// Calibrates a stylus tip (pivot) and a haptic arm from plain arrays, and prints what is known how well.
// Metres, radians, quaternions w x y z. The arrays stand for a recording of yours; here they are computed, with
// noise, from a stylus and an arm that are known, so that the program can say how far each answer is off.
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "palpate/calibration/arm.h"
#include "palpate/calibration/pivot.h"

using namespace palpate;

namespace {

constexpr double kNoise = 1e-4;  // m, of the tracker, per component
const double kTip[3] = {0.004, -0.018, -0.118};
const double kGain[3] = {1.012, 0.991, 1.006}, kOffset[3] = {0.0, 0.018, -0.011};
constexpr double kLongestError = 4.0;  // standard deviations

std::mt19937 random_bits(7);
double uniform(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random_bits);
}
double noise() { return std::normal_distribution<double>(0.0, kNoise)(random_bits); }

// poses[i] = x y z qw qx qy qz of the marker, while the tip rests at one point.
std::vector<std::array<double, 7>> record_pivot(int count) {
  const Vector3 tip(kTip[0], kTip[1], kTip[2]), rests_at(0.1, -0.9, 0.3);
  std::vector<std::array<double, 7>> poses;
  for (int i = 0; i < count; ++i) {
    const Quaternion q = Eigen::AngleAxisd(uniform(-0.6, 0.6), Vector3::UnitX()) *
                         Eigen::AngleAxisd(uniform(-0.6, 0.6), Vector3::UnitZ());
    const Vector3 p = rests_at - q * tip;
    poses.push_back({p.x() + noise(), p.y() + noise(), p.z() + noise(), q.w(), q.x(), q.y(), q.z()});
  }
  return poses;
}

// samples[i] = three encoder readings, then x y z of the tip as the tracker saw it.
std::vector<std::array<double, 6>> record_arm(int count) {
  const Quaternion turned(Eigen::AngleAxisd(0.07, Vector3(0.2, 1.0, -0.3).normalized()));
  std::vector<std::array<double, 6>> samples;
  for (int i = 0; i < count; ++i) {
    const Vector3 psi(uniform(-0.7, 0.7), uniform(-0.1, 1.4), uniform(-0.4, 1.0));
    Vector3 theta;
    for (int j = 0; j < 3; ++j) theta[j] = kGain[j] * psi[j] + kOffset[j];
    const Vector3 tip = turned * device::arm_tip({}, theta).m + Vector3(0.1, -1.4, 1.7);
    samples.push_back({psi[0], psi[1], psi[2], tip.x() + noise(), tip.y() + noise(), tip.z() + noise()});
  }
  return samples;
}

// A line of what was found; false where it is further from the truth than its standard deviation explains.
bool print(const char* name, double value, double truth, double deviation) {
  std::printf("  %-10s %+.6f  standard deviation %.6f  error %+.6f\n", name, value, deviation, value - truth);
  return std::abs(value - truth) <= kLongestError * deviation;
}

bool pivot() {
  std::vector<calibration::PivotPose> poses;
  for (const auto& p : record_pivot(200)) {
    poses.push_back(
        {.rotation = Quaternion(p[3], p[4], p[5], p[6]), .translation = Vector3(p[0], p[1], p[2])});
  }
  const auto found = calibration::calibrate_pivot(poses);
  if (!found) return std::fprintf(stderr, "pivot: %s\n", found.error().message.c_str()), false;
  std::printf("tip in the marker, m\n");
  bool good = true;
  for (int i = 0; i < 3; ++i) {
    const char* const names[] = {"x", "y", "z"};
    good &= print(names[i], found->value.tip[i], kTip[i], found->standard_deviation(i));
  }
  std::printf("covariance, mm^2\n");
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) std::printf(" %+12.3e", 1e6 * found->covariance(i, j));
    std::printf("\n");
  }
  return good;
}

bool arm() {
  std::vector<device::ArmObservation> samples;
  for (const auto& s : record_arm(150)) {
    samples.push_back({.joints = Vector3(s[0], s[1], s[2]), .tip = Point<World>{Vector3(s[3], s[4], s[5])}});
  }
  calibration::ArmOptions options;
  options.free.lengths = false;
  const auto found = calibration::calibrate_arm(samples, device::ArmModel{}, options);
  if (!found) return std::fprintf(stderr, "arm: %s\n", found.error().message.c_str()), false;
  std::printf("arm: rms %.6f m; of what was estimated:\n", rms_per_component(found->residuals));
  bool good = true;
  for (std::size_t i = 0; i < found->value.parameters.size(); ++i) {
    const std::string& name = found->value.parameters[i];
    const int joint = name.back() - '1';
    if (name.starts_with("gain_")) {
      good &= print(name.c_str(), found->value.gain[joint], kGain[joint], found->standard_deviation(i));
    } else if (name.starts_with("offset_") && joint > 0) {  // the first trades with the base's turn
      good &= print(name.c_str(), found->value.offset[joint], kOffset[joint], found->standard_deviation(i));
    }
  }
  return good;
}

}  // namespace

int main() {
  const bool tip_is_right = pivot(), arm_is_right = arm();
  return tip_is_right && arm_is_right ? 0 : 1;
}
