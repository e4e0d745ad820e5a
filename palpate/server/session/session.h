// A running session in one process: haptic loop, physics loop and frame loop in threads of their own on the machine's
// clock. What a program of one's own starts where it does not want separate servers (session_setup.h has an example).
//
// The two sides meet over a socket private to this user, as the servers do, so that others may look on: `palpate
// status --connect`, a graphics server on this machine. Main thread: start(), look(), stop() and what says so.
// Errors: start() refuses where a part cannot be had; look() where one has gone for good.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/server/physics/physics_loops.h"
#include "palpate/server/session/session_setup.h"

namespace palpate::server::session {

struct RealTime {
  std::string
      endpoint;  // where it serves, as `palpate physics --listen`; empty: a socket named after this process
  bool real_time = true;  // ask for SCHED_FIFO; it runs without it as well
  // Each finished frame, on the frame loop's thread; valid until it returns.
  std::function<void(const graphics::FrameRecord&)> shown;
};

class Session {
 public:
  // Returns when the loops run and the frame loop has opened its devices.
  static Expected<std::unique_ptr<Session>> start(const SessionSetup& setup, const RealTime& how);
  ~Session();  // stops
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // To be called every 20 ms or so while it runs. What a person should know is then in the log, of the part "session".
  // Refused where an arm, a camera or a tracker has gone for good, or where the application or a driver has taken a loop's
  // thread and does not come back. Of the latter stop() would wait for ever: forces are off by then, and the program is
  // to end (std::_Exit).
  Expected<void> look();
  // Returns when all loops have ended; a second call does nothing.
  void stop();

  // A person's wish: the next round, a pause. Any thread.
  void control(scene::Control wish);

  std::uint64_t frames() const;  // finished so far; any thread
  const std::string& endpoint() const;
  // Its server may be asked from any thread for what PhysicsServer says so.
  const physics::PhysicsSide& physics() const;

 private:
  struct Parts;
  explicit Session(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate::server::session
