// A table written row by row, for what goes on too long to be kept in memory. Like every file it is there
// whole or not at all: rows go to a temporary neighbour, which finish() puts in place.
//
// One thread. A row that finds no space is remembered: finish() says so.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::inline core {

class CsvFile {
 public:
  ~CsvFile();
  CsvFile(CsvFile&&) noexcept;
  CsvFile& operator=(CsvFile&&) noexcept;

  // Wrong use where the folder is missing or may not be written to.
  static Expected<CsvFile> begin(const std::filesystem::path& path, const std::vector<std::string>& header);
  void row(const std::vector<std::string>& cells);
  void row(const std::vector<double>& values);
  // Once. Refused on a full disk: then the old file stays as it was.
  Expected<void> finish();

 private:
  struct Part;
  explicit CsvFile(std::unique_ptr<Part> part);
  std::unique_ptr<Part> part_;
};

}  // namespace palpate::inline core
