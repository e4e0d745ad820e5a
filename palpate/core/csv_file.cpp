#include "palpate/core/csv_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/part_file.h"
#include "palpate/core/system_error.h"

namespace palpate::inline core {

struct CsvFile::Part {
  Part(std::filesystem::path target, PartFile begun, std::size_t width)
      : path(std::move(target)), place(std::move(begun)), columns(width) {}
  ~Part() {
    if (file != nullptr) std::fclose(file);
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  std::filesystem::path path;
  PartFile place;
  std::size_t columns = 0;
  std::FILE* file = nullptr;
  int error = 0;  // errno of the first row that failed
};

CsvFile::CsvFile(std::unique_ptr<Part> part) : part_(std::move(part)) {}
CsvFile::~CsvFile() = default;
CsvFile::CsvFile(CsvFile&&) noexcept = default;
CsvFile& CsvFile::operator=(CsvFile&&) noexcept = default;

Expected<CsvFile> CsvFile::begin(const std::filesystem::path& path, const std::vector<std::string>& header) {
  auto place = PartFile::begin(path);
  if (!place) return tl::unexpected(place.error());
  auto part = std::make_unique<Part>(path, std::move(*place), header.size());
  // A descriptor of its own, for fclose() closes it; both are of one open file, whose lock they share.
  const int fd = ::dup(part->place.fd());
  part->file = fd < 0 ? nullptr : ::fdopen(fd, "w");
  if (part->file == nullptr) {
    const int error = errno;
    if (fd >= 0) ::close(fd);
    return refused("{}: cannot be written ({})", path.string(), reason_of(error));
  }
  CsvFile table(std::move(part));
  table.row(header);
  return table;
}

void CsvFile::row(const std::vector<std::string>& cells) {
  if (cells.size() != part_->columns) throw std::logic_error("CsvFile: row width differs from the header's");
  std::string line;
  for (const auto& cell : cells) line += cell + ',';
  line.back() = '\n';
  if (std::fwrite(line.data(), 1, line.size(), part_->file) != line.size() && part_->error == 0)
    part_->error = errno;
}

void CsvFile::row(const std::vector<double>& values) {
  std::vector<std::string> cells;
  for (double value : values) cells.push_back(number_text(value));
  row(cells);
}

Expected<void> CsvFile::finish() {
  const bool flushed = std::fflush(part_->file) == 0;
  const char* failed = "writing";
  if (part_->error == 0 && flushed) failed = part_->place.put_in_place(static_cast<unsigned>(FileMode::all));
  if (failed == nullptr) return {};
  return refused("{}: {} failed ({}); nothing was changed, free some space and try again",
                 part_->path.string(), failed, reason_of(part_->error != 0 ? part_->error : errno));
}

}  // namespace palpate::inline core
