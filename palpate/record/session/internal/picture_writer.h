// Packs pictures and writes them, in a thread of its own: JPEG takes a millisecond or two. Two wait at most; what comes beside
// them is dropped. Private to the module.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>

#include "palpate/record/session/recorded_drivers.h"

namespace palpate::record::session {

class PictureWriter {
 public:
  PictureWriter(SessionRecording& recording, const PictureRecording& how, const std::string& camera);
  ~PictureWriter();  // writes what waits
  PictureWriter(const PictureWriter&) = delete;
  PictureWriter& operator=(const PictureWriter&) = delete;

  void write(const device::CameraImage& image, std::int64_t arrived_ns);

 private:
  struct Waiting {
    device::CameraImage image;
    std::int64_t arrived_ns;
  };
  static constexpr std::size_t kMost = 2;
  void work();

  SessionRecording& recording_;
  const PictureRecording how_;
  const std::string frame_;
  RecordStream& stream_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting> waiting_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace palpate::record::session
