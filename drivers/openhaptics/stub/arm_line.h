// The cable between the stand-in for libHD.so and an arm that lies in another process: a socket of this machine that
// keeps messages whole (SOCK_SEQPACKET at a path).
//
// The arm sends a reading about each millisecond, the library a force with each of its cycles; both in the machine's
// own byte order. Axes and angles are the library's: turret right, thigh up, shin up; gimbal right, up, clockwise; N
// along x to the user's right, y up, z towards the user. Written apart from the driver, which does not know of it.
// Any thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <mutex>

namespace hd_stub {

struct ArmReading {
  std::uint64_t number = 0;               // counts readings
  double turned[3] = {0, 0, 0};           // rad, as the encoders have it
  double gimbal[3] = {0, 0, 0};           // rad
  std::uint32_t buttons = 0, unused = 0;  // pressed ones, the first is bit 0
};
struct ArmForce {
  double force[3] = {0, 0, 0};  // N
};

// Of the arm at the path that the environment variable HD_STUB_ARM names.
class ArmLine {
 public:
  bool named() const { return path_ != nullptr; }
  // Puts the calling thread first in turn where an arm is named and the machine allows it, as the maker's library does
  // with its cycle.
  void hurry() const;
  // False where nobody is at that path.
  bool reach();
  bool is_open() const { return socket_.load() >= 0; }
  // Waits at most so long for a reading and takes the newest; false where none has come. Closed afterwards where the arm
  // is gone.
  bool take(ArmReading& reading, int ms);
  void give(const ArmForce& force);

 private:
  void close();

  const char* const path_ = std::getenv("HD_STUB_ARM");
  std::mutex guard_;
  std::atomic<int> socket_{-1};
};

}  // namespace hd_stub
