// Writes a recording as a session does, for the program's tests: sample_recording FILE
#include <cstdio>
#include <string>

#include "palpate/record/session_writer.h"

namespace {

using namespace palpate;

constexpr std::uint64_t kStartNs = 1'700'000'000'000'000'000;

Expected<void> write_sample(const char* path) {
  auto file = record::RecordFile::growing(path);
  if (!file) return tl::unexpected(file.error());
  record::SessionOptions options;
  options.writer.chunk_bytes = 64 * 1024;
  auto session = record::SessionWriter::begin(std::move(*file), options);
  if (!session) return tl::unexpected(session.error());
  auto& arm = (*session)->add({"palpate.Arm", "jsonschema", R"({"type":"object"})"},
                              {"/arm/sample", "json", 0, {{"clock", "arm"}}});
  auto& picture = (*session)->add({}, {"/camera/left/image", "", 0, {}});
  (*session)->add({}, {"/trip", "", 0, {}});  // of which none comes
  for (const char* name : {"rig.toml", "world.toml"})
    if (auto done = (*session)->attach({kStartNs, kStartNs, name, "application/toml", "name = \"lab\"\n"});
        !done)
      return done;
  if (auto done = (*session)->write(record::Metadata{"session", {{"id", "1"}}}); !done) return done;
  // Three seconds, of which the last millisecond is the 2999th.
  for (std::uint64_t ms = 0; ms < 3000; ++ms) {
    const auto now = kStartNs + ms * 1'000'000;
    if (!arm.write(now, now, "{\"joints\":[" + std::to_string(ms) + ",0.5,0.25]}"))
      return refused("the queue is full; room is expected");
    std::string pixels(20'000, '\0');
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<char>(i * i + ms);
    if (ms % 100 == 0 && !picture.write(now, now, pixels))
      return refused("the queue is full; room is expected");
  }
  const auto report = (*session)->close();
  return report.error ? tl::unexpected(*report.error) : Expected<void>{};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const auto done = write_sample(argv[1]);
  if (!done) std::fprintf(stderr, "%s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
