// How tests arrange the devices of the stand-in for libHD.so: what they are, and what happens to them.
//
// A device obeys its own kinematics, in millimetres, and its own idea of which turn of the turret is
// positive; nothing is shared with the driver. Everything in HdStubDevice under its guard. From another
// process: the file named by the environment variable HD_STUB_STATE holds words ("unplugged", "warm",
// "over"; "hand 0.1 0.2 0.3": a hand holds the stylus at these joint angles; "button 1"; "axis 1", "exchanged 2 3",
// "torques 1 0 1": faults of the motors), read every few cycles. HD_STUB_ARM names the socket of an arm in another
// process (arm_line.h): that is the default device then, and the library's cycles are its readings.
#pragma once

#include <cstdint>
#include <mutex>

struct HdStubDevice {
  std::mutex guard;
  const char* name = "";

  // What it is.
  const char* serial = "0042";
  double link_1_mm = 209.55, link_2_mm = 209.55;
  double origin_mm[3] = {0.0, 0.0, 0.0};                 // added to every position
  bool turret_left = false;                              // positive to the user's left
  double nominal_force = 8.5, nominal_continuous = 1.4;  // as it states them
  double true_force = 8.5;                               // above: HD_EXCEEDED_MAX_FORCE
  int input_dof = 6, calibration_style = 4;              // inkwell
  unsigned calibration = 0x5000;                         // OK
  // What happens to it.
  double turned[3] = {0.0, 0.0, 0.0};  // true joint angles: turret right, thigh up, shin up; rad
  double gimbal[3] = {0.0, 0.0, 0.0};  // right, up, clockwise; rad
  bool plugged = true;
  bool joints_broken = false;  // readings are not numbers
  unsigned buttons = 0;        // pressed ones, the first is bit 0
  // A hand that holds the stylus lightly where these joint angles put it: without it the stylus stands, whatever the
  // motors do.
  bool hand = false;
  double hand_at[3] = {0.0, 0.0, 0.0};                 // rad
  double hand_stiffness = 250.0, hand_damping = 10.0;  // N/m, N s/m
  // Motors that are wired wrongly.
  int mirrored_axis = 0;      // of a commanded force: 1 x, 2 y, 3 z
  int exchanged[2] = {0, 0};  // joints, counted from 1
  double torque_gain[3] = {1.0, 1.0, 1.0};
  bool slipped = false;     // readings of the thigh do not follow it any more
  unsigned init_error = 0;  // of the next hdInitDevice
  unsigned error = 0;       // of the next `error_cycles` cycles
  int error_cycles = 0;
  bool blocked = false;  // hdBeginFrame does not return
  bool inside_begin = false;
  // What it has felt.
  bool open = false;
  int times_opened = 0, times_calibrated = 0;
  bool calibrated_under_force = false;
  std::uint64_t cycles = 0;            // ended
  double force[3] = {0.0, 0.0, 0.0};   // N, given now
  double torque[3] = {0.0, 0.0, 0.0};  // N m, of its joints, as positive as `turned`
  double largest_force = 0.0;          // ever given, N
};

extern "C" {
// 0: the default device, 1: "Left", 2: "Right"; nothing beyond.
HdStubDevice* hd_stub_device(int number);
// Everything as at the start; no device may be open.
void hd_stub_reset();
// The scheduler goes on running but calls nobody.
void hd_stub_freeze(bool frozen);
int hd_stub_schedulers();  // 1 while it runs
}
