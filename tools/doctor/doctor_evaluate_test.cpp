#include "tools/doctor/doctor_evaluate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>

#include "drivers/forcedimension/library.h"

namespace palpate::tools::doctor {
namespace {

const Finding& named(const Findings& findings, const std::string& name) {
  const auto at = std::find_if(findings.begin(), findings.end(),
                               [&](const Finding& finding) { return finding.name == name; });
  if (at == findings.end()) throw std::runtime_error("no finding about " + name);
  return *at;
}
template <typename F>
Verdict verdict_on(const F& facts, const std::string& name) {
  return named(evaluate(facts), name).verdict;
}

// What is not well says what to do; every line is one line.
void expect_useful(const Findings& findings) {
  for (const auto& finding : findings) {
    EXPECT_EQ(finding.verdict == Verdict::ok, finding.remedy.empty()) << finding.area << ' ' << finding.name;
    EXPECT_FALSE(finding.value.empty()) << finding.area << ' ' << finding.name;
    for (const auto& text : {finding.area, finding.name, finding.value, finding.remedy})
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
}

RealTimeFacts good_loops() {
  RealTimeFacts facts;
  facts.grant.fifo_priority = 80;
  facts.grant.memory_locked = true;
  facts.rtprio_limit = 90;
  facts.kernel = "#1 SMP PREEMPT_RT Debian 6.1.1-1";
  facts.rt_runtime_us = 950000;
  facts.rt_period_us = 1000000;
  facts.governors = {"performance", "performance"};
  facts.cores = 4;
  facts.timer_resolution_ns = 1;
  return facts;
}

SocketFacts good_sockets() {
  SocketFacts facts;
  facts.folder = "/run/user/1000/palpate";
  facts.exists = true;
  facts.mode = 0700;
  facts.path_bytes = 34;
  facts.path_limit = 107;
  return facts;
}

KeyFacts good_keys() {
  KeyFacts facts;
  facts.folder = "/somewhere/palpate";
  facts.encryption = true;
  facts.folder_mode = 0700;
  facts.pair_there = true;
  facts.public_key = std::string(40, 'k');
  facts.admitted = {{transport::Role::graphics, std::string(40, 'a'), "screen"},
                    {transport::Role::graphics, std::string(40, 'b'), "other"},
                    {transport::Role::observer, std::string(40, 'c'), ""}};
  facts.servers = {
      {"tcp://10.0.0.2:5555", {transport::Answer::physics_server, transport::Role::graphics, ""}}};
  return facts;
}

Facts good_machine() {
  Facts facts;
  facts.real_time = good_loops();
  facts.clock.known = facts.clock.synchronised = true;
  facts.clock.estimated_error_us = 12;
  facts.clock.maximum_error_us = 900;
  facts.clock.keepers = {"chronyd"};
  facts.clock.source = "tsc";
  facts.sockets = good_sockets();
  facts.keys = good_keys();
  facts.graphics = {"NVIDIA RTX", "device", ""};
  facts.desktop = {":0", "", "Built-in Audio", "", "Example HMD (Monado 25.0.0)", ""};
  facts.libraries = {"0.1.0", "3.4.0", "OpenCV 4.6.0", {"4.3.4", "3.21.12", true, 1}, {"BLIS 0.9", true}};
  facts.space = {"/run/user/1000/palpate", 1ull << 30, 1024};
  return facts;
}

TEST(Doctor, AGoodMachineLacksOnlyTheDriversThatNobodyHas) {
  const auto findings = evaluate(good_machine());
  expect_useful(findings);
  for (const auto& finding : findings) {
    const bool nobody_has =
        finding.area == "devices" && finding.name != "cameras" && finding.name != "GenICam";
    EXPECT_EQ(finding.verdict, nobody_has ? Verdict::worth_knowing : Verdict::ok)
        << finding.area << ' ' << finding.name;
  }
}

TEST(Doctor, NothingToldAtAllIsStillOneUsefulLineEach) {
  Facts facts;
  facts.graphics.problem = "drawing: no display; install a driver";
  facts.desktop.window_problem = "window: no display; start it on a desktop";
  facts.desktop.sound_problem = "sound: the sound device has no voices left";
  facts.desktop.headset_problem = "headset: no OpenXR runtime is there; install one";
  facts.libraries = {"0", "0", "none", {"4.3.4", "3", false, 1}, {"OpenBLAS without threads", false}};
  facts.keys.folder_problem = "no place for keys; give --keys DIR";
  facts.space.folder = facts.sockets.folder = "/run";
  facts.clock.why_unknown = "Operation not permitted";
  facts.real_time.grant.fifo_errno = EPERM;
  facts.real_time.grant.memory_errno = ENOMEM;
  expect_useful(evaluate(facts));
  EXPECT_EQ(named(evaluate(facts), "BLAS").verdict, Verdict::worth_knowing);
}

TEST(Doctor, RealTimeRightsAreGrantedOrTheLimitsFileIsNamed) {
  auto facts = good_loops();
  EXPECT_EQ(verdict_on(facts, "SCHED_FIFO"), Verdict::ok);
  EXPECT_EQ(verdict_on(facts, "memory"), Verdict::ok);
  facts.grant = {};
  facts.grant.fifo_errno = EPERM;
  facts.grant.memory_errno = ENOMEM;
  facts.rtprio_limit = 0;
  facts.memlock_limit = 8u << 20;
  const auto findings = evaluate(facts);
  expect_useful(findings);
  EXPECT_EQ(named(findings, "SCHED_FIFO").verdict, Verdict::worth_knowing);
  EXPECT_NE(named(findings, "SCHED_FIFO").value.find("RLIMIT_RTPRIO is 0"), std::string::npos);
  EXPECT_NE(named(findings, "SCHED_FIFO").remedy.find("limits.d/palpate.conf"), std::string::npos);
  EXPECT_EQ(named(findings, "memory").verdict, Verdict::worth_knowing);
  EXPECT_NE(named(findings, "memory").value.find("8192 KiB"), std::string::npos);
}

TEST(Doctor, KernelsArePreemptedAtOnceOrNot) {
  auto facts = good_loops();
  EXPECT_EQ(verdict_on(facts, "kernel"), Verdict::ok);
  facts.kernel = "#1 SMP PREEMPT_DYNAMIC";
  EXPECT_EQ(verdict_on(facts, "kernel"), Verdict::worth_knowing);
  EXPECT_NE(named(evaluate(facts), "kernel").remedy.find("preempt=full"), std::string::npos);
  facts.preempt_argument = "full";
  EXPECT_EQ(named(evaluate(facts), "kernel").remedy.find("preempt=full"), std::string::npos);
  for (const char* kernel : {"#1 SMP PREEMPT", "#1 SMP", ""}) {
    facts.kernel = kernel;
    EXPECT_EQ(verdict_on(facts, "kernel"), Verdict::worth_knowing) << kernel;
  }
  facts.kernel_real_time = true;
  EXPECT_EQ(verdict_on(facts, "kernel"), Verdict::ok);
  EXPECT_EQ(preempt_argument_of("quiet preempt=none root=/dev/a preempt=full"), "full");
  EXPECT_EQ(preempt_argument_of("quiet notpreempt=full"), "");
}

TEST(Doctor, ThrottlingGovernorCoresAndTimers) {
  auto facts = good_loops();
  for (const char* name : {"throttling", "frequency", "cores", "timers"})
    EXPECT_EQ(verdict_on(facts, name), Verdict::ok) << name;
  facts.rt_runtime_us = -1;
  EXPECT_EQ(verdict_on(facts, "throttling"), Verdict::worth_knowing);
  facts.rt_runtime_us = 100000;
  EXPECT_EQ(verdict_on(facts, "throttling"), Verdict::worth_knowing);
  facts.rt_runtime_us.reset();
  EXPECT_EQ(verdict_on(facts, "throttling"), Verdict::ok);
  facts.governors[1] = "powersave";
  EXPECT_EQ(verdict_on(facts, "frequency"), Verdict::worth_knowing);
  facts.governors.clear();
  EXPECT_EQ(verdict_on(facts, "frequency"), Verdict::ok);
  facts.cores = 1;
  EXPECT_EQ(verdict_on(facts, "cores"), Verdict::worth_knowing);
  facts.timer_resolution_ns = 4'000'000;
  EXPECT_EQ(verdict_on(facts, "timers"), Verdict::in_the_way);
  expect_useful(evaluate(facts));
}

TEST(Doctor, TheWallClockIsKeptOrNot) {
  auto facts = good_machine().clock;
  EXPECT_EQ(verdict_on(facts, "wall clock"), Verdict::ok);
  facts.maximum_error_us = 5'000'000;
  EXPECT_EQ(verdict_on(facts, "wall clock"), Verdict::worth_knowing);
  facts.synchronised = false;
  EXPECT_NE(named(evaluate(facts), "wall clock").value.find("chronyd runs"), std::string::npos);
  facts.keepers.clear();
  EXPECT_EQ(verdict_on(facts, "wall clock"), Verdict::worth_knowing);
  EXPECT_NE(named(evaluate(facts), "wall clock").remedy.find("chrony"), std::string::npos);
  facts.known = false;
  EXPECT_EQ(verdict_on(facts, "wall clock"), Verdict::worth_knowing);
}

TEST(Doctor, ClockSourcesAreReadQuicklyOrSlowly) {
  auto facts = good_machine().clock;
  for (const char* source : {"tsc", "kvm-clock", "arch_sys_counter", ""}) {
    facts.source = source;
    EXPECT_EQ(verdict_on(facts, "source"), Verdict::ok) << source;
  }
  for (const char* source : {"hpet", "acpi_pm", "jiffies"}) {
    facts.source = source;
    EXPECT_EQ(verdict_on(facts, "source"), Verdict::worth_knowing) << source;
  }
}

TEST(Doctor, TheRunFolderIsOurOwnAndTakesSockets) {
  auto facts = good_sockets();
  EXPECT_EQ(verdict_on(facts, "run folder"), Verdict::ok);
  EXPECT_EQ(verdict_on(facts, "unix socket"), Verdict::ok);
  facts.exists = false;
  EXPECT_EQ(verdict_on(facts, "run folder"), Verdict::ok);
  facts.folder_problem = "/run/x: open to other users (mode 755), expected 700; chmod 700 it";
  EXPECT_EQ(verdict_on(facts, "run folder"), Verdict::in_the_way);
  EXPECT_EQ(named(evaluate(facts), "run folder").remedy, "chmod 700 it");
  facts.socket_problem = "Read-only file system";
  EXPECT_EQ(verdict_on(facts, "unix socket"), Verdict::in_the_way);
  facts = good_sockets();
  facts.path_bytes = 108;
  EXPECT_EQ(verdict_on(facts, "unix socket"), Verdict::in_the_way);
}

TEST(Doctor, WhoIsAtTheDefaultAddress) {
  auto facts = good_sockets();
  EXPECT_EQ(verdict_on(facts, "physics server"), Verdict::ok);
  facts.at_default.who = transport::Answer::physics_server;
  EXPECT_EQ(verdict_on(facts, "physics server"), Verdict::ok);
  EXPECT_NE(named(evaluate(facts), "physics server").value.find("answers"), std::string::npos);
  facts.at_default.who = transport::Answer::stranger;
  EXPECT_EQ(verdict_on(facts, "physics server"), Verdict::in_the_way);
  facts.leftovers = {"physics.sock"};
  EXPECT_EQ(verdict_on(facts, "leftovers"), Verdict::worth_knowing);
  expect_useful(evaluate(facts));
}

TEST(Doctor, AnAddressToListenAtIsFreeTakenOrNotOurs) {
  ListenFacts facts;
  facts.address = "tcp://*:5555";
  facts.listening.possible = true;
  const auto verdict = [&] {
    const auto findings = evaluate(facts);
    expect_useful(findings);
    return findings.at(0).verdict;
  };
  EXPECT_EQ(verdict(), Verdict::ok);
  facts.listening = {false, false, "No such device"};
  EXPECT_EQ(verdict(), Verdict::in_the_way);
  facts.listening = {false, true, "Address already in use"};
  EXPECT_EQ(verdict(), Verdict::in_the_way);
  for (const auto who : {transport::Answer::physics_server, transport::Answer::not_admitted}) {
    facts.answered.who = who;
    EXPECT_EQ(verdict(), Verdict::ok);
  }
  facts.answered.who = transport::Answer::stranger;
  EXPECT_EQ(verdict(), Verdict::in_the_way);
  facts.problem = "/tmp: others can write to it; chmod 700 it";
  EXPECT_EQ(verdict(), Verdict::in_the_way);
  facts = {};
  facts.address = "ipc:///somewhere/x.sock";
  facts.local = true;
  EXPECT_EQ(verdict(), Verdict::ok);
}

TEST(Doctor, KeysThatAreThereAreCountedAndMissingOnesMatterWhereTheyAreNeeded) {
  auto facts = good_keys();
  expect_useful(evaluate(facts));
  EXPECT_EQ(named(evaluate(facts), "admitted").value, "1 as observer, 2 as graphics, 0 as operator");
  for (const bool folder_there : {true, false}) {
    facts = good_keys();
    facts.pair_there = false;
    facts.folder_mode = folder_there ? 0700 : 0;
    EXPECT_EQ(verdict_on(facts, "pair"), Verdict::ok);
    facts.needed = true;
    EXPECT_EQ(verdict_on(facts, "pair"), Verdict::in_the_way);
    expect_useful(evaluate(facts));
  }
  facts = good_keys();
  facts.admitted.clear();
  EXPECT_EQ(verdict_on(facts, "admitted"), Verdict::ok);
  facts.needed = true;
  EXPECT_EQ(verdict_on(facts, "admitted"), Verdict::worth_knowing);
  facts.folder_problem = "no place for keys; give --keys DIR";
  EXPECT_EQ(verdict_on(facts, "folder"), Verdict::in_the_way);
  facts.needed = false;
  EXPECT_EQ(verdict_on(facts, "folder"), Verdict::worth_knowing);
}

TEST(Doctor, KeysThatOthersCouldTouchAreInTheWay) {
  auto facts = good_keys();
  facts.pair_problem = "secret_key: others can read it (mode 644); chmod 600 it";
  EXPECT_EQ(verdict_on(facts, "pair"), Verdict::in_the_way);
  EXPECT_EQ(named(evaluate(facts), "pair").remedy, "chmod 600 it");
  facts = good_keys();
  facts.admitted_problem = "authorized_keys: others can write it (mode 666); chmod 644 it";
  EXPECT_EQ(verdict_on(facts, "admitted"), Verdict::in_the_way);
  facts.servers_problem = "known_servers:1: an address and a public key of 40 characters are expected";
  EXPECT_EQ(verdict_on(facts, "known servers"), Verdict::in_the_way);
  facts.folder_mode = 0777;
  EXPECT_EQ(verdict_on(facts, "folder"), Verdict::worth_knowing);
  facts.complaints = {"authorized_keys:3: 'king' is no role"};
  EXPECT_EQ(verdict_on(facts, "line"), Verdict::worth_knowing);
  facts.encryption = false;
  EXPECT_EQ(verdict_on(facts, "encryption"), Verdict::worth_knowing);
  facts.needed = true;
  EXPECT_EQ(verdict_on(facts, "encryption"), Verdict::in_the_way);
  expect_useful(evaluate(facts));
}

TEST(Doctor, KnownServersAnswerKeepSilentOrTurnUsAway) {
  auto facts = good_keys();
  auto& answered = facts.servers[0].answered;
  EXPECT_EQ(verdict_on(facts, "server"), Verdict::ok);
  EXPECT_NE(named(evaluate(facts), "server").value.find("graphics"), std::string::npos);
  answered = {};
  EXPECT_EQ(verdict_on(facts, "server"), Verdict::worth_knowing);
  EXPECT_NE(named(evaluate(facts), "server").remedy.find("firewalls"), std::string::npos);
  answered.who = transport::Answer::not_admitted;
  EXPECT_EQ(verdict_on(facts, "server"), Verdict::in_the_way);
  EXPECT_NE(named(evaluate(facts), "server").remedy.find("palpate keys authorize"), std::string::npos);
  answered.who = transport::Answer::stranger;
  answered.trouble = "it has another key";
  EXPECT_EQ(verdict_on(facts, "server"), Verdict::in_the_way);
  EXPECT_NE(named(evaluate(facts), "server").value.find("another key"), std::string::npos);
  expect_useful(evaluate(facts));
}

TEST(Doctor, GraphicsComeFromACardTheProcessorOrNowhere) {
  GraphicsFacts facts{"NVIDIA RTX", "device", ""};
  EXPECT_EQ(verdict_on(facts, "OpenGL 3.3"), Verdict::ok);
  facts.renderer = "llvmpipe (LLVM 15.0.6, 256 bits)";
  EXPECT_EQ(verdict_on(facts, "OpenGL 3.3"), Verdict::worth_knowing);
  facts.problem = "drawing: no EGL display offers it; install a graphics driver";
  EXPECT_EQ(verdict_on(facts, "OpenGL 3.3"), Verdict::in_the_way);
  EXPECT_EQ(named(evaluate(facts), "OpenGL 3.3").remedy, "install a graphics driver");
}

TEST(Doctor, CamerasMayBeReadOrNotAndTheOneAskedForHasToAnswer) {
  DeviceFacts facts;
  facts.aravis = "0.8.26";
  EXPECT_EQ(verdict_on(facts, "cameras"), Verdict::ok);
  facts.cameras = {{"/dev/video0", "Webcam C270", true, {"YUYV", "MJPEG"}, ""}};
  EXPECT_EQ(verdict_on(facts, "camera"), Verdict::ok);
  EXPECT_EQ(named(evaluate(facts), "camera").value, "/dev/video0, Webcam C270 (YUYV, MJPEG)");
  facts.cameras[0].problem = "/dev/video0: you may not read and write it; join group video";
  EXPECT_EQ(verdict_on(facts, "camera"), Verdict::worth_knowing);
  EXPECT_EQ(named(evaluate(facts), "camera").remedy, "join group video");
  facts.camera_asked = true;
  facts.camera_name = "v4l2:/dev/video0", facts.camera_answer = "Webcam C270, 640x480 px, YUYV";
  EXPECT_EQ(verdict_on(facts, "camera asked for"), Verdict::ok);
  facts.camera_problem = "camera v4l2:/dev/video0: another program uses it; end that one";
  EXPECT_EQ(verdict_on(facts, "camera asked for"), Verdict::in_the_way);
  EXPECT_EQ(named(evaluate(facts), "camera asked for").remedy, "end that one");
  facts.genicam_cameras = {{"Aravis-Fake-GV01", "Aravis Fake", "GV01", "127.0.0.1", "GigEVision"}};
  expect_useful(evaluate(facts));
  EXPECT_EQ(verdict_on(facts, "haptic arm"), Verdict::worth_knowing);
}

TEST(Doctor, ForceDimensionsLibraryIsToldWhereItIsAndMissedWhereItIsAskedFor) {
  using drivers::arms::LibraryProblem;
  DeviceFacts facts;
  facts.force_dimension = {&drivers::forcedimension::maker_library(), LibraryProblem::static_library,
                           "/usr/local/lib/libdrd.a", "", ""};
  for (const auto& finding : evaluate(facts)) EXPECT_NE(finding.name, "Force Dimension") << "nobody asked";
  facts.force_dimension_asked = true;
  EXPECT_EQ(verdict_on(facts, "Force Dimension"), Verdict::in_the_way);
  EXPECT_NE(named(evaluate(facts), "Force Dimension").value.find("libdrd.a is a static library"),
            std::string::npos);
  facts.force_dimension.problem = LibraryProblem::none;
  facts.force_dimension.version = "3.17.5";
  facts.force_dimension_answer = "omega.3, serial 1001, 12.0 N";
  EXPECT_EQ(verdict_on(facts, "Force Dimension"), Verdict::ok);
  EXPECT_EQ(verdict_on(facts, "arm"), Verdict::ok);
  facts.force_dimension_problem = "arm forcedimension: there is no device; plug it in";
  EXPECT_EQ(verdict_on(facts, "arm"), Verdict::in_the_way);
  EXPECT_EQ(named(evaluate(facts), "arm").remedy, "plug it in");
}

TEST(Doctor, ARealArmLacksItsLibraryItsNodeItsSettingsOrNothing) {
  using drivers::openhaptics::LibraryProblem;
  DeviceFacts facts;
  for (const auto problem :
       {LibraryProblem::not_found, LibraryProblem::unreadable, LibraryProblem::not_a_library,
        LibraryProblem::thirty_two_bit, LibraryProblem::other_machine, LibraryProblem::missing_dependency,
        LibraryProblem::missing_function, LibraryProblem::not_loadable}) {
    facts.arm_library = {&drivers::openhaptics::maker_library(), problem, "/usr/lib/libHD.so",
                         "libPhantomIOLib42.so", ""};
    facts.arm_asked = false;
    EXPECT_EQ(verdict_on(facts, "haptic arm"), Verdict::worth_knowing);
    facts.arm_asked = true;
    EXPECT_EQ(verdict_on(facts, "haptic arm"), Verdict::in_the_way);
    EXPECT_NE(named(evaluate(facts), "haptic arm").value.find("/usr/lib/libHD.so"), std::string::npos);
    expect_useful(evaluate(facts));
  }
  facts.arm_library = {&drivers::openhaptics::maker_library(), LibraryProblem::none, "/usr/lib/libHD.so", "",
                       "3.4.0"};
  facts.arm_answer = "Touch, serial 0042, 3.3 N";
  EXPECT_EQ(verdict_on(facts, "haptic arm"), Verdict::ok);
  EXPECT_EQ(verdict_on(facts, "arm"), Verdict::ok);
  for (const auto& finding : evaluate(facts))
    EXPECT_NE(finding.name, "arm node") << "it answers, however it is connected";
  facts.arm_problem = "arm openhaptics: device 'X': it does not answer; see that it has power";
  EXPECT_EQ(verdict_on(facts, "arm"), Verdict::in_the_way);
  EXPECT_EQ(verdict_on(facts, "arm node"), Verdict::worth_knowing);  // it may be at Ethernet
  EXPECT_EQ(named(evaluate(facts), "arm").remedy, "see that it has power");
  facts.arm_nodes = {{"USB 2988:0302 Touch", "/dev/ttyACM0", false, "dialout"}};
  EXPECT_EQ(verdict_on(facts, "arm node"), Verdict::in_the_way);
  EXPECT_NE(named(evaluate(facts), "arm node").remedy.find("usermod -aG dialout"), std::string::npos);
  facts.arm_nodes[0].group = "";
  EXPECT_NE(named(evaluate(facts), "arm node").remedy.find("udev"), std::string::npos);
  facts.arm_nodes[0].path = "";
  EXPECT_NE(named(evaluate(facts), "arm node").remedy.find("modprobe"), std::string::npos);
  facts.arm_nodes[0] = {"USB 2988:0302 Touch", "/dev/ttyACM0", true, "dialout"};
  EXPECT_EQ(verdict_on(facts, "arm node"), Verdict::ok);
  facts.arm_settings = "/opt/nowhere";
  EXPECT_EQ(verdict_on(facts, "arm settings"), Verdict::in_the_way);
  facts.arm_asked = false;
  EXPECT_EQ(verdict_on(facts, "arm settings"), Verdict::worth_knowing);
  expect_useful(evaluate(facts));
}

TEST(Doctor, PlugInsAreToldWithWhereTheyComeFromAndWhyOthersWereLeftOut) {
  EXPECT_TRUE(evaluate(plugin::Report{}).empty());
  const auto found = evaluate(plugin::Report{
      .loaded = {{.file = "/opt/jelly.so",
                  .name = "jelly",
                  .applications = {"jelly", "pudding"},
                  .drivers = {"spoon"}}},
      .skipped = {"plug-in /opt/old.so: is made for Palpate 0.0.9, and this is 0.1.0; build it anew"}});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].verdict, Verdict::ok);
  EXPECT_EQ(found[0].name, "jelly");
  EXPECT_EQ(found[0].value, "applications jelly, pudding, drivers spoon, /opt/jelly.so");
  EXPECT_EQ(found[1].verdict, Verdict::worth_knowing);
  EXPECT_EQ(found[1].value, "plug-in /opt/old.so: is made for Palpate 0.0.9, and this is 0.1.0");
  EXPECT_EQ(found[1].remedy, "build it anew");
}

TEST(Doctor, SpaceAndOpenFilesAreEnoughScarceOrTooFew) {
  SpaceFacts facts{"/dev/shm", 1ull << 30, std::nullopt};
  EXPECT_EQ(verdict_on(facts, "run folder"), Verdict::ok);
  EXPECT_EQ(verdict_on(facts, "open files"), Verdict::ok);
  facts = {"/dev/shm", 64ull << 20, 128};
  EXPECT_EQ(verdict_on(facts, "run folder"), Verdict::worth_knowing);
  EXPECT_EQ(verdict_on(facts, "open files"), Verdict::worth_knowing);
  facts = {"/dev/shm", 1ull << 20, 32};
  EXPECT_EQ(verdict_on(facts, "run folder"), Verdict::in_the_way);
  EXPECT_EQ(verdict_on(facts, "open files"), Verdict::in_the_way);
  expect_useful(evaluate(facts));
  facts.free_bytes.reset();
  EXPECT_EQ(verdict_on(facts, "run folder"), Verdict::worth_knowing);
}

TEST(Doctor, JsonHasEveryFindingAndCountsThem) {
  auto facts = good_machine();
  facts.graphics.problem = "none; install one";
  const auto findings = evaluate(facts);
  const Json json = to_json(findings);
  ASSERT_EQ(json["findings"].size(), findings.size());
  for (const char* key : {"area", "name", "verdict", "value", "remedy"})
    EXPECT_TRUE(json["findings"][0].contains(key)) << key;
  EXPECT_EQ(json["in_the_way"], 1);
  EXPECT_EQ(json["ok"].get<std::size_t>() + json["worth_knowing"].get<std::size_t>() + 1, findings.size());
}

}  // namespace
}  // namespace palpate::tools::doctor
