// Short sounds through the machine's speakers (OpenAL).
//
// Refused, with the reason, where there is no sound device; whoever wanted to be heard goes on without. One
// thread; play() does not wait for the sound.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "palpate/core/expected.h"

namespace palpate::desktop {

class SoundOut {
 public:
  static Expected<std::unique_ptr<SoundOut>> open();
  ~SoundOut();

  // 16 bit, mono, kSoundRate. Up to eight at a time; the oldest makes way.
  void play(std::span<const std::int16_t> samples);
  const std::string& device() const;  // as the library names it

 private:
  struct Impl;
  explicit SoundOut(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::desktop
