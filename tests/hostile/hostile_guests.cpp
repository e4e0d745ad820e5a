// Plug-ins whose guests misbehave, for the real program: applications that push for a while and then go wrong, each in
// its own way, and a driver that hands the simulated laboratory's arm on and writes down what it is commanded. As
// listened:sleeps, :throws, :nan, :hangs and :crashes the driver itself goes wrong, in its read().
//
// PALPATE_HOSTILE_LOG names the file of the latter: rows of three doubles, s of the monotonic clock, N, and what it is
// (0 commanded, 1 let go, 2 the guest goes wrong now).
#include <fcntl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "drivers/laboratory/driver.h"
#include "palpate/plugin/plugin.h"

namespace hostile {
namespace {

using namespace palpate;

constexpr double kAsked = 1.0;  // N
// So often the arm was commanded that force, one time after the other, before a guest goes wrong; with
// PALPATE_HOSTILE_FELT_N in the environment ten times that one.
constexpr int kFelt = 200, kFeltBriefly = 10;

class Log {
 public:
  enum Kind { commanded, let_go, wrong };
  static Log& shared() {
    static Log log;
    return log;
  }
  bool felt() const noexcept { return felt_ >= times_; }
  void write(double force, Kind kind) noexcept {
    if (kind == commanded && !felt()) felt_ = force > least_ ? felt_ + 1 : 0;
    const std::size_t row = next_.fetch_add(1);
    if (rows_ == nullptr || row >= kRows) return;
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    rows_[row] = {static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec), force,
                  static_cast<double>(kind)};
  }

