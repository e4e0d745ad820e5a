#include "palpate/record/recording_copy.h"

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "palpate/core/text.h"
#include "palpate/record/internal/channel_numbers.h"
#include "palpate/record/mcap_writer.h"
#include "palpate/record/recording_info.h"

namespace palpate::record {
namespace {

// Writes what a scan hands over. The file begins with the first of it: only then the header of the original is known.
class Copier : public ScanHandler {
 public:
  Copier(std::filesystem::path out, const ScanResult& known) : out_(std::move(out)), header_(known.header) {}

  Expected<void> message(const HeardMessage& heard) override {
    if (auto ready = begin(); !ready) return ready;
    const auto number = numbers_.of(heard.channel, heard.schema, heard.message.channel, *writer_);
    if (!number) return tl::unexpected(number.error());
    Message message = heard.message;
    message.channel = *number;
    return writer_->write(message);
  }
  Expected<void> attachment(const Attachment& attachment) override {
    if (auto ready = begin(); !ready) return ready;
    return writer_->attach(attachment);
  }
  Expected<void> metadata(const Metadata& metadata) override {
    if (auto ready = begin(); !ready) return ready;
    return writer_->write(metadata);
  }

  const Statistics* statistics() const { return writer_ ? &writer_->statistics() : nullptr; }
  Expected<Statistics> close(const Metadata& of_copy) {
    if (auto ready = begin(); !ready) return tl::unexpected(ready.error());
    if (auto done = writer_->write(of_copy); !done) return tl::unexpected(done.error());
    return writer_->close();
  }

 private:
  Expected<void> begin() {
    if (writer_) return {};
    auto file = RecordFile::whole(out_);
    if (!file) return tl::unexpected(file.error());
    WriterOptions options;
    options.header = header_;
    auto writer = McapWriter::begin(std::move(*file), options);
    if (!writer) return tl::unexpected(writer.error());
    writer_ = std::make_unique<McapWriter>(std::move(*writer));
    return {};
  }
  std::filesystem::path out_;
  FileHeader header_;
  std::unique_ptr<McapWriter> writer_;
  ChannelNumbers numbers_;
};

}  // namespace

std::uint64_t later(std::uint64_t start, double s) {
  const double ns = std::max(0.0, s) * 1e9;
  const auto most = std::numeric_limits<std::uint64_t>::max() - start;
  return ns >= static_cast<double>(most) ? start + most
                                         : start + static_cast<std::uint64_t>(std::llround(ns));
}

Expected<CopyReport> repair(ByteSource& source, const std::filesystem::path& out) {
  // Twice: what is lost is known before the copy begins, and the copy's header is that of the original.
  ScanHandler nobody;
  const ScanOptions everything;
  auto before = scan(source, everything, nobody);
  if (!before) return tl::unexpected(before.error());
  const auto& found = before->found;
  if (found.messages == 0 && found.attachments == 0 && found.metadata == 0)
    return refused("{}: holds nothing that is sound{}; a recording in MCAP is expected", source.name(),
                   first_fault(*before));
  Copier copier(out, *before);
  if (auto again = scan(source, everything, copier); !again) return tl::unexpected(again.error());
  const auto written = copier.close({kRepairMetadata,
                                     {{"faults", std::to_string(before->fault_count)},
                                      {"lost_bytes", std::to_string(before->lost_bytes)},
                                      {"lost_chunks", std::to_string(before->lost_chunks)},
                                      {"lost_s", fmt::format("{:.3f}", before->lost_s)}}});
  if (!written) return tl::unexpected(written.error());
  return CopyReport{std::move(*before), *written};
}

Expected<CopyReport> cut(ByteSource& source, const std::filesystem::path& out, const Cut& cut) {
  ScanHandler nobody;
  auto before = scan(source, {}, nobody);
  if (!before) return tl::unexpected(before.error());
  if (!before->complete)
    return refused("{}: is not whole{}; palpate recording repair makes a whole one of it", source.name(),
                   first_fault(*before));
  ScanOptions part;
  part.topics = cut.topics;
  part.from_ns = later(before->found.start_ns, cut.from_s);
  part.to_ns = later(before->found.start_ns, cut.to_s);
  Copier copier(out, *before);
  if (auto again = scan(source, part, copier); !again) return tl::unexpected(again.error());
  if (copier.statistics() == nullptr || copier.statistics()->messages == 0) {
    std::string topics;
    for (const auto& topic : cut.topics) topics += (topics.empty() ? "of " : ", ") + excerpt(topic);
    return refused("{}: holds no message {}{}from {} s to {}; it lasts {:.3f} s, give other times{}",
                   source.name(), topics, topics.empty() ? "" : " ", cut.from_s,
                   std::isfinite(cut.to_s) ? fmt::format("{} s", cut.to_s) : "its end",
                   seconds_of(before->found),
                   topics.empty() ? "" : " or topics (palpate recording info lists them)");
  }
  const auto written = copier.close(
      {kCutMetadata, {{"from_s", fmt::format("{}", cut.from_s)}, {"to_s", fmt::format("{}", cut.to_s)}}});
  if (!written) return tl::unexpected(written.error());
  return CopyReport{std::move(*before), *written};
}

}  // namespace palpate::record
