// Runs the same experiment many times on several threads, with results that do not depend on how many there
// are.
//
// `run(i)` is called once for each i in 0 ... count-1, in any order, from any thread; it writes to a slot of
// its own and draws its chance from repeat_seed(seed, purpose, i). What it throws stops the others and is
// thrown again here. `progress` (share done, 0 ... 1) is called from the calling thread alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

namespace palpate::evaluation::studies {

struct RepeatSettings {
  int threads = 0;  // 0: as many as the machine has cores
  std::function<void(double)> progress;
};

void repeat(std::size_t count, const RepeatSettings& settings, const std::function<void(std::size_t)>& run);

// A seed of its own for each purpose and repeat.
std::uint64_t repeat_seed(std::uint64_t seed, std::string_view purpose, std::size_t index);

}  // namespace palpate::evaluation::studies
