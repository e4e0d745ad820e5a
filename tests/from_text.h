// What a reader of files makes of a text, by way of a file in a scratch folder.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::tests {

template <typename Read>
auto from_text(const std::string& text, Read read) {
  const ScratchFolder scratch;
  const auto path = scratch / "table.csv";
  EXPECT_TRUE(write_file(path, text).has_value());
  return read(path);
}

}  // namespace palpate::tests
