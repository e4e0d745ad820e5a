// A camera, or two, whose pictures somebody sees beside the one who works with them.
//
// Who works with a camera gets it by camera() or right() and polls it as ever; what comes by there is shown as well,
// at most `rate_hz` times a second. While nobody polls, refresh() does it, with the left camera. Pictures are
// shown in the thread that polls. One thread.
#pragma once

#include <functional>

#include "palpate/device/devices.h"

namespace palpate::device {

class CameraPreview {
 public:
  using Show = std::function<void(const CameraImage& image, bool right)>;

  // The cameras must outlive this object; `right`: null where there is one.
  CameraPreview(CameraDevice& camera, CameraDevice* right, double rate_hz, Show show);

  CameraDevice& camera() { return left_; }
  CameraDevice* right() { return has_right_ ? &right_ : nullptr; }
  // Called each millisecond or so, with the host's time; the only clock that this object has.
  void refresh(double now_s);

 private:
  class Eye : public CameraDevice {
   public:
    Eye(CameraPreview& preview, CameraDevice& device, bool right)
        : preview_(preview), device_(device), is_right_(right) {}
    std::optional<CameraImage> poll() override;
    std::optional<CameraImage> poll_unseen() override;
    void take_back(CameraImage image) override { device_.take_back(std::move(image)); }

   private:
    CameraPreview& preview_;
    CameraDevice& device_;
    bool is_right_;
  };

  bool due() const { return now_s_ >= shown_s_ + period_s_; }
  void show(const CameraImage& image, bool right);

  CameraDevice& device_;
  bool has_right_;
  double period_s_;
  Show show_;
  double now_s_ = 0.0, shown_s_ = -1e9, used_s_ = -1e9, looked_s_ = -1e9;
  Eye left_, right_;
};

}  // namespace palpate::device
