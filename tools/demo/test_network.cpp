#include "tools/demo/test_network.h"

#include <signal.h>

#include <cerrno>
#include <charconv>

#include "palpate/core/run_directory.h"
#include "palpate/time/clock.h"
#include "palpate/transport/keys.h"

namespace palpate::tools::demo {
namespace fs = std::filesystem;
namespace {

constexpr int kLegPort = 5555;  // nobody else is in these networks
constexpr std::string_view kKeysOf = ".keys";

std::int64_t monotonic_ns() { return MonotonicClock<GraphicsClock>::monotonic_ns(); }

// Keys of runs that were killed: NAME-PID.keys of processes that are no more.
void remove_keys_of_the_dead(const fs::path& place) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(place, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(kKeysOf)) continue;
    const std::string_view number = std::string_view(name).substr(
        name.rfind('-') + 1, name.size() - name.rfind('-') - 1 - kKeysOf.size());
    pid_t pid = 0;
    const auto parsed = std::from_chars(number.data(), number.data() + number.size(), pid);
    if (parsed.ec != std::errc() || parsed.ptr != number.data() + number.size() || pid <= 0) continue;
    if (::kill(pid, 0) != 0 && errno == ESRCH) fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

TestNetwork::ScratchKeys::~ScratchKeys() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

TestNetwork::TestNetwork(TwoHosts hosts, const TwoHostsOptions& options)
    : hosts_(std::move(hosts)),
      options_(options),
      address_(fmt::format("tcp://{}:{}", TwoHosts::kPlaces[TwoHosts::kPhysicsHost], kLegPort)) {}

Expected<TestNetwork> TestNetwork::make(const std::string& name, const TwoHostsOptions& options) {
  auto hosts = TwoHosts::make();
  if (!hosts) return tl::unexpected(hosts.error());
  TestNetwork network(std::move(*hosts), options);
  if (!options.insecure)
    if (auto made = network.make_keys(name); !made) return tl::unexpected(made.error());
  return network;
}

// As a person does with `palpate keys new`, `authorize` and `trust`.
Expected<void> TestNetwork::make_keys(const std::string& name) {
  const auto place = run_directory();
  if (!place) return tl::unexpected(place.error());
  remove_keys_of_the_dead(*place);
  const auto folder = private_directory(*place / (name + std::string(kKeysOf)));
  if (!folder) return tl::unexpected(folder.error());
  keys_ = ScratchKeys(*folder);
  const auto physics = transport::make_key_pair(), graphics = transport::make_key_pair();
  if (!physics) return tl::unexpected(physics.error());
  if (!graphics) return tl::unexpected(graphics.error());
  if (auto done = transport::write_key_pair(*folder / "physics", *physics, false); !done) return done;
  if (auto done = transport::write_key_pair(*folder / "graphics", *graphics, false); !done) return done;
  if (auto done = transport::authorize_key(
          *folder / "physics", {transport::Role::graphics, graphics->public_key, "graphics-host"});
      !done)
    return done;
  return transport::trust_server(*folder / "graphics", address_, physics->public_key);
}

transport::ServerName TestNetwork::server(const char* who) const {
  transport::ServerName name;
  name.address = address_;
  name.insecure = options_.insecure;
  if (!options_.insecure) name.keys = keys_.folder() / who;
  return name;
}

Expected<ChildProcess> TestNetwork::start(TwoHosts::Host host, const fs::path& program,
                                          const std::vector<std::string>& arguments,
                                          const fs::path& log) const {
  std::optional<Expected<ChildProcess>> child;
  if (auto done = hosts_.at(host, [&] { child.emplace(ChildProcess::start(program, arguments, log)); });
      !done)
    return tl::unexpected(done.error());
  return std::move(*child);
}

Expected<void> TestNetwork::look(double before_s) {
  const std::int64_t now = monotonic_ns();
  if (begun_ns_ == 0) begun_ns_ = now;
  const auto passed = [now](std::int64_t since, double s) {
    return 1e-9 * static_cast<double>(now - since) >= s;
  };
  if (pulled_ns_ == 0) {
    if (!passed(begun_ns_, before_s)) return {};
    if (auto done = hosts_.plug(false); !done) return done;
    pulled_ns_ = monotonic_ns();
  } else if (plugged_ns_ == 0 && passed(pulled_ns_, options_.cut_s)) {
    // Both stamps lie within the time without a cable: nothing can come through between them.
    const std::int64_t before_ns = monotonic_ns();
    if (auto done = hosts_.plug(true); !done) return done;
    plugged_ns_ = before_ns;
  }
  return {};
}

Expected<TestNetwork::Cut> TestNetwork::cut() const {
  if (plugged_ns_ == 0) return refused("two hosts: the run ended before its cable was plugged in again");
  return Cut{pulled_ns_, plugged_ns_};
}

}  // namespace palpate::tools::demo
