#include "palpate/sim/simulated_display.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace palpate::sim {
namespace {

constexpr Duration kTimecodesKept = std::chrono::seconds(3), kGoesDark = std::chrono::milliseconds(500);
constexpr double kBlock = 0.018;                           // m; the panel is 34 cm wide
constexpr double kBesideWall = 0.015, kAboveTable = 0.11;  // m, its right and lower edge
constexpr double kBrightness = 0.85, kBlack = 0.01;        // light of a white and of a black block
constexpr double kPanelFalloff =
    0.16;                       // light lost in the corners, per squared ray length, as the renderer's
constexpr int kRaysAcross = 3;  // of a pixel, each way

// Upper left corner, and along and down the panel by a block.
struct PanelPlace {
  Vector3 corner, along, down;
};
PanelPlace panel_place(const std::array<Vector3, 4>& wall) {
  const Vector3 x = (wall[1] - wall[0]).normalized(), y = (wall[3] - wall[0]).normalized();
  const Vector3 lower_right = wall[0] - kBesideWall * x + kAboveTable * y;
  return {lower_right - device::kPanelWide * kBlock * x + device::kPanelHigh * kBlock * y, kBlock * x,
          -kBlock * y};
}

}  // namespace

SimulatedDisplay::SimulatedDisplay(const config::WorldFile& world)
    : scan_out_(seconds(world.display.scan_out_s)),
      exposure_(seconds(world.camera.exposure_s)),
      readout_(seconds(config::readout_s(world))),
      noise_(world.camera.noise_sd) {}

void SimulatedDisplay::show(Instant<TrueTime> at, Duration code) {
  const auto light = at + scan_out_;
  if (!shown_.empty() && light < shown_.back().at) return;
  shown_.push_back({light, code});
  while (light - shown_.front().at > kTimecodesKept) shown_.pop_front();
}

bool SimulatedDisplay::lit(Instant<TrueTime> at) const {
  return !shown_.empty() && at >= shown_.front().at && at - shown_.back().at < kGoesDark;
}

device::TimecodeLight SimulatedDisplay::light(Instant<TrueTime> mid_exposure, int row, int rows) const {
  const auto middle =
      mid_exposure + seconds(to_seconds(readout_) * ((row + 0.5) / static_cast<double>(rows) - 0.5));
  const auto begin = middle - exposure_ / 2, end = middle + exposure_ / 2;
  device::TimecodeLight sum{};
  double time = 0.0;
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    const auto from = i == 0 ? begin : std::max(begin, shown_[i].at);
    const auto to = i + 1 < shown_.size() ? std::min(end, shown_[i + 1].at) : end;
    // No exposure: what stood there at that moment.
    const double share = exposure_ > Duration(0)                                     ? to_seconds(to - from)
                         : from <= middle && (to > middle || i + 1 == shown_.size()) ? 1.0
                                                                                     : 0.0;
    if (!(share > 0.0)) continue;
    const device::TimecodeLight timecode = device::timecode_light(shown_[i].code, Duration(0));
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += share * timecode[k];
    time += share;
  }
  for (auto& block : sum) block = time > 0.0 ? block / time : 0.0;
  return sum;
}

void SimulatedDisplay::paint(device::CameraImage& image, const TrueView& view,
                             Instant<TrueTime> mid_exposure) {
  if (!lit(mid_exposure)) return;
  const PanelPlace place = panel_place(view.wall);
  const Pose<CameraOptical, World> X = view.X_world_camera.inverse();
  const Vector3 corner = (X * Point<World>{place.corner}).m, along = X.rotation * place.along,
                down = X.rotation * place.down;
  if (along.cross(down).dot(corner) <= 0.0) return;  // seen from behind
  const auto box = pixel_box(view.lens, {corner, corner + device::kPanelWide * along,
                                         corner + device::kPanelWide * along + device::kPanelHigh * down,
                                         corner + device::kPanelHigh * down});
  if (box[2] <= 0 || box[3] <= 0) return;
  Matrix3 from_panel;
  from_panel << along, down, corner;
  const Matrix3 to_panel = from_panel.inverse();
  const auto& ray = rays_.of(view.lens, lens_rays).ray;
  const auto index = [&](int u, int v) {
    u = std::clamp(u, 0, image.width - 1), v = std::clamp(v, 0, image.height - 1);
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(u);
  };
  device::TimecodeLight timecode = light(mid_exposure, image.height / 2, image.height);
  for (int v = box[1]; v < box[1] + box[3]; ++v) {
    if (readout_ > Duration(0)) timecode = light(mid_exposure, v, image.height);
    for (int u = box[0]; u < box[0] + box[2]; ++u) {
      const Eigen::Vector2d here = ray[index(u, v)].cast<double>();
      const Eigen::Vector2d du = 0.5 * (ray[index(u + 1, v)] - ray[index(u - 1, v)]).cast<double>(),
                            dv = 0.5 * (ray[index(u, v + 1)] - ray[index(u, v - 1)]).cast<double>();
      double sum = 0.0;
      int covered = 0;
      for (int j = 0; j < kRaysAcross; ++j)
        for (int i = 0; i < kRaysAcross; ++i) {
          const Eigen::Vector2d r =
              here + ((i + 0.5) / kRaysAcross - 0.5) * du + ((j + 0.5) / kRaysAcross - 0.5) * dv;
          const Vector3 h = to_panel * Vector3(r.x(), r.y(), 1.0);
          const double x = h.x() / h.z(), y = h.y() / h.z();
          if (!(h.z() > 0 && x >= 0 && y >= 0 && x < device::kPanelWide && y < device::kPanelHigh)) continue;
          sum += kBlack + (kBrightness - kBlack) * device::panel_light(x, y, timecode);
          ++covered;
        }
      std::uint8_t* pixel = image.rgb.data() + 3 * index(u, v);
      if (covered == 0) continue;
      // Pictures hold square roots of light, and so does their vignette.
      const double dim = 1.0 - kPanelFalloff * here.squaredNorm();
      std::array<std::uint8_t, 3> bytes{};
      for (std::size_t k = 0; k < 3; ++k) {
        const double behind = pixel[k] / 255.0;
        const double behind_share = 1.0 - static_cast<double>(covered) / (kRaysAcross * kRaysAcross);
        const double seen = sum / (kRaysAcross * kRaysAcross) * dim * dim + behind_share * behind * behind;
        bytes[k] = static_cast<std::uint8_t>(std::lround(255.0 * std::sqrt(std::clamp(seen, 0.0, 1.0))));
      }
      if (covered == kRaysAcross * kRaysAcross) noise_.add(bytes, view.noise_seed + 3 * index(u, v));
      std::copy(bytes.begin(), bytes.end(), pixel);
    }
  }
}

}  // namespace palpate::sim
