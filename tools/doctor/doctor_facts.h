// What `palpate doctor` finds on a machine, before anything is judged: one struct per area.
//
// Gathered by gather_facts(), judged by doctor_evaluate.h, and made up by tests. Texts that say why something
// is not there are empty where it is. Sizes in bytes, times in microseconds. Values, copied freely.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/arms/maker_library.h"
#include "drivers/cameras/aravis_source.h"
#include "drivers/cameras/v4l2_source.h"
#include "drivers/forcedimension/library.h"
#include "drivers/openhaptics/library.h"
#include "drivers/openhaptics/nodes.h"
#include "palpate/physics/deformable/dense_library.h"
#include "palpate/plugin/loader.h"
#include "palpate/time/real_time.h"
#include "palpate/transport/keys.h"
#include "palpate/transport/probe.h"

namespace palpate::tools::doctor {

struct RealTimeFacts {
  RealTimeGrant grant;                               // of what the haptic loop asks for
  std::optional<std::uint64_t> rtprio_limit;         // RLIMIT_RTPRIO; nothing: unlimited
  std::optional<std::uint64_t> memlock_limit;        // RLIMIT_MEMLOCK; nothing: unlimited
  std::string kernel;                                // as `uname -v` has it
  bool kernel_real_time = false;                     // /sys/kernel/realtime
  std::string preempt_argument;                      // preempt=... of the kernel's command line
  std::optional<long> rt_runtime_us, rt_period_us;   // throttling; runtime -1: off
  std::vector<std::string> governors;                // a core each; empty where the machine does not tell
  unsigned cores = 1;                                // this process may use
  std::optional<std::uint64_t> timer_resolution_ns;  // of CLOCK_MONOTONIC
};

struct ClockFacts {
  bool known = false;  // the kernel told its state
  std::string why_unknown;
  bool synchronised = false;
  std::int64_t estimated_error_us = 0, maximum_error_us = 0;
  std::vector<std::string> keepers;  // programs running that keep clocks: chronyd, ...
  std::string source;                // tsc, hpet, ...; empty where not told
};

struct SocketFacts {
  std::filesystem::path folder;  // where servers of this user meet
  bool exists = false;
  std::string folder_problem;  // as check_private_directory() says it
  unsigned mode = 0;
  std::string socket_problem;                  // why no unix socket can be made there
  std::size_t path_bytes = 0, path_limit = 0;  // of the default socket
  std::vector<std::string> leftovers;          // sockets of dead servers
  std::vector<std::string> laboratories;       // simulated ones that are open
  transport::Answered at_default;
};

// Of --listen, where it is given.
struct ListenFacts {
  std::string address;
  std::string problem;  // as parse_endpoint() says it
  bool local = false;
  transport::Listening listening;  // of tcp://
  transport::Answered answered;    // where somebody is there
};

struct KeyFacts {
  std::filesystem::path folder;
  std::string folder_problem;  // no folder can be named
  bool needed = false;         // --listen is encrypted
  bool encryption = false;     // ZeroMQ can
  unsigned folder_mode = 0;    // 0: not there
  bool pair_there = false;
  std::string public_key, pair_problem;
  std::vector<transport::AuthorizedKey> admitted;
  std::vector<std::string> complaints;
  std::string admitted_problem;
  struct Server {
    std::string address;
    transport::Answered answered;  // to the pair of this folder
  };
  std::vector<Server> servers;
  std::string servers_problem;
};

struct GraphicsFacts {
  std::string renderer, platform, problem;
};

// What `palpate graphics --window` and `--headset` need beyond that.
struct DesktopFacts {
  std::string display, window_problem;   // DISPLAY; why no window can be opened there
  std::string sound, sound_problem;      // the device, as the library names it; why nothing is heard
  std::string headset, headset_problem;  // and its OpenXR runtime; why there is none
};

struct LibraryFacts {
  std::string palpate, eigen, pictures;
  transport::NetworkLibraries network;
  physics::deformable::DenseLibrary dense;
};

struct DeviceFacts {
  std::vector<drivers::cameras::V4l2Look> cameras;            // at /dev/video*
  std::string aravis;                                         // version of the library for GenICam cameras
  bool camera_asked = false;                                  // --camera
  std::string camera_name, camera_answer;                     // who answered
  std::string camera_problem;                                 // as the driver says it, where nobody did
  std::vector<drivers::cameras::AravisLook> genicam_cameras;  // asked for where --camera is one
  drivers::openhaptics::LibraryFacts arm_library{&drivers::openhaptics::maker_library()};
  std::vector<drivers::openhaptics::ArmNode> arm_nodes;
  std::string arm_settings;         // GTDD_HOME: where the maker's driver looks for its devices; may be empty
  bool arm_settings_there = false;  // it is a folder that this user may read
  bool arm_asked = false;           // --arm
  std::string arm_name, arm_answer;  // who answered
  std::string arm_problem;           // as the driver says it, where nobody did
  drivers::arms::LibraryFacts force_dimension{&drivers::forcedimension::maker_library()};
  bool force_dimension_asked = false;  // --arm
  std::string force_dimension_answer, force_dimension_problem;
};

struct SpaceFacts {
  std::filesystem::path folder;  // the nearest one there is to the run folder
  std::optional<std::uint64_t> free_bytes;
  std::optional<std::uint64_t> open_files;  // soft limit; nothing: unlimited
};

struct Facts {
  RealTimeFacts real_time;
  ClockFacts clock;
  SocketFacts sockets;
  std::optional<ListenFacts> listen;
  KeyFacts keys;
  GraphicsFacts graphics;
  DesktopFacts desktop;
  LibraryFacts libraries;
  DeviceFacts devices;
  SpaceFacts space;
  plugin::Report plugins;
};

struct Options {
  std::filesystem::path keys;  // folder; empty: this user's
  std::string listen;          // address a physics server is to listen at; empty: the default one only
  std::string arm;             // openhaptics[:NAME], forcedimension[:SERIAL]: opens it and asks who it is
  std::string camera;          // of palpate graphics --camera: opens it and waits for a picture
  std::string version;         // of the program
  plugin::Report plugins;      // that it has loaded, or left out
};

// Looks, and leaves the machine as it was: real-time rights are asked for in a thread that ends, a socket
// lives for a moment, a window is never seen, nothing is played. Up to some seconds where servers are there
// that do not answer. Call it from the main thread, while the process has no other. Wrong use: a --listen
// that is no address, an --arm or --camera that is none.
Expected<Facts> gather_facts(const Options& options);

// Parts of it that read single files; for tests.
std::string preempt_argument_of(std::string_view command_line);

}  // namespace palpate::tools::doctor
