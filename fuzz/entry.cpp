// One fuzz program: libFuzzer's entry points for the target PALPATE_FUZZ_TARGET.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

#include "fuzz/table_mutator.h"
#include "fuzz/targets.h"

extern "C" {

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  palpate::fuzz::PALPATE_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}

std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

// Half the time by bytes, half the time as a table where it is one.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                    unsigned int seed) {
  const std::string_view file(reinterpret_cast<const char*>(data), size);
  if (seed % 2 == 0 || !palpate::fuzz::is_table(file)) return LLVMFuzzerMutate(data, size, max_size);
  const std::string changed = palpate::fuzz::changed_table(file, seed);
  const std::size_t kept = std::min(changed.size(), max_size);
  std::memcpy(data, changed.data(), kept);
  return kept;
}
}
