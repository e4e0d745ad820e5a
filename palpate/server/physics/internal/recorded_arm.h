// An arm whose readings are those of a recording: whoever executes it again sets each before its tick. What it is commanded goes
// nowhere. Private to the module.
#pragma once

#include <optional>
#include <utility>

#include "palpate/device/opened.h"

namespace palpate::server::physics {

class RecordedArm : public device::ArmDevice, public device::JointMotors {
 public:
  explicit RecordedArm(std::optional<device::JointVector> torque_limits)
      : torque_limits_(std::move(torque_limits)) {}
  void set(const device::ArmSample& sample) { sample_ = sample; }

  device::ArmSample read() override { return sample_; }
  void command(const Vector3&) override {}
  device::JointMotors* motors() override { return torque_limits_ ? this : nullptr; }
  void let_go() noexcept override {}
  void command(const device::JointVector&) override {}
  device::JointVector limits() const override { return *torque_limits_; }

 private:
  std::optional<device::JointVector> torque_limits_;
  device::ArmSample sample_;
};

class OpenedRecordedArm : public device::OpenedArm {
 public:
  OpenedRecordedArm(device::ArmFacts facts, std::optional<device::JointVector> torque_limits)
      : facts_(std::move(facts)), arm_(std::move(torque_limits)) {}
  RecordedArm& device() override { return arm_; }
  device::ArmFacts facts() const override { return facts_; }

 private:
  device::ArmFacts facts_;
  RecordedArm arm_;
};

}  // namespace palpate::server::physics
