// The fine structure of painted and wooden things: smooth noise that repeats without a seam. Pure function.
#pragma once

#include <cstdint>
#include <vector>

namespace palpate::sim {

// size x size bytes about 128; the same every time. Five octaves of interpolated random values.
std::vector<std::uint8_t> grain(int size);

}  // namespace palpate::sim
