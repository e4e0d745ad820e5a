// The simulated devices behind the stand-in for the maker's libdhd.so: what a test sets and looks at.
//
// A program's test sets them by a file that the environment variable DHD_STUB_STATE names, read again and again: words
// "unplugged", "unpowered", "reset", "error", "button" (somebody switches the forces off), "place X Y Z" (m), "pressed N",
// "hand X Y Z" (m, a hand holds the handle there), "axis N" (its motors push the other way along it), "exchanged A B" (axes).
#pragma once

#include <mutex>
#include <string>

struct DhdStubDevice {
  std::mutex guard;  // around everything else
  // What a test sets.
  bool plugged = true, powered = true, reset = false, controller_error = false, in_use = false;
  int type = 33;
  const char* name = "omega.3";
  unsigned short serial = 0;
  bool wrist = false, wrist_initialised = true;
  double max_force = -1.0;  // N; negative: not limited
  double strength = 12.0;   // N, of its motors
  double place[3] = {0.0, 0.0, 0.0};
  double rotation[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  unsigned int buttons = 0;
  bool has_watchdog = true;
  int mirrored_axis = 0;  // 1 to 3; 0: none
  int exchanged[2] = {0, 0};
  // A hand on the handle, a spring and a damper without mass, for whose cycle each command counts.
  bool hand = false;
  double hand_at[3] = {0.0, 0.0, 0.0};
  double hand_stiffness = 300.0, hand_damping = 10.0;  // N/m, N s/m
  double clock_s = -1.0;                               // of its firmware; negative: the machine's
  // What it tells.
  bool open = false, forces_on = false;
  int off_cause = 0;
  double force[3] = {0.0, 0.0, 0.0};       // N, that its motors give
  double other[4] = {0.0, 0.0, 0.0, 0.0};  // torques, gripper
  double largest_force = 0.0;
  double watchdog_s = 0.0, commanded_at_s = 0.0;
  unsigned long commands = 0;
  int times_opened = 0;
};
