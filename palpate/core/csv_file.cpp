#include "palpate/core/csv_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"

namespace palpate::inline core {

CsvFile::Part::~Part() {
  if (file != nullptr) std::fclose(file);
  if (!name.empty()) ::unlink(name.c_str());
}

Expected<CsvFile> CsvFile::begin(const std::filesystem::path& path, const std::vector<std::string>& header) {
  auto part = std::make_unique<Part>();
  part->path = path;
  std::string name = path.string() + ".part-XXXXXX";
  const int fd = ::mkstemp(name.data());
  if (fd < 0)
    return wrong_use("{}: cannot be written ({}); check the folder and its permissions", path.string(),
                     std::strerror(errno));
  part->name = name;
  part->columns = header.size();
  part->file = ::fdopen(fd, "w");
  if (part->file == nullptr) {
    ::close(fd);
    return refused("{}: cannot be written ({})", path.string(), std::strerror(errno));
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
  std::FILE* file = part_->file;
  const bool flushed = std::fflush(file) == 0;
  if (part_->error == 0 && (!flushed || ::fsync(::fileno(file)) != 0 ||
                            ::fchmod(::fileno(file), static_cast<mode_t>(FileMode::all)) != 0 ||
                            ::rename(part_->name.c_str(), part_->path.c_str()) != 0))
    part_->error = errno;
  if (part_->error != 0)
    return refused("{}: writing failed ({}); nothing was changed, free some space and try again",
                   part_->path.string(), std::strerror(part_->error));
  part_->name.clear();
  return {};
}

}  // namespace palpate::inline core
