#include "palpate/server/graphics/quality_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace palpate::server::graphics {
namespace {

constexpr int kTooMany = 3;            // missed images in kJudged frames
constexpr double kGoodPart = 0.25;     // of an interval: below it somebody else makes the loop miss images
constexpr double kFits = 0.75;         // of an interval
constexpr std::uint64_t kOutage = 15;  // images in a row: the camera stood still

render::Quality next(render::Quality quality, int by) {
  return static_cast<render::Quality>(static_cast<int>(quality) + by);
}

}  // namespace

std::optional<std::string> QualityChoice::frame(Instant<GraphicsClock> now, Duration busy,
                                                std::uint64_t camera_frame, Instant<CameraClock> stamp) {
  const auto frame = judged(busy, camera_frame, stamp);
  if (!frame) return std::nullopt;
  if (unsettled_ > 0) {
    --unsettled_;
    return std::nullopt;
  }
  frames_.push_back(*frame);
  if (frames_.size() > kCalm) frames_.pop_front();
  if (frames_.size() < kJudged) return std::nullopt;

  if (const int lost = missed(kJudged);
      quality_ != render::Quality::low && lost >= kTooMany && busy_share(kJudged, 0.5) > kGoodPart) {
    Attempt& left = attempts_.at(static_cast<std::size_t>(quality_));
    left.not_before = now + left.wait;
    left.wait = std::min(2 * left.wait, kLongestWait);
    if (share_below_ > 0.0) left.dearer = std::max(left.dearer, busy_share(kJudged, 0.5) / share_below_);
    share_below_ = 0.0;
    change(next(quality_, -1));
    return fmt::format("Pictures at quality {} from here on: {} of {} images were missed",
                       render::quality_word(quality_), lost, kJudged + static_cast<std::size_t>(lost));
  }
  if (quality_ == render::Quality::high || frames_.size() < kCalm || missed(kCalm) > 0) return std::nullopt;
  const render::Quality better = next(quality_, 1);
  const Attempt& attempt = attempts_.at(static_cast<std::size_t>(better));
  if (now < attempt.not_before || attempt.dearer * busy_share(kCalm, 0.9) > kFits) return std::nullopt;
  share_below_ = busy_share(kCalm, 0.5);
  change(better);
  return fmt::format("Pictures at quality {} from here on: there is time to spare",
                     render::quality_word(quality_));
}

std::optional<QualityChoice::Frame> QualityChoice::judged(Duration busy, std::uint64_t camera_frame,
                                                          Instant<CameraClock> stamp) {
  const auto before = std::exchange(last_frame_, camera_frame);
  const Duration since = stamp - std::exchange(last_stamp_, stamp);
  // Two from one image, a count that begins anew, a camera that stood still: nobody's fault here.
  if (!before || camera_frame <= *before || camera_frame - *before > kOutage || since <= Duration(0))
    return std::nullopt;
  const auto images = static_cast<Duration::rep>(camera_frame - *before);
  return Frame{busy, since / images, static_cast<int>(images - 1)};
}

int QualityChoice::missed(std::size_t count) const {
  int sum = 0;
  for (std::size_t i = frames_.size() - count; i < frames_.size(); ++i) sum += frames_[i].missed;
  return sum;
}

double QualityChoice::busy_share(std::size_t count, double quantile) const {
  std::vector<double> shares;
  for (std::size_t i = frames_.size() - count; i < frames_.size(); ++i)
    shares.push_back(to_seconds(frames_[i].busy) / to_seconds(frames_[i].interval));
  const auto at = shares.begin() + static_cast<std::ptrdiff_t>(quantile * static_cast<double>(count - 1));
  std::nth_element(shares.begin(), at, shares.end());
  return *at;
}

void QualityChoice::change(render::Quality quality) {
  quality_ = quality;
  ++changes_;
  unsettled_ = kSettled;
  frames_.clear();
}

}  // namespace palpate::server::graphics