 private:
  struct Row {
    double time, force, kind;
  };
  static constexpr std::size_t kRows = 1 << 17;
  Log() {
    if (const char* least = std::getenv("PALPATE_HOSTILE_FELT_N"))
      least_ = std::atof(least), times_ = kFeltBriefly;
    const char* name = std::getenv("PALPATE_HOSTILE_LOG");
    if (name == nullptr) return;
    const int file = open(name, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (file < 0 || ftruncate(file, kRows * sizeof(Row)) != 0) std::abort();
    void* at = mmap(nullptr, kRows * sizeof(Row), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (at == MAP_FAILED) std::abort();
    rows_ = static_cast<Row*>(at);
    close(file);
  }
  Row* rows_ = nullptr;
  double least_ = 0.95 * kAsked;  // N
  int times_ = kFelt;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<int> felt_ = 0;
};

void sleep_10_ms() {
  timespec rest{0, 10'000'000};
  nanosleep(&rest, nullptr);
}

// What goes wrong in the haptic tick: the force it asks for instead.
enum class InLaw { nothing, sleeps, hangs, no_number, kilonewton, crashes };
class Law : public scene::ContactLaw {
 public:
  explicit Law(InLaw wrong) : wrong_(wrong) {}
  Vector3 force(const scene::TipState&, double) noexcept override {
    const bool now = wrong_ != InLaw::nothing && Log::shared().felt();
    if (now && !told_) Log::shared().write(0.0, Log::wrong);
    told_ = told_ || now;
    if (!now) return {0.0, kAsked, 0.0};
    if (wrong_ == InLaw::sleeps) sleep_10_ms();
    if (wrong_ == InLaw::hangs)
      for (;;) sleep_10_ms();
    if (wrong_ == InLaw::no_number) return {0.0, std::numeric_limits<double>::quiet_NaN(), 0.0};
    if (wrong_ == InLaw::kilonewton) return {0.0, 1000.0, 0.0};
    if (wrong_ == InLaw::crashes) std::raise(SIGSEGV);
    return {0.0, kAsked, 0.0};
  }
  double force_bound() const override { return 5.0; }
  Duration cost_bound() const override { return std::chrono::microseconds(200); }

 private:
  InLaw wrong_;
  bool told_ = false;
};

enum class InStep { nothing, throws, hangs };
class Application : public scene::Application {
 public:
  Application(InStep wrong, InLaw law) : wrong_(wrong), law_(law) {}
  void step(Instant<PhysicsClock>, Duration, const scene::TipState&, scene::SceneState&) override {
    if (wrong_ == InStep::nothing || !Log::shared().felt()) return;
    Log::shared().write(0.0, Log::wrong);
    if (wrong_ == InStep::throws) throw std::runtime_error("no more levels");
    for (;;) sleep_10_ms();
  }
  const scene::ImpactEvent& impact() const override { return none_; }
  scene::ContactLaw* contact_law() override { return &law_; }

 private:
  void begin() override {}
  void reset() override {}
  InStep wrong_;
  Law law_;
  scene::ImpactEvent none_;
};

struct View : scene::SceneView {
  std::vector<scene::DrawItem> draw(const scene::SceneState&) const override { return {}; }
  std::vector<std::string> captions(const scene::SceneState&) const override { return {}; }
};

scene::ApplicationSpec guest(const char* name, InStep step, InLaw law) {
  scene::ApplicationSpec spec;
  spec.name = name;
  spec.summary = "goes wrong once it is felt";
  spec.make_physics = [step, law](const scene::SceneDescription&, const scene::RunSettings&) {
    return std::make_unique<Application>(step, law);
  };
  spec.make_view = [](const scene::SceneDescription&) { return std::make_unique<View>(); };
  return spec;
}

// What goes wrong in the driver's read().
constexpr std::string_view kInRead[] = {"", "sleeps", "throws", "nan", "hangs", "crashes"};

// The laboratory's arm, and what it is commanded.
class ListenedArm : public device::OpenedArm, public device::ArmDevice {
 public:
  ListenedArm(std::unique_ptr<device::OpenedArm> arm, std::string_view wrong)
      : arm_(std::move(arm)), wrong_(wrong) {}
  device::ArmDevice& device() override { return *this; }
  Expected<void> look() override { return arm_->look(); }
  std::optional<device::HealthReport> health() override { return arm_->health(); }
  device::ArmFacts facts() const override { return arm_->facts(); }
  device::ArmSample read() override {
    device::ArmSample sample = arm_->device().read();
    if (wrong_.empty() || !Log::shared().felt()) return sample;
    if (!told_) Log::shared().write(0.0, Log::wrong);
    told_ = true;
    if (wrong_ == "sleeps") sleep_10_ms();
    if (wrong_ == "throws") throw std::runtime_error("the cable is out");
    if (wrong_ == "nan") sample.joints.setConstant(std::numeric_limits<double>::quiet_NaN());
    while (wrong_ == "hangs") sleep_10_ms();
    if (wrong_ == "crashes") std::raise(SIGSEGV);
    return sample;
  }
  void command(const Vector3& force) override {
    Log::shared().write(force.norm(), Log::commanded);
    arm_->device().command(force);
  }
  void let_go() noexcept override {
    Log::shared().write(0.0, Log::let_go);
    arm_->device().let_go();
  }

 private:
  std::unique_ptr<device::OpenedArm> arm_;
  std::string_view wrong_;
  bool told_ = false;
};

device::Driver listening_driver() {
  auto laboratory = std::make_shared<device::DriverRegistry>();
  drivers::laboratory::add_to(*laboratory);
  device::Driver driver;
  driver.scheme = "listened";
  driver.summary = "the laboratory's arm, and a file of what it is commanded";
  driver.simulated = true;
  driver.arm.emplace();
  driver.arm->form = "listened[:WRONG]";
  driver.arm->open =
      [laboratory](const device::ArmRequest& request) -> Expected<std::unique_ptr<device::OpenedArm>> {
    const std::size_t colon = request.uri.find(':');
    const std::string wanted = colon == std::string::npos ? "" : request.uri.substr(colon + 1);
    const auto* wrong = std::find(std::begin(kInRead), std::end(kInRead), wanted);
    if (wrong == std::end(kInRead)) return wrong_use("listened:{}: no such way to go wrong", wanted);
    device::ArmRequest inner = request;
    inner.uri = "lab";
    auto arm = laboratory->open(inner);
    if (!arm) return tl::unexpected(arm.error());
    return std::make_unique<ListenedArm>(std::move(*arm), *wrong);
  };
  return driver;
}

void add(plugin::Guests& guests) {
  guests.drivers.add(listening_driver());
  auto& applications = guests.applications;
  applications.add(guest("steady", InStep::nothing, InLaw::nothing));
  applications.add(guest("sleeper", InStep::nothing, InLaw::sleeps));
  applications.add(guest("hanger", InStep::nothing, InLaw::hangs));
  applications.add(guest("nan", InStep::nothing, InLaw::no_number));
  applications.add(guest("kilonewton", InStep::nothing, InLaw::kilonewton));
  applications.add(guest("crasher", InStep::nothing, InLaw::crashes));
  applications.add(guest("thrower", InStep::throws, InLaw::nothing));
  applications.add(guest("staller", InStep::hangs, InLaw::nothing));
  auto stillborn = guest("stillborn", InStep::nothing, InLaw::nothing);
  stillborn.make_physics = [](const scene::SceneDescription&,
                              const scene::RunSettings&) -> std::unique_ptr<scene::Application> {
    throw std::runtime_error("no level is there; install one");
  };
  applications.add(stillborn);
}

}  // namespace
}  // namespace hostile

PALPATE_PLUGIN("hostile", hostile::add)
