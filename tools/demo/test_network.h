// What the real-time run needs to play on two hosts: the hosts, keys made for this one run, and a cable that
// is pulled in its middle.
//
// One thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/child_process.h"
#include "palpate/core/expected.h"
#include "palpate/transport/server_place.h"
#include "tools/demo/two_hosts.h"

namespace palpate::tools::demo {

struct TwoHostsOptions {
  bool insecure = false;  // without keys: for whoever wants to see what encryption hides
  double cut_s = 3.0;     // how long the cable is out
};

class TestNetwork {
 public:
  // Keys lie in a private folder that goes with this object. `name` is the run's.
  static Expected<TestNetwork> make(const std::string& name, const TwoHostsOptions& options);

  Expected<ChildProcess> start(TwoHosts::Host host, const std::filesystem::path& program,
                               const std::vector<std::string>& arguments,
                               const std::filesystem::path& log) const;
  transport::ServerName listen() const { return server("physics"); }
  transport::ServerName connect() const { return server("graphics"); }
  const std::string& address() const { return address_; }
  bool encrypted() const { return !options_.insecure; }

  // Call every few milliseconds while both servers play: pulls the cable when `before_s` of play are over,
  // and plugs it in again.
  Expected<void> look(double before_s);
  // CLOCK_MONOTONIC when the cable was pulled and when it was in again; refused where it did not come to
  // that.
  struct Cut {
    std::int64_t pulled_ns = 0, plugged_ns = 0;
  };
  Expected<Cut> cut() const;

 private:
  // A folder that goes when this object does.
  class ScratchKeys {
   public:
    explicit ScratchKeys(std::filesystem::path folder = {}) : folder_(std::move(folder)) {}
    ScratchKeys(ScratchKeys&& other) noexcept : folder_(std::exchange(other.folder_, {})) {}
    ScratchKeys& operator=(ScratchKeys&& other) noexcept {
      std::swap(folder_, other.folder_);
      return *this;
    }
    ~ScratchKeys();
    const std::filesystem::path& folder() const { return folder_; }

   private:
    std::filesystem::path folder_;
  };

  TestNetwork(TwoHosts hosts, const TwoHostsOptions& options);
  Expected<void> make_keys(const std::string& name);
  transport::ServerName server(const char* who) const;

  TwoHosts hosts_;
  TwoHostsOptions options_;
  std::string address_;
  ScratchKeys keys_;
  std::int64_t begun_ns_ = 0, pulled_ns_ = 0, plugged_ns_ = 0;
};

}  // namespace palpate::tools::demo
