// Picture, desktop, libraries, arm and cameras: what the loops themselves do not need.
#include <fmt/ranges.h>

#include "tools/doctor/doctor_evaluate.h"
#include "tools/doctor/doctor_findings.h"

namespace palpate::tools::doctor {

Findings evaluate(const GraphicsFacts& facts) {
  constexpr const char* kArea = "graphics";
  if (!facts.problem.empty()) return {told(Verdict::in_the_way, kArea, "OpenGL 3.3", facts.problem)};
  const std::string value = fmt::format("{} ({})", facts.renderer, facts.platform);
  for (const char* software : {"llvmpipe", "softpipe", "swrast", "SWR"})
    if (facts.renderer.find(software) != std::string::npos)
      return {note(kArea, "OpenGL 3.3", "drawn by the processor: " + value,
                   "a graphics card and its driver, where full picture rate is wanted beside physics")};
  return {fine(kArea, "OpenGL 3.3", value)};
}

// Nobody needs a window or sound to serve: pictures go to files, and who wears a display of their own hears
// the real thing.
Findings evaluate(const DesktopFacts& facts) {
  constexpr const char* kArea = "desktop";
  return {facts.window_problem.empty()
              ? fine(kArea, "window", fmt::format("can be opened at display {}", facts.display))
              : told(Verdict::worth_knowing, kArea, "window", facts.window_problem),
          facts.sound_problem.empty() ? fine(kArea, "sound", facts.sound)
                                      : told(Verdict::worth_knowing, kArea, "sound", facts.sound_problem),
          facts.headset_problem.empty()
              ? fine(kArea, "headset", facts.headset)
              : told(Verdict::worth_knowing, kArea, "headset", facts.headset_problem)};
}

Findings evaluate(const LibraryFacts& facts) {
  constexpr const char* kArea = "libraries";
  return {fine(kArea, "palpate", fmt::format("{}, protocol {}", facts.palpate, facts.network.protocol)),
          fine(kArea, "ZeroMQ",
               fmt::format("{}, {} CURVE", facts.network.zeromq, facts.network.curve ? "with" : "without")),
          fine(kArea, "protobuf", facts.network.protobuf),
          fine(kArea, "Eigen", facts.eigen),
          facts.dense.in_threads
              ? fine(kArea, "BLAS", facts.dense.name)
              : note(kArea, "BLAS", facts.dense.name + ": wrong results where two threads call it at once",
                     "apt-get install libblis4-serial; apt-get remove libopenblas0-serial"),
          fine(kArea, "pictures", facts.pictures)};
}

namespace {
// Where --arm asks for a real arm, what it lacks is in the way; otherwise nobody may need it.
Findings evaluate_arm(const DeviceFacts& facts) {
  constexpr const char* kArea = "devices";
  const Verdict lacking = facts.arm_asked ? Verdict::in_the_way : Verdict::worth_knowing;
  Findings found;
  const auto& library = facts.arm_library;
  const bool works = library.problem == drivers::openhaptics::LibraryProblem::none;
  if (works) {
    found.push_back(fine(
        kArea, "haptic arm",
        fmt::format("OpenHaptics {}, {}", library.version.empty() ? "?" : library.version, library.file)));
  } else {
    found.push_back(finding(kArea, "haptic arm", lacking, "no real one: " + library.reason(),
                            library.remedy() + (facts.arm_asked ? "" : "; palpate world run simulates one")));
  }
  const bool answers = facts.arm_asked && works && facts.arm_problem.empty();
  if (facts.arm_nodes.empty() && !answers && (works || facts.arm_asked))
    found.push_back(note(kArea, "arm node", "no PHANToM or Touch at USB or FireWire",
                         "see to its cable and power; one at Ethernet does not show here"));
  for (const auto& node : facts.arm_nodes) {
    if (node.path.empty()) {
      found.push_back(finding(kArea, "arm node", lacking, node.device + ": no node in /dev",
                              "load its kernel driver (modprobe cdc_acm; FireWire: firewire_ohci)"));
    } else if (node.usable) {
      found.push_back(fine(kArea, "arm node", fmt::format("{}, {}", node.device, node.path)));
    } else {
      found.push_back(finding(
          kArea, "arm node", lacking,
          fmt::format("{}, {}: you may not read and write it", node.device, node.path),
          node.group.empty()
              ? std::string("install the maker's udev rules, plug it in again")
              : fmt::format("join group {} (usermod -aG {} USER), log in anew", node.group, node.group)));
    }
  }
  if (!facts.arm_settings.empty() && !facts.arm_settings_there)
    found.push_back(finding(
        kArea, "arm settings", lacking, "GTDD_HOME=" + facts.arm_settings + ": no folder that you may read",
        "run the maker's setup program as yourself, not with sudo, or correct GTDD_HOME"));
  if (facts.arm_asked && works) {
    const std::string name = facts.arm_name.empty() ? "default device" : facts.arm_name;
    found.push_back(facts.arm_problem.empty() ? fine(kArea, "arm", name + ": " + facts.arm_answer)
                                              : told(Verdict::in_the_way, kArea, "arm", facts.arm_problem));
  }
  return found;
}

// Without --arm it is told only where it is there.
Findings evaluate_force_dimension(const DeviceFacts& facts) {
  constexpr const char *kArea = "devices", *kName = "Force Dimension";
  const auto& library = facts.force_dimension;
  const bool works = library.problem == drivers::arms::LibraryProblem::none;
  if (!works && !facts.force_dimension_asked) return {};
  if (!works) return {finding(kArea, kName, Verdict::in_the_way, library.reason(), library.remedy())};
  Findings found{fine(kArea, kName, fmt::format("SDK {}, {}", library.version, library.file))};
  if (facts.force_dimension_asked)
    found.push_back(facts.force_dimension_problem.empty()
                        ? fine(kArea, "arm", facts.force_dimension_answer)
                        : told(Verdict::in_the_way, kArea, "arm", facts.force_dimension_problem));
  return found;
}

// As for the arm: what --camera asks for and lacks is in the way.
void evaluate_cameras(const DeviceFacts& facts, Findings& found) {
  constexpr const char* kArea = "devices";
  if (facts.cameras.empty()) found.push_back(fine(kArea, "cameras", "none at /dev/video*"));
  for (const auto& camera : facts.cameras) {
    if (!camera.problem.empty()) {
      found.push_back(told(Verdict::worth_knowing, kArea, "camera", camera.problem));
    } else if (camera.camera) {
      found.push_back(
          fine(kArea, "camera",
               fmt::format("{}, {} ({})", camera.path, camera.model, fmt::join(camera.formats, ", "))));
    }
  }
  found.push_back(
      fine(kArea, "GenICam", fmt::format("Aravis {}; palpate camera list asks who is there", facts.aravis)));
  for (const auto& camera : facts.genicam_cameras)
    found.push_back(note(kArea, "GenICam", fmt::format("{} at {} answers", camera.name, camera.address),
                         "name it: --camera aravis:" + camera.name));
  if (!facts.camera_asked) return;
  found.push_back(facts.camera_problem.empty()
                      ? fine(kArea, "camera asked for", facts.camera_name + ": " + facts.camera_answer)
                      : told(Verdict::in_the_way, kArea, "camera asked for", facts.camera_problem));
}
}  // namespace

Findings evaluate(const DeviceFacts& facts) {
  constexpr const char* kArea = "devices";
  Findings found = evaluate_arm(facts);
  for (auto& finding : evaluate_force_dimension(facts)) found.push_back(std::move(finding));
  found.push_back(
      note(kArea, "tracker", "over OpenIGTLink or VRPN, or NDI's, live and to record from",
           "palpate graphics --tracker igtl://HOST:PORT, vrpn://HOST:PORT or ndi://HOST:PORT, palpate "
           "tracker listen (docs/openigtlink.md); palpate world run simulates one"));
  evaluate_cameras(facts, found);
  return found;
}

}  // namespace palpate::tools::doctor
