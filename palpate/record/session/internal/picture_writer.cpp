#include "palpate/record/session/internal/picture_writer.h"

#include <utility>

#include "foxglove.pb.h"
#include "palpate/record/session/device_messages.h"

namespace palpate::record::session {

PictureWriter::PictureWriter(SessionRecording& recording, const PictureRecording& how,
                             const std::string& camera)
    : recording_(recording),
      how_(how),
      frame_("camera_" + camera),
      stream_(how.lossless ? recording.stream("/camera/" + camera + "/image", "foxglove.RawImage")
                           : recording.stream("/camera/" + camera + "/image", "foxglove.CompressedImage")),
      thread_([this] { work(); }) {}

PictureWriter::~PictureWriter() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void PictureWriter::write(const device::CameraImage& image, std::int64_t arrived_ns) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= kMost) return stream_.drop();
    waiting_.push_back({image, arrived_ns});
  }
  changed_.notify_all();
}

void PictureWriter::work() {
  while (true) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const Waiting next = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    const auto time = recording_.log_time(next.arrived_ns);
    stream_.write(time, time,
                  how_.lossless ? encode_raw_image(next.image, time, frame_)
                                : encode_compressed_image(how_.jpeg(next.image), time, frame_));
  }
}

}  // namespace palpate::record::session
