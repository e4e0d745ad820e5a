#include "palpate/device/camera_preview.h"

#include <utility>

namespace palpate::device {
namespace {

constexpr double kInUse_s = 0.5;  // who works with a camera polls it more often than that

}  // namespace

CameraPreview::CameraPreview(CameraDevice& camera, CameraDevice* right, double rate_hz, Show show)
    : device_(camera),
      has_right_(right != nullptr),
      period_s_(1.0 / rate_hz),
      show_(std::move(show)),
      left_(*this, camera, false),
      right_(*this, right != nullptr ? *right : camera, true) {}

void CameraPreview::show(const CameraImage& image, bool right) {
  if (image.rgb.empty() || !due()) return;
  shown_s_ = now_s_;
  show_(image, right);
}

void CameraPreview::refresh(double now_s) {
  now_s_ = now_s;
  // Whoever works with the camera must not lose a picture to us.
  if (now_s_ < used_s_ + kInUse_s || !due() || now_s_ < looked_s_ + period_s_ / 8.0) return;
  looked_s_ = now_s_;
  if (const auto image = device_.poll()) show(*image, false);
}

std::optional<CameraImage> CameraPreview::Eye::poll() {
  preview_.used_s_ = preview_.now_s_;
  auto image = device_.poll();
  if (image) preview_.show(*image, is_right_);
  return image;
}

std::optional<CameraImage> CameraPreview::Eye::poll_unseen() {
  preview_.used_s_ = preview_.now_s_;
  if (!preview_.due()) return device_.poll_unseen();
  auto image = device_.poll();
  if (!image) return image;
  preview_.show(*image, is_right_);
  image->rgb.clear();
  return image;
}

}  // namespace palpate::device
