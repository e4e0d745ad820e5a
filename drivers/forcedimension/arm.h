// Arms of Force Dimension (omega, delta, sigma, lambda) and Novint's Falcon, through the maker's library.
//
// A thread of its own ("palpate-dhd") talks with the device: drivers/arms/exchanged_arm.h says how.
//
// Frames: ArmBase is the device's own axes (dhd_abi.h). ArmSample::joints are the place of its handle, m
// (ArmModel::Kind::cartesian); gimbal angles are those of a wrist, where it has one. Its torques and its gripper's force
// stay 0.
//
// Forces are switched on at opening. Whoever switches them off at the device's button has them off: only what the device
// switches off because this program was late comes back by itself, along the start ramp. The device lets go of a force
// that is older than kLongestHold where its firmware can (`watchdog`). It is never moved to find its zero: that is left
// to a person. Refused at opening: library or device that cannot be had, with the reason and what to do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/arms/exchanged_arm.h"

namespace palpate::drivers::forcedimension {

struct ArmSettings {
  std::optional<int> serial;      // none: the first one that can be opened
  std::filesystem::path library;  // empty: library.h says where it is looked for
  arms::LoopSettings loop{};
};

// "forcedimension" or "forcedimension:SERIAL"; nothing for other texts.
std::optional<ArmSettings> settings_of(std::string_view uri);

struct ArmFacts {
  std::string model;  // "omega.3", as the library has it
  int serial = 0;
  std::string library, library_version;
  double peak_n = 0.0;  // as the library states it, or as is published for its kind
  bool wrist = false, left_handed = false;
  bool watchdog = false;  // the device itself lets go of an old force
};

class ForceDimensionArm : public device::ArmDevice {
 public:
  // Returns once the arm has told its state, from an ordinary thread.
  static Expected<std::unique_ptr<ForceDimensionArm>> open(const ArmSettings& settings);
  ~ForceDimensionArm() override;  // no force, then the device is given back

  // Stamped in the machine's monotonic clock.
  device::ArmSample read() override { return arm_->read(); }
  void command(const Vector3& force) override { arm_->command(force); }
  void let_go() noexcept override { arm_->let_go(); }

  arms::ExchangedArmStatus status() const { return arm_->status(); }
  const ArmFacts& facts() const;
  // Times the device could not give as much as it was asked for.
  std::uint64_t saturations() const;

 private:
  struct Known;
  ForceDimensionArm(std::unique_ptr<Known> known, std::unique_ptr<arms::ExchangedArm> arm);
  std::unique_ptr<Known> known_;  // the exchange uses it
  std::unique_ptr<arms::ExchangedArm> arm_;
};

// Opens the device, asks who it is and gives it back, without a force.
Expected<ArmFacts> probe_arm(const ArmSettings& settings);

}  // namespace palpate::drivers::forcedimension
