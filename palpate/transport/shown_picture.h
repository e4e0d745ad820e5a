// The newest picture that a graphics server of this user has shown, for whoever looks on at this machine.
//
// Two files in the user's run folder, which is in memory and closed to others: `picture_wanted`, which who looks touches, and
// `picture`, which the graphics server writes while the other is fresh, ten times a second at most. It waits for nobody: where
// nobody looks it costs a look at a file's time, and where writing fails there is no picture. Pictures show people and
// patients: they are on no network by this.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpate/core/json.h"

namespace palpate::transport {

struct ShownPicture {
  static constexpr int kMostSide = 8192;
  static constexpr std::size_t kMostLandmarks = 200;

  // Where one was found in the picture, px, and whether the camera's pose was refined by it.
  struct Landmark {
    double x = 0.0, y = 0.0;
    bool used = false;
  };

  std::int64_t writer = 0;   // the process
  std::uint64_t number = 0;  // of the frame
  int width = 0, height = 0;
  std::string pose;  // what the camera's pose rests on: "refined"
  int landmarks_used = 0, landmarks_predicted = 0;
  double landmark_rms_px = 0.0;
  std::optional<double> expected_overlay_px;  // its own estimate of the overlay error
  std::vector<Landmark> landmarks;
  std::vector<std::uint8_t> rgb;  // width * height * 3
};

// One thread, the one that draws.
class ShownPictureWriter {
 public:
  static constexpr std::chrono::milliseconds kAtMostEvery{100};
  static constexpr std::chrono::seconds kWantedFor{2};

  explicit ShownPictureWriter(std::filesystem::path folder) : folder_(std::move(folder)) {}
  // Whether somebody looks, and the last one is long enough ago.
  bool due() const;
  // `picture` without its pixels, which are `rgb`.
  void write(const ShownPicture& picture, std::span<const std::uint8_t> rgb);

 private:
  std::filesystem::path folder_;
  std::optional<std::chrono::steady_clock::time_point> written_;
};

// Its landmarks as a list of [x, y, used], to a tenth of a pixel.
Json landmarks_json(const ShownPicture& picture);

class ShownPictureReader {
 public:
  explicit ShownPictureReader(std::filesystem::path folder) : folder_(std::move(folder)) {}
  // Again every second at the least; false where the folder does not take it.
  bool want();
  // One that was not taken yet; of several graphics servers that of one, as long as it goes on. Nothing where there is none,
  // where what lies there is no picture, or was left there by a server that has ended since (older than kWantedFor).
  std::optional<ShownPicture> take();

 private:
  std::filesystem::path folder_;
  std::int64_t writer_ = 0;
  std::uint64_t number_ = 0;
  std::chrono::steady_clock::time_point came_;
};

}  // namespace palpate::transport
