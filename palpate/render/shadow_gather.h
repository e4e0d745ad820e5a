// The mean of a planar shadow's sixteen tiles, by the processor: what planar_shadow.cpp's shader computes on a graphics card.
//
// A software renderer takes five times as long for its look-ups. Both agree to a level (shadow_gather_test.cpp). Pure; any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace palpate::render {

// `tiles`: 4 x 4 tiles of size x size texels, two bytes each: hidden by virtual bodies, by real ones; rows packed. `result`: size x
// size texels of two bytes: the share of the lamp that any body hides, that real ones hide. Other sizes throw
// std::invalid_argument.
void gather_tiles(std::span<const std::uint8_t> tiles, int size, std::vector<std::uint8_t>& result);

}  // namespace palpate::render
