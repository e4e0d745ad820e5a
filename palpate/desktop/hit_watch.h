// Follows the physics server's published states in a thread of its own and lets the person hear and see what
// a hand on the arm would feel.
//
// A contact lasts a few milliseconds, far less than a picture, so pictures cannot tell of it: this takes
// every state, a thousand a second. What it finds is told `delay` later, so that a hit is heard when it is
// seen. Thread `palpate-hits`, ordinary priority; everything here may be called from one other thread.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/desktop/sound_out.h"
#include "palpate/transport/server_place.h"
#include "palpate/transport/state_watch.h"

namespace palpate::desktop {

class HitWatch {
 public:
  // `masses` as HitDetector takes them; `sound` may be none. Refused where states cannot be watched.
  static Expected<std::unique_ptr<HitWatch>> begin(const transport::ServerPlace& place,
                                                   std::vector<double> masses,
                                                   std::unique_ptr<SoundOut> sound);
  ~HitWatch();

  // From a state's moment to its picture.
  void set_delay(double delay_s) { delay_s_.store(delay_s, std::memory_order_relaxed); }
  // The largest force of impacts since the last call, N.
  double take_force() { return force_.exchange(0.0, std::memory_order_relaxed); }
  // The force that lasts: what it was in the newest states on average, some thirty, N; 0: none does.
  double lasting_force() const { return lasting_.load(std::memory_order_relaxed); }
  std::uint64_t impacts() const { return impacts_.load(std::memory_order_relaxed); }  // on the hand
  std::uint64_t bounces() const { return bounces_.load(std::memory_order_relaxed); }  // of a body
  bool heard() const { return sound_ != nullptr; }

 private:
  HitWatch(std::unique_ptr<transport::StateWatch> watch, std::vector<double> masses,
           std::unique_ptr<SoundOut> sound);
  void run();

  std::unique_ptr<transport::StateWatch> watch_;
  std::vector<double> masses_;
  std::unique_ptr<SoundOut> sound_;
  std::atomic<bool> stop_{false};
  std::atomic<double> delay_s_{0.0}, force_{0.0}, lasting_{0.0};
  std::atomic<std::uint64_t> impacts_{0}, bounces_{0};
  std::thread thread_;
};

}  // namespace palpate::desktop
