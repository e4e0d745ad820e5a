// The sound of an impact or a bounce, made from its impulse: a handful of damped tones.
//
// Hard things that meet ring at a few frequencies, each dying away by itself; a harder impact is louder and,
// because it is shorter, brighter. The frequencies are chosen by ear: low and woody for what the hand holds,
// high and dry for a ball on a table. 16 bit, mono, kSoundRate samples per second. Pure, deterministic.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/desktop/hit_detector.h"

namespace palpate::desktop {

inline constexpr int kSoundRate = 48000;
inline constexpr double kSoundLength_s = 0.12;

// Frequency of the loudest tone, Hz.
double pitch_of(HitKind kind);

// Loudness rises with the impulse (N s) and levels off below full scale; silence for none.
std::vector<std::int16_t> hit_sound(HitKind kind, double impulse);

}  // namespace palpate::desktop
