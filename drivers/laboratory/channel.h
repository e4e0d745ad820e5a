// The laboratory's devices across a process border: the process that owns the simulated laboratory serves,
// the physics and graphics servers are its clients. Shared memory on one machine, raw samples in the devices'
// own clocks, never truth; receive times are the clients' own.
//
// A laboratory has a name; its file lies in a folder of this user alone (palpate/core/run_directory.h). A
// lock held by the serving process says whether it lives, so what a dead one left behind is replaced without
// asking. Clients notice by a heartbeat that the server is gone.
//
// Threads. Server: one thread per channel (arm and force; tracker; each camera; hand; display), heartbeat()
// from any of them. Clients: each device object in one thread, all of them may share one LabClient. Arm and
// force neither lock, allocate nor throw. Memory model: palpate/core/broadcast_ring.h.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/file_descriptor.h"
#include "palpate/device/devices.h"
#include "palpate/device/heartbeat_monitor.h"
#include "palpate/device/spare_pixels.h"

namespace palpate::drivers::laboratory {

class Mapping;
struct LabMemory;

struct LabSettings {
  int cameras = 1;  // 1 or 2
  int width = 640, height = 480;
  std::filesystem::path folder;  // empty: run_directory()
  bool states_place = false;     // the arm: its readings are a place
};

// --- the process that owns the laboratory

struct ForceCommand {
  Vector3 force = Vector3::Zero();  // N, ArmBase
  Duration age{0};                  // since it was commanded: what is too old is no command any more
  std::uint64_t count = 0;
  bool let_go = false;  // taken back: the force is 0 until the next command
};

// What the display's cable brought.
struct ShownTimecode {
  std::int64_t sent_ns = 0;  // CLOCK_MONOTONIC, when it was handed over
  Duration code{0};
};

class LabServer {
 public:
  // Refused where another process serves this name, or the folder or memory cannot be had.
  static Expected<std::unique_ptr<LabServer>> open(const std::string& name, const LabSettings& settings = {});
  ~LabServer();  // tells the clients, removes the file

  void publish_arm(const device::ArmSample& sample) noexcept;
  std::optional<ForceCommand> take_force() const noexcept;  // the newest; none was ever commanded: nothing
  void publish_tracker(const device::TrackerSample& sample) noexcept;
  // False where it is larger than the laboratory's images, or there is no such camera. A smaller one is that
  // of a camera that fails, and goes through as it is.
  // Where drawing it took longer than a camera takes to bring it, image.waited says how long ago it should
  // have come, and the channel carries that on.
  bool publish_image(const device::CameraImage& image, int camera = 0) noexcept;
  std::optional<device::HandTarget>
  take_hand_target() noexcept;                  // the newest, if there is one since the last call
  std::vector<ShownTimecode> take_timecodes();  // since the last call, oldest first; at most the last four
                                                // seconds

  // At least every 0.2 s; a second of silence means dead.
  void heartbeat() noexcept;
  struct Peers {
    int clients = 0;                 // heard of within the last second
    bool arm = false, hand = false;  // someone holds it
    bool arm_lost = false;           // its holder has gone silent without letting go
  };
  Peers peers() noexcept;

 private:
  LabServer(std::unique_ptr<Mapping> mapping, std::filesystem::path file, FileDescriptor lock);
  std::unique_ptr<Mapping> mapping_;
  LabMemory* memory_;
  std::filesystem::path file_;
  FileDescriptor lock_;
  std::uint64_t hand_targets_ = 0, timecodes_ = 0;
  device::HeartbeatMonitor arm_silence_, hand_silence_;
};

// --- its clients

class LabClient {
 public:
  // Refused where there is no such laboratory, it has died, or it is of another build.
  static Expected<std::shared_ptr<LabClient>> open(const std::string& name,
                                                   const std::filesystem::path& folder = {});
  ~LabClient();

  // By one thread, often: silence counts while this process runs itself (heartbeat_monitor.h). A laboratory
  // that merely stands still for a while is silent, and not gone.
  bool alive() noexcept;
  Expected<void> check();                  // the same, with the reason
  bool silent() const { return silent_; }  // at the last look: stands still
  int cameras() const noexcept;
  bool states_place() const noexcept;  // the arm
  LabMemory* memory() const noexcept { return memory_; }
  const Mapping& mapping() const noexcept;
  std::uint32_t peer() const noexcept { return peer_; }
  const std::string& name() const { return name_; }
  void heartbeat() noexcept;  // the devices call it whenever they are used

 private:
  LabClient(std::string name, std::unique_ptr<Mapping> mapping, std::uint32_t peer);
  std::string name_;
  std::unique_ptr<Mapping> mapping_;
  LabMemory* memory_;
  std::uint32_t peer_;
  device::HeartbeatMonitor silence_;
  bool silent_ = false;
};

class LabArm : public device::ArmDevice {
 public:
  // Refused where another living process holds the arm, or no sample comes within a second. A new holder
  // begins at zero force; so does the arm when it is let go.
  static Expected<std::unique_ptr<LabArm>> open(std::shared_ptr<LabClient> client);
  ~LabArm() override;
  device::ArmSample read() override;
  void command(const Vector3& force) override;
  void let_go() noexcept override;

 private:
  explicit LabArm(std::shared_ptr<LabClient> client);
  std::shared_ptr<LabClient> client_;
  LabMemory* memory_;
};

class LabTracker : public device::TrackerDevice {
 public:
  explicit LabTracker(std::shared_ptr<LabClient> client);  // samples from now on
  std::vector<device::TrackerSample> poll() override;
  std::uint64_t lost() const { return lost_; }  // overwritten before they were polled

 private:
  std::shared_ptr<LabClient> client_;
  std::uint64_t next_ = 0, lost_ = 0;
};

class LabCamera : public device::CameraDevice {
 public:
  // Wrong use where the laboratory has no such camera.
  static Expected<std::unique_ptr<LabCamera>> open(std::shared_ptr<LabClient> client, int camera = 0);
  std::optional<device::CameraImage> poll() override;
  void take_back(device::CameraImage image) override { spare_.keep(std::move(image.rgb)); }

 private:
  LabCamera(std::shared_ptr<LabClient> client, int camera);
  std::shared_ptr<LabClient> client_;
  int camera_;
  std::uint64_t next_ = 0;
  device::SparePixels spare_;
};

class LabHand : public device::HandDevice {
 public:
  // Refused where another living process moves the hand.
  static Expected<std::unique_ptr<LabHand>> open(std::shared_ptr<LabClient> client);
  ~LabHand() override;
  void move_to(const device::HandTarget& target) override;

 private:
  explicit LabHand(std::shared_ptr<LabClient> client) : client_(std::move(client)) {}
  std::shared_ptr<LabClient> client_;
};

class LabDisplay : public device::DisplayDevice {
 public:
  // Refused where another living process uses the display.
  static Expected<std::unique_ptr<LabDisplay>> open(std::shared_ptr<LabClient> client);
  ~LabDisplay() override;
  std::int64_t show_timecode(Duration code) override;

 private:
  explicit LabDisplay(std::shared_ptr<LabClient> client) : client_(std::move(client)) {}
  std::shared_ptr<LabClient> client_;
};

}  // namespace palpate::drivers::laboratory
